//! Semismooth Newton iteration in the displacements, for programs in which every force has a
//! compliance.
//!
//! Given u, the forces of a contact are the projection of its elastic trial onto its limits in the
//! metric of the compliances; the balance is then the gradient of a convex, piecewise quadratic
//! function of u, and its generalised Hessian is the condensed matrix of the current regions. The
//! line search is exact: the derivative along the step is monotone and piecewise linear.

use super::interior::{add_blocks, factorise};
use super::local::{Adjacency, eliminate};
use super::matrix::BodyMatrix;
use super::scaled::{Local, Scaled};

/// What ends the iteration, and what damps it.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Factorisations at most.
    pub iterations: u32,
    /// So many tiny steps in a row.
    pub tiny: u32,
    /// Unbalance over the greatest force at which it is done,
    pub goal: f64,
    /// or unbalance in units of force.
    pub unbalance: f64,
    /// Added to the diagonal of the first matrix, and the least to which it falls: keeps a step
    /// short where nothing is stiff.
    pub damping: f64,
    /// See `damping`.
    pub least_damping: f64,
}

/// Of the whole program: the interior point takes over where it does not converge.
const GLOBAL: Limits = Limits {
    iterations: 16,
    tiny: 4,
    goal: 1e-10,
    unbalance: 0.0,
    damping: 1e-10,
    least_damping: 1e-10,
};
/// Steps shorter than this mean that every loose cluster holds all others back.
const TINY: f64 = 0.02;
/// [Local elimination](eliminate) comes before a global step where the unbalance over the greatest
/// force is more than this and the last step was shorter than that.
const UNBALANCED: f64 = 1e-5;
const SHORT: f64 = 0.7;

/// Result of the iteration, converged or not.
pub struct Newton {
    /// Displacements.
    pub u: Vec<[f64; 3]>,
    /// Forces.
    pub s: Vec<[f64; 3]>,
    /// Factorisations.
    pub iterations: u32,
}

/// Whether every force of the program has a compliance.
#[must_use]
pub fn applies(program: &Scaled) -> bool {
    program
        .locals
        .iter()
        .all(|l| !l.has[2] && l.compliance[0] > 0.0 && (!l.has[1] || l.compliance[1] > 0.0))
}

