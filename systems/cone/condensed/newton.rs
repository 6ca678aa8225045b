//! Semismooth Newton iteration in the displacements, for programs in which every force has a
//! compliance.
//!
//! Given u, the forces of a contact are the projection of its elastic trial onto its limits in the
//! metric of the compliances; the balance is then the gradient of a convex, piecewise quadratic
//! function of u, and its generalised Hessian is the condensed matrix of the current regions. The
//! line search is exact: the derivative along the step is monotone and piecewise linear. Where a step
//! leaves fast bodies behind it is one of the others alone: what that does to those bodies is not counted.

use super::interior::factorise_and_solve;
use super::local::{eliminate, is_crowded};
use super::matrix::BodyMatrix;
use super::scaled::{Kind, Local, Scaled, add_forces, kinematics};
use super::settings::{LineSearchSettings, LocalSettings, NewtonSettings};
use crate::adjacency::Adjacency;

/// Result of the iteration, converged or not.
pub struct Newton {
    /// Displacements by body, in the order of elimination.
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

/// What the forces of an elastic interaction follow from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spring {
    /// Stiffness in normal and tangential direction, 1 over the compliance.
    stiffness: [f64; 2],
    /// Kinematics without forces.
    linear: [f64; 2],
    /// Coefficient of friction, cohesion, and tensile strength (infinite where friction says it all).
    friction: f64,
    cohesion: f64,
    tension: f64,
    shears: bool,
}

/// What two forces of an interaction act on.
struct Arms {
    bodies: [u32; 2],
    rows: [[[f64; 2]; 3]; 2],
}

impl Arms {
    fn new(l: &Local) -> Self {
        let rows = l.rows.map(|rows| rows.map(|[normal, shear, _]| [normal, shear]));
        Self { bodies: l.bodies.map(|i| i as u32), rows }
    }

    fn kinematics(&self, u: &[[f64; 3]]) -> [f64; 2] {
        kinematics(self.bodies, &self.rows, u)
    }
}

/// Forces (p, q) with their derivatives by (e_n, e_t): those of p by e_n, of p by e_t (and q by e_n),
/// and of q by e_t.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Response {
    /// Forces.
    pub s: [f64; 2],
    d: [f64; 3],
}

impl Spring {
    /// Of an interaction with compliance in each of its forces, and without rolling moment.
    pub(super) fn new(l: &Local) -> Self {
        let (friction, cohesion, tension) = match l.kind {
            Kind::Normal => (0.0, 0.0, l.right[0]),
            Kind::Bond => (-l.limits[0][0], l.right[0], l.right[2]),
            Kind::Friction | Kind::Rolling | Kind::Wheel => {
                (-l.limits[0][0], l.right[0], f64::INFINITY)
            }
        };
        Self {
            stiffness: [1.0 / l.compliance[0], 1.0 / l.compliance[1]],
            linear: [l.linear[0], l.linear[1]],
            friction,
            cohesion,
            tension,
            shears: l.has[1],
        }
    }

    /// Projection of the elastic trial onto the limits.
    #[inline]
    pub(super) fn respond(&self, e: [f64; 2]) -> Response {
        let [kn, kt] = self.stiffness;
        let pt = (e[0] - self.linear[0]) * kn;
        let qt = (e[1] - self.linear[1]) * kt;
        let size = qt.abs();
        let over = size - self.cohesion - self.friction * pt;
        if self.shears && over <= 0.0 && pt >= -self.tension {
            return Response { s: [pt, qt], d: [kn, 0.0, kt] };
        }
        self.limited(pt, qt)
    }

    /// The projection of a trial that may be outside of the limits.
    fn limited(&self, pt: f64, qt: f64) -> Response {
        let [kn, kt] = self.stiffness;
        let (mu, cohesion, tension) = (self.friction, self.cohesion, self.tension);
        if !self.shears {
            return if pt > -tension {
                Response { s: [pt, 0.0], d: [kn, 0.0, 0.0] }
            } else {
                Response { s: [-tension, 0.0], d: [0.0; 3] }
            };
        }
        let sign = if qt < 0.0 { -1.0 } else { 1.0 };
        let size = qt.abs();
        // The corner of the limits: where tension cuts the shear cone, or the cone's own apex.
        let at_tension = cohesion - mu * tension;
        let (p0, q0) =
            if at_tension >= 0.0 { (-tension, at_tension) } else { (-cohesion / mu, 0.0) };
        let over = size - cohesion - mu * pt;
        if pt < p0 && (over <= 0.0 || size <= q0) {
            return if size <= q0 && q0 > 0.0 {
                Response { s: [p0, qt], d: [0.0, 0.0, kt] }
            } else {
                Response { s: [p0, sign * q0.min(size)], d: [0.0; 3] }
            };
        }
        if over <= 0.0 {
            return Response { s: [pt, qt], d: [kn, 0.0, kt] };
        }
        let sum = kt + mu * mu * kn;
        let slip = over / sum;
        let p = pt + mu * kn * slip;
        if p >= p0 {
            let (vn, vt) = (-mu * kn, sign * kt);
            let d = [kn - vn * vn / sum, -vn * vt / sum, kt - vt * vt / sum];
            return Response { s: [p, sign * (size - kt * slip)], d };
        }
        Response { s: [p0, sign * q0], d: [0.0; 3] }
    }
}

