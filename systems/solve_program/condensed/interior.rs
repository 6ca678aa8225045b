//! Primal-dual interior-point method on the condensed system (predictor and corrector after
//! Mehrotra).
//!
//! An interaction's forces and multipliers are eliminated through its own small system
//! ([`local_system`](super::local_system)): `ds = T (G' du) + ds_0`, which leaves
//! `(M + G T G') du = r` for the bodies.

use super::local_system::{LocalSystem, Right};
use super::matrix::BodyMatrix;
use super::scaled::{Local, ROWS, Scaled};

/// An interior point.
pub struct Interior {
    /// Displacements by body.
    pub u: Vec<[f64; 3]>,
    /// Forces by interaction.
    pub s: Vec<[f64; 3]>,
    /// Multipliers of the limits.
    pub lambda: Vec<[f64; ROWS]>,
    /// Factorisations.
    pub iterations: u32,
}

const MAX_ITERATIONS: u32 = 80;
/// Complementarity product of the starting point.
const START: f64 = 0.3;
/// Greatest compliance that the starting point counts with, in units of displacement over force.
const SOFT: f64 = 10.0;
/// Steps of refinement at most, and the relative defect at which there is no need of one.
const MAX_REFINEMENTS: usize = 3;
const REFINED: f64 = 1e-4;
/// Weight of the greatest complementarity product beside the other residuals.
const PRODUCT: f64 = 0.02;
/// What is enough where there is little progress, over the residual at which it is done.
const ENOUGH: f64 = 10.0;
/// The best iterate of a stalled iteration is worth polishing when it is this good.
const WORTH: f64 = 1e-3;

struct Slacks {
    w: [f64; ROWS],
    lambda: [f64; ROWS],
    dw: [f64; ROWS],
    dlambda: [f64; ROWS],
    defect: [f64; ROWS],
}

fn times(k: &[[f64; 3]; 3], v: &[f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| k[i][0] * v[0] + k[i][1] * v[1] + k[i][2] * v[2])
}

/// Forces, slacks and multipliers near the elastic trial at the starting displacements.
fn start_local(local: &Local, u: &[[f64; 3]]) -> ([f64; 3], Slacks) {
    let e = Scaled::kinematics(local, u);
    let mut trial = [0.0; 3];
    for f in (0..2).filter(|f| local.has[*f]) {
        let c = local.compliance[f];
        trial[f] = if c > 0.0 { (e[f] - local.linear[f]) / c } else { 0.0 };
    }
    let mut s = Slacks {
        w: [1.0; ROWS],
        lambda: [0.0; ROWS],
        dw: [0.0; ROWS],
        dlambda: [0.0; ROWS],
        defect: [0.0; ROWS],
    };
    // The trial clamped to the limits: normal force first, then shear at that normal force.
    let lowest = (0..local.count)
        .filter(|q| local.limits[*q][0] < 0.0)
        .map(|q| local.right[q] / local.limits[q][0])
        .fold(f64::NEG_INFINITY, f64::max);
    let mut force = [trial[0].max(lowest), 0.0, 0.0];
    if local.has[1] {
        let strength = local.right[0] - local.limits[0][0] * force[0];
        force[1] = trial[1].clamp(-strength.max(0.0), strength.max(0.0));
    }
    // Slack where it is inside; where it was clamped, the excess is the multiplier.
    // What is far softer than the rest must not start with products far greater than theirs.
    let compliance = if local.compliance[0] > 0.0 { local.compliance[0].min(SOFT) } else { 1.0 };
    for q in 0..local.count {
        let a = &local.limits[q];
        let slack = local.right[q] - a[0] * force[0] - a[1] * force[1];
        let excess = a[0] * (trial[0] - force[0]) + a[1] * (trial[1] - force[1]);
        let x = slack.max(0.0) - excess.max(0.0);
        let root = x.hypot(2.0 * START);
        s.w[q] = 0.5 * if x > 0.0 { x + root } else { 4.0 * START * START / (root - x) };
        s.lambda[q] = START * START / s.w[q] * compliance;
    }
    (force, s)
}