/// Projection of the elastic trial (p, q), with the derivative of (p, q) by (e_n, e_t).
pub(super) fn project(l: &Local, e: &[f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let kn = 1.0 / l.compliance[0];
    let pt = (e[0] - l.linear[0]) * kn;
    let mut d = [[0.0; 3]; 3];
    if !l.has[1] {
        let low = -l.right[0];
        if pt > low {
            d[0][0] = kn;
            return ([pt, 0.0, 0.0], d);
        }
        return ([low, 0.0, 0.0], d);
    }
    let kt = 1.0 / l.compliance[1];
    let qt = (e[1] - l.linear[1]) * kt;
    let mu = -l.limits[0][0];
    let cohesion = l.right[0];
    let tension = if l.count == 3 { l.right[2] } else { f64::INFINITY };
    let sign = if qt < 0.0 { -1.0 } else { 1.0 };
    let size = qt.abs();
    // The corner of the limits: where tension cuts the shear cone, or the cone's own apex.
    let at_tension = cohesion - mu * tension;
    let (p0, q0) = if at_tension >= 0.0 { (-tension, at_tension) } else { (-cohesion / mu, 0.0) };
    let over = size - cohesion - mu * pt;
    if over <= 0.0 {
        if pt >= p0 {
            d[0][0] = kn;
            d[1][1] = kt;
            return ([pt, qt, 0.0], d);
        }
        if size <= q0 && q0 > 0.0 {
            d[1][1] = kt;
            return ([p0, qt, 0.0], d);
        }
        return ([p0, sign * q0.min(size), 0.0], d);
    }
    if pt < p0 && size <= q0 {
        if q0 > 0.0 {
            d[1][1] = kt;
        }
        return ([p0, qt, 0.0], d);
    }
    let sum = kt + mu * mu * kn;
    let slip = over / sum;
    let p = pt + mu * kn * slip;
    if p >= p0 {
        let (vn, vt) = (-mu * kn, sign * kt);
        d[0][0] = kn - vn * vn / sum;
        d[0][1] = -vn * vt / sum;
        d[1][0] = d[0][1];
        d[1][1] = kt - vt * vt / sum;
        return ([p, sign * (size - kt * slip), 0.0], d);
    }
    ([p0, sign * q0, 0.0], d)
}

/// Solves the program from the displacements `start`, with local elimination, until the unbalance over
/// the greatest force is at most `goal`.
#[must_use]
pub fn solve(program: &Scaled, matrix: &mut BodyMatrix, start: &[[f64; 3]], goal: f64) -> Newton {
    iterate(program, matrix, start, &Limits { goal, ..GLOBAL }, Some(&Adjacency::new(program)))
}

/// Runs the iteration from the displacements `start`; with local elimination where the adjacency of
/// the program is given.
#[must_use]
pub fn iterate(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    limits: &Limits,
    adjacency: Option<&Adjacency>,
) -> Newton {
    let n = program.free.len();
    let mut u: Vec<[f64; 3]> = (0..n)
        .map(|i| {
            [0, 1, 2].map(|k| if program.free[i][k] { start[i][k] } else { program.known[i][k] })
        })
        .collect();
    let m = program.locals.len();
    let (mut s, mut d) = (vec![[0.0; 3]; m], vec![[[0.0; 3]; 3]; m]);
    let mut e = vec![[0.0; 3]; m];
    let mut iterations = 0;
    let mut tiny = 0;
    let mut step = 0.0;
    let mut eliminated = false;
    let mut damping = limits.damping;
    loop {
        for (k, l) in program.locals.iter().enumerate() {
            e[k] = Scaled::kinematics(l, &u);
            (s[k], d[k]) = project(l, &e[k]);
        }
        let mut gradient: Vec<[f64; 3]> = (0..n)
            .map(|i| {
                [0, 1, 2].map(|k| {
                    if program.free[i][k] {
                        program.weight[i][k] * u[i][k] - program.right[i][k]
                    } else {
                        0.0
                    }
                })
            })
            .collect();
        for (l, s) in program.locals.iter().zip(&s) {
            Scaled::add_forces(l, s, 1.0, &mut gradient);
        }
        let force = s.iter().map(|s| s[0].abs().max(s[1].abs())).fold(1e-3, f64::max);
        let unbalance = gradient.iter().flatten().map(|g| g.abs()).fold(0.0, f64::max);
        let finite = gradient.iter().flatten().all(|g| g.is_finite());
        let done = iterations >= limits.iterations || tiny >= limits.tiny;
        if !finite || unbalance <= (limits.goal * force).max(limits.unbalance) || done {
            break;
        }
        if let Some(adjacency) = adjacency
            && !std::mem::replace(&mut eliminated, true)
            && unbalance > UNBALANCED * force
            && step < SHORT
            && eliminate(program, adjacency, &gradient, &e, &mut u)
        {
            continue;
        }
        eliminated = false;
        iterations += 1;
        matrix.values.iter_mut().for_each(|v| *v = 0.0);
        for i in 0..n {
            for k in 0..3 {
                let weight = if program.free[i][k] { program.weight[i][k] + damping } else { 1.0 };
                matrix.values[matrix.diagonal[i][k]] += weight;
            }
        }
        for (k, l) in program.locals.iter().enumerate() {
            add_blocks(matrix, k, l, &d[k]);
        }
        if !factorise(matrix) {
            break;
        }
        let mut du: Vec<[f64; 3]> = gradient.iter().map(|g| g.map(|g| -g)).collect();
        matrix.solve(&mut du);
        for (i, du) in du.iter_mut().enumerate() {
            for k in (0..3).filter(|k| !program.free[i][*k]) {
                du[k] = 0.0;
            }
        }
        damping = (0.5 * damping).max(limits.least_damping);
        step = line_search(program, &u, &du, &e, &gradient);
        tiny = if step < TINY { tiny + 1 } else { 0 };
        for (u, du) in u.iter_mut().zip(&du) {
            for k in 0..3 {
                u[k] += step * du[k];
            }
        }
    }
    Newton { u, s, iterations }
}

/// The step at which the derivative along `du` vanishes, to a few per cent.
fn line_search(
    program: &Scaled,
    u: &[[f64; 3]],
    du: &[[f64; 3]],
    e: &[[f64; 3]],
    gradient: &[[f64; 3]],
) -> f64 {
    let de: Vec<[f64; 3]> = program.locals.iter().map(|l| Scaled::kinematics(l, du)).collect();
    let dot = |x: &[[f64; 3]], y: &[[f64; 3]]| -> f64 {
        x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| x * y).sum()
    };
    let slope = dot(gradient, du);
    let (mut linear, mut quadratic) = (0.0, 0.0);
    for i in 0..u.len() {
        for k in (0..3).filter(|k| program.free[i][*k]) {
            linear += (program.weight[i][k] * u[i][k] - program.right[i][k]) * du[i][k];
            quadratic += program.weight[i][k] * du[i][k] * du[i][k];
        }
    }
    let derivative = |a: f64| {
        let (mut value, mut curvature) = (linear + a * quadratic, quadratic);
        for ((l, e), de) in program.locals.iter().zip(e).zip(&de) {
            let (s, d) = project(l, &[0, 1, 2].map(|f| e[f] + a * de[f]));
            value += s[0] * de[0] + s[1] * de[1];
            curvature += de[0] * (d[0][0] * de[0] + d[0][1] * de[1])
                + de[1] * (d[1][0] * de[0] + d[1][1] * de[1]);
        }
        (value, curvature)
    };
    let (mut low, mut high) = (0.0, f64::INFINITY);
    let mut a = 1.0;
    for _ in 0..30 {
        let (value, curvature) = derivative(a);
        if value.abs() <= 0.02 * slope.abs() {
            break;
        }
        if value > 0.0 {
            high = a;
        } else {
            low = a;
        }
        let newton = a - value / curvature;
        a = if newton > low && newton < high {
            newton
        } else if high.is_finite() {
            0.5 * (low + high)
        } else {
            4.0 * a
        };
        if a > 1e6 || high - low < 1e-9 * high {
            break;
        }
    }
    a
}