/// Unbalance at which the iteration is done: the looser of the two counts.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// Over the maximum force.
    pub relative: f64,
    /// In units of force.
    pub absolute: f64,
}

/// Solves the program from the displacements `start`, with local elimination, until the unbalance over
/// the greatest force is at most `goal`.
#[must_use]
pub fn solve(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    settings: &NewtonSettings,
    local: &LocalSettings,
    goal: f64,
) -> Newton {
    let patience = if program.is_damped() { settings.max_iterations } else { settings.patience };
    let settings = NewtonSettings { patience, ..*settings };
    let goal = Goal { relative: goal, absolute: 0.0 };
    let pairs = program.locals.iter().map(|l| l.bodies);
    let adjacency = Adjacency::new(program.free.len(), pairs);
    iterate(program, matrix, start, &settings, goal, Some((&adjacency, local)))
}

/// Runs the iteration from the displacements `start`; with local elimination where the adjacency of
/// the program is given.
#[must_use]
pub fn iterate(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    settings: &NewtonSettings,
    goal: Goal,
    local: Option<(&Adjacency, &LocalSettings)>,
) -> Newton {
    let n = program.free.len();
    let search = &settings.line_search;
    let mut u = program.with_known(start);
    let springs: Vec<Spring> = program.locals.iter().map(Spring::new).collect();
    let arms: Vec<Arms> = program.locals.iter().map(Arms::new).collect();
    let mut responses = vec![Response::default(); springs.len()];
    let mut e = vec![[0.0; 2]; springs.len()];
    let mut de = e.clone();
    let mut gradient = vec![[0.0; 3]; n];
    let mut du = gradient.clone();
    let mut iterations = 0;
    let mut tiny = 0;
    let mut step = 0.0;
    let mut eliminated = false;
    let mut damping = settings.damping;
    let mut fast: Vec<bool> = Vec::new();
    loop {
        program.balance_of_bodies(&u, &mut gradient);
        let mut force = settings.min_force;
        for (k, (spring, arms)) in springs.iter().zip(&arms).enumerate() {
            e[k] = arms.kinematics(&u);
            responses[k] = spring.respond(e[k]);
            let [p, q] = responses[k].s;
            add_forces(arms.bodies, &arms.rows, &[p, q], 1.0, &mut gradient);
            force = force.max(p.abs()).max(q.abs());
        }
        let unbalance = gradient.iter().flatten().map(|g| g.abs()).fold(0.0, f64::max);
        let finite = gradient.iter().flatten().all(|g| g.is_finite());
        let lost =
            iterations >= settings.patience && unbalance > settings.max_late_unbalance * force;
        let done = iterations >= settings.max_iterations || tiny >= settings.max_tiny_steps || lost;
        if !finite || unbalance <= (goal.relative * force).max(goal.absolute) || done {
            break;
        }
        if let Some((adjacency, local)) = local
            && !std::mem::replace(&mut eliminated, true)
            && ((unbalance > local.min_unbalance * force && step < local.short_step)
                || !fast.is_empty())
            && eliminate(program, adjacency, local, &gradient, &e, &fast, &mut u)
        {
            continue;
        }
        eliminated = false;
        iterations += 1;
        matrix.clear();
        let mut values = matrix.assembly();
        for i in 0..n {
            for k in 0..3 {
                let weight = if program.free[i][k] { program.weight[i][k] + damping } else { 1.0 };
                values.add_diagonal(i, k, weight);
            }
        }
        for (k, (arms, response)) in arms.iter().zip(&responses).enumerate() {
            let [nn, nt, tt] = response.d;
            values.add(k, &arms.rows, &[[nn, nt], [nt, tt]]);
        }
        for (du, g) in du.iter_mut().zip(&gradient) {
            *du = g.map(|g| -g);
        }
        if !factorise_and_solve(matrix, &mut du) {
            break;
        }
        for (i, du) in du.iter_mut().enumerate() {
            for k in (0..3).filter(|k| !program.free[i][*k]) {
                du[k] = 0.0;
            }
        }
        damping = (0.5 * damping).max(settings.min_damping);
        for (de, arms) in de.iter_mut().zip(&arms) {
            *de = arms.kinematics(&du);
        }
        step = line_search(program, &springs, search, [&u, &du, &gradient], &e, &de);
        fast.clear();
        if let Some((adjacency, local)) = local.filter(|(_, l)| step < l.short_step) {
            let slow = SlowPart::of(program, adjacency, local, &du, &de);
            let longer = slow.as_ref().map_or(0.0, |slow| {
                line_search(program, &springs, search, [&u, &slow.du, &gradient], &e, &slow.de)
            });
            if let Some(slow) = slow.filter(|_| longer > local.min_gain * step) {
                step = longer.min(1.0);
                du = slow.du;
                fast = slow.fast;
            }
        }
        tiny = if step < settings.tiny_step { tiny + 1 } else { 0 };
        for (u, du) in u.iter_mut().zip(&du) {
            for k in 0..3 {
                u[k] += step * du[k];
            }
        }
    }
    let s = responses.iter().map(|r| [r.s[0], r.s[1], 0.0]).collect();
    Newton { u, s, iterations }
}