/// Runs the method from the displacements `start` until the residual is at most `goal`. `None` if
/// it fails far from a solution.
#[must_use]
pub fn solve(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    goal: f64,
) -> Option<Interior> {
    let n = program.free.len();
    let mut u: Vec<[f64; 3]> = (0..n)
        .map(|i| {
            [0, 1, 2].map(|k| if program.free[i][k] { start[i][k] } else { program.known[i][k] })
        })
        .collect();
    let (mut s, mut slacks): (Vec<_>, Vec<_>) =
        program.locals.iter().map(|l| start_local(l, &u)).unzip();

    let limits: usize = program.locals.iter().map(|l| l.count).sum();
    let m = program.locals.len();
    let (mut stationarity, mut ds) = (vec![[0.0; 3]; m], vec![[0.0; 3]; m]);
    let mut rights = vec![Right::default(); m];
    let mut systems = vec![LocalSystem::default(); m];
    let mut stiffness = vec![[[0.0; 3]; 3]; m];
    let mut best: Option<(f64, Interior)> = None;
    let mut since_best = 0;
    let mut iterations = 0;
    let mut last_merit = f64::INFINITY;
    loop {
        // Residuals.
        let mut balance: Vec<[f64; 3]> = (0..n)
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
        let (mut mu, mut kinematic, mut primal, mut force) = (0.0, 0.0_f64, 0.0_f64, 1e-3_f64);
        let mut product = 0.0_f64;
        for (k, local) in program.locals.iter().enumerate() {
            Scaled::add_forces(local, &s[k], 1.0, &mut balance);
            let e = Scaled::kinematics(local, &u);
            let sl = &mut slacks[k];
            let mut r = [0, 1, 2].map(|f| local.linear[f] + local.compliance[f] * s[k][f] - e[f]);
            for q in 0..local.count {
                let a = &local.limits[q];
                for f in 0..3 {
                    r[f] += a[f] * sl.lambda[q];
                }
                sl.defect[q] =
                    a[0] * s[k][0] + a[1] * s[k][1] + a[2] * s[k][2] + sl.w[q] - local.right[q];
                primal = primal.max(sl.defect[q].abs());
                mu += sl.w[q] * sl.lambda[q];
                product = product.max(sl.w[q] * sl.lambda[q]);
            }
            for f in 0..3 {
                stationarity[k][f] = if local.has[f] { r[f] } else { 0.0 };
                kinematic = kinematic.max(stationarity[k][f].abs());
            }
            force = force.max(s[k][0].abs());
        }
        mu /= limits.max(1) as f64;
        let unbalance = balance.iter().flatten().map(|r| r.abs()).fold(0.0, f64::max);
        let sum = unbalance + kinematic + primal + mu;
        // Products count by the greatest: started near a solution most of them are nothing.
        let merit = (unbalance.max(primal) / force).max(kinematic).max(PRODUCT * product / force);
        if !sum.is_finite() {
            break;
        }
        if best.as_ref().is_none_or(|b| merit < b.0) {
            let lambda = slacks.iter().map(|s| s.lambda).collect();
            best = Some((merit, Interior { u: u.clone(), s: s.clone(), lambda, iterations }));
            since_best = 0;
        } else {
            since_best += 1;
        }
        let slow = merit > 0.3 * last_merit;
        last_merit = merit;
        if merit <= goal
            || (merit <= ENOUGH * goal && slow)
            || iterations >= MAX_ITERATIONS
            || (since_best > 8 && merit > 1e3 * best.as_ref().map_or(0.0, |b| b.0))
            || since_best > 15
        {
            break;
        }
        iterations += 1;

        // The condensed matrix.
        matrix.values.iter_mut().for_each(|v| *v = 0.0);
        for i in 0..n {
            for k in 0..3 {
                // A vanishing proximal weight keeps what nothing holds from going to infinity.
                let weight = if program.free[i][k] {
                    program.weight[i][k] + 1e-10 + 1e-3 * mu.min(1.0)
                } else {
                    1.0
                };
                matrix.values[matrix.diagonal[i][k]] += weight;
            }
        }
        for (k, local) in program.locals.iter().enumerate() {
            systems[k].set(local, &slacks[k].w, &slacks[k].lambda);
            stiffness[k] = systems[k].compliance_inverse();
            add_blocks(matrix, k, local, &stiffness[k]);
        }
        if !factorise(matrix) {
            break;
        }

        // Predictor, then corrector.
        let mut target = 0.0;
        let mut step = 1.0;
        let mut du = vec![[0.0; 3]; n];
        for corrector in [false, true] {
            let mut right: Vec<[f64; 3]> = balance.iter().map(|r| r.map(|r| -r)).collect();
            for (k, local) in program.locals.iter().enumerate() {
                let sl = &slacks[k];
                // Complementarity that is to be left: w lambda + ... = target, less second order.
                let products = [0, 1, 2, 3, 4].map(|q| {
                    let second = if corrector { sl.dw[q] * sl.dlambda[q] } else { 0.0 };
                    sl.w[q] * sl.lambda[q] - target + second
                });
                rights[k] = Right { stationarity: stationarity[k], defects: sl.defect, products };
                let s0 = systems[k].forces(local, &[0.0; 3], &rights[k], &sl.w, &sl.lambda);
                Scaled::add_forces(local, &s0, -1.0, &mut right);
            }
            du.clone_from(&right);
            matrix.solve(&mut du);
            // The predictor only aims the corrector.
            if corrector {
                refine(program, matrix, &stiffness, &right, &mut du);
            }
            step = 1.0;
            for (k, local) in program.locals.iter().enumerate() {
                let e = kinematics_free(local, &du);
                let sl = &mut slacks[k];
                let (step_s, steps) = systems[k].solve(local, &e, &rights[k], &sl.w, &sl.lambda);
                ds[k] = step_s;
                for q in 0..local.count {
                    let (dw, dl) = steps[q];
                    sl.dw[q] = dw;
                    sl.dlambda[q] = dl;
                    if dw < 0.0 {
                        step = f64::min(step, -sl.w[q] / dw);
                    }
                    if dl < 0.0 {
                        step = f64::min(step, -sl.lambda[q] / dl);
                    }
                }
            }
            if !corrector {
                let mut after = 0.0;
                for (sl, local) in slacks.iter().zip(&program.locals) {
                    for q in 0..local.count {
                        after +=
                            (sl.w[q] + step * sl.dw[q]) * (sl.lambda[q] + step * sl.dlambda[q]);
                    }
                }
                after /= limits.max(1) as f64;
                let ratio = if mu > 0.0 { after / mu } else { 0.0 };
                target = ratio.powi(3).min(1.0) * mu;
            }
        }
        let length = if step < 1.0 { step * (1.0 - mu.min(0.01)).clamp(0.99, 0.9995) } else { 1.0 };
        for (u, du) in u.iter_mut().zip(&du) {
            for k in 0..3 {
                u[k] += length * du[k];
            }
        }
        for (k, sl) in slacks.iter_mut().enumerate() {
            for f in 0..3 {
                s[k][f] += length * ds[k][f];
            }
            for q in 0..program.locals[k].count {
                sl.w[q] += length * sl.dw[q];
                sl.lambda[q] += length * sl.dlambda[q];
            }
        }
    }
    let (merit, mut point) = best?;
    point.iterations = iterations;
    (merit <= WORTH).then_some(point)
}