/// A step without the bodies that it moves fastest. Where a few loose bodies go far, the state of their
/// contacts changes at once: alone they would end a step that all others could make. Those are what
/// [local elimination](eliminate) takes on next.
struct SlowPart {
    fast: Vec<bool>,
    du: Vec<[f64; 3]>,
    /// Zero where one of the bodies is fast.
    de: Vec<[f64; 2]>,
}

impl SlowPart {
    /// `None` where no body is fast.
    fn of(
        program: &Scaled,
        adjacency: &Adjacency,
        local: &LocalSettings,
        du: &[[f64; 3]],
        de: &[[f64; 2]],
    ) -> Option<Self> {
        let size = |du: &[f64; 3]| du[0].hypot(du[1]).max(du[2].abs());
        let mut sizes: Vec<f64> = du.iter().map(size).collect();
        let place = (local.fast_quantile * sizes.len() as f64) as usize;
        let (_, usual, _) = sizes.select_nth_unstable_by(place, f64::total_cmp);
        let greatest = local.fast * *usual;
        let is_fast = |i: usize| size(&du[i]) > greatest && !is_crowded(adjacency, local, i);
        let fast: Vec<bool> = (0..du.len()).map(is_fast).collect();
        fast.contains(&true).then(|| {
            let slow = |(du, fast): (&[f64; 3], &bool)| if *fast { [0.0; 3] } else { *du };
            let both_slow = |l: &Local| !l.bodies.iter().any(|i| fast[*i]);
            let du = du.iter().zip(&fast).map(slow).collect();
            let of_both = |(de, l): (&[f64; 2], &Local)| if both_slow(l) { *de } else { [0.0; 2] };
            let de = de.iter().zip(&program.locals).map(of_both).collect();
            Self { fast, du, de }
        })
    }
}

/// The step at which the derivative along `du` vanishes, to a few per cent.
fn line_search(
    program: &Scaled,
    springs: &[Spring],
    settings: &LineSearchSettings,
    [u, du, gradient]: [&[[f64; 3]]; 3],
    e: &[[f64; 2]],
    de: &[[f64; 2]],
) -> f64 {
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
        for ((spring, e), de) in springs.iter().zip(e).zip(de) {
            let Response { s, d } = spring.respond([e[0] + a * de[0], e[1] + a * de[1]]);
            value += s[0] * de[0] + s[1] * de[1];
            curvature += d[0] * de[0] * de[0] + 2.0 * d[1] * de[0] * de[1] + d[2] * de[1] * de[1];
        }
        (value, curvature)
    };
    let (mut low, mut high) = (0.0, f64::INFINITY);
    let mut a = 1.0;
    for _ in 0..settings.max_evaluations {
        let (value, curvature) = derivative(a);
        if value.abs() <= settings.max_slope * slope.abs() {
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
        if a > settings.max_length || high - low < settings.min_bracket * high {
            break;
        }
    }
    a
}