/// Kinematics of a change of free degrees of freedom.
fn kinematics_free(local: &Local, du: &[[f64; 3]]) -> [f64; 3] {
    let mut e = [0.0; 3];
    for side in 0..2 {
        let v = &du[local.bodies[side]];
        for k in 0..3 {
            for f in 0..3 {
                e[f] += local.rows[side][k][f] * v[k];
            }
        }
    }
    e
}

/// Adds `G D G'` of one interaction.
pub(super) fn add_blocks(matrix: &mut BodyMatrix, k: usize, local: &Local, d: &[[f64; 3]; 3]) {
    let product = |x: &[[f64; 3]; 3], y: &[[f64; 3]; 3]| {
        let mut out = [[0.0; 3]; 3];
        for i in 0..3 {
            let xd = [0, 1, 2].map(|c| x[i][0] * d[0][c] + x[i][1] * d[1][c] + x[i][2] * d[2][c]);
            for j in 0..3 {
                out[i][j] = xd[0] * y[j][0] + xd[1] * y[j][1] + xd[2] * y[j][2];
            }
        }
        out
    };
    let [ga, gb] = &local.rows;
    matrix.add_diagonal(local.bodies[0], &product(ga, ga));
    matrix.add_diagonal(local.bodies[1], &product(gb, gb));
    let off = product(ga, gb);
    let place = matrix.places[k].entries;
    for i in 0..3 {
        for j in 0..3 {
            matrix.values[place[3 * i + j]] += off[i][j];
        }
    }
}

/// Factorises, with a larger diagonal where round-off has cost positive definiteness.
pub(super) fn factorise(matrix: &mut BodyMatrix) -> bool {
    if matrix.factorise() {
        return true;
    }
    let greatest = matrix.diagonal.iter().flatten().map(|d| matrix.values[*d]).fold(0.0, f64::max);
    for shift in [1e-14, 1e-12, 1e-10] {
        for body in 0..matrix.diagonal.len() {
            for k in 0..3 {
                let d = matrix.diagonal[body][k];
                matrix.values[d] += shift * greatest;
            }
        }
        if matrix.factorise() {
            return true;
        }
    }
    false
}

/// Steps of refinement on the condensed operator.
fn refine(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    stiffness: &[[[f64; 3]; 3]],
    right: &[[f64; 3]],
    du: &mut [[f64; 3]],
) {
    let scale = right.iter().flatten().map(|r| r.abs()).fold(0.0, f64::max);
    for _ in 0..MAX_REFINEMENTS {
        let mut defect: Vec<[f64; 3]> = right
            .iter()
            .enumerate()
            .map(|(i, r)| {
                [0, 1, 2].map(|k| {
                    if program.free[i][k] { r[k] - program.weight[i][k] * du[i][k] } else { 0.0 }
                })
            })
            .collect();
        for (local, t) in program.locals.iter().zip(stiffness) {
            let e = kinematics_free(local, du);
            Scaled::add_forces(local, &times(t, &e), -1.0, &mut defect);
        }
        let error = defect.iter().flatten().map(|r| r.abs()).fold(0.0, f64::max);
        if error <= REFINED * scale {
            return;
        }
        matrix.solve(&mut defect);
        for (du, d) in du.iter_mut().zip(&defect) {
            for k in 0..3 {
                du[k] += d[k];
            }
        }
    }
}
