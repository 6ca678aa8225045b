//! Primal-dual interior-point method on the condensed system (predictor and corrector after
//! Mehrotra).
//!
//! An interaction's forces and multipliers are eliminated through its own small system
//! (`local_system`): `ds = T (G' du) + ds_0`, which leaves
//! `(M + G T G') du = r` for the bodies.

mod cell;
mod groups;
mod local_system;

use self::cell::{Ahead, Aim, Sizes, for_each};
use self::groups::Groups;
use super::matrix::BodyMatrix;
use super::scaled::{ROWS, Scaled};
use super::settings::InteriorSettings;

/// An interior point.
pub struct Interior {
    /// Displacements by body, in the order of elimination.
    pub u: Vec<[f64; 3]>,
    /// Forces by interaction.
    pub s: Vec<[f64; 3]>,
    /// Multipliers of the limits.
    pub lambda: Vec<[f64; ROWS]>,
    /// Factorisations.
    pub iterations: u32,
    /// Residual of the point, as the method measures it.
    pub merit: f64,
}

impl Interior {
    /// Room for a point.
    fn of(program: &Scaled) -> Self {
        let count = program.locals.len();
        let (s, lambda) = (vec![[0.0; 3]; count], vec![[0.0; ROWS]; count]);
        Self { u: Vec::new(), s, lambda, iterations: 0, merit: f64::INFINITY }
    }
}

/// What ends the method.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// Residual at which it is done.
    residual: f64,
    /// Residual, over the goal, at which the first point that is good enough ends the method. `None`
    /// if only a slow method ends there.
    first: Option<f64>,
}

impl Goal {
    /// This residual, or a little more where the method is slow.
    #[must_use]
    pub fn exact(residual: f64) -> Self {
        Self { residual, first: None }
    }

    /// The first point that is good enough, from a residual of `near` on.
    #[must_use]
    pub fn enough(residual: f64, near: f64) -> Self {
        Self { residual, first: Some(near / residual) }
    }
}

/// Forces near the solution, to begin with.
#[derive(Clone, Copy, Debug)]
pub struct Warm<'a> {
    /// Forces by interaction.
    pub forces: &'a [[f64; 3]],
    /// Products of slacks and multipliers.
    pub product: f64,
}

/// Runs the method from the displacements `start` until a point near the `goal` `is_enough`, or the residual no
/// longer falls. Returns the best point on the way, `None` if there is none.
#[must_use]
pub fn solve(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    settings: &InteriorSettings,
    goal: Goal,
    is_enough: impl Fn(&Interior) -> bool,
) -> Option<Interior> {
    solve_from(program, matrix, start, None, settings, goal, is_enough)
}

/// Runs the method from displacements and forces; without forces from the elastic trial at the displacements.
#[must_use]
pub fn solve_from(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    start: &[[f64; 3]],
    warm: Option<Warm>,
    settings: &InteriorSettings,
    goal: Goal,
    is_enough: impl Fn(&Interior) -> bool,
) -> Option<Interior> {
    let n = program.free.len();
    let mut u = program.with_known(start);
    let mut groups = Groups::new(program, matrix, &u, settings);
    if let Some(warm) = warm {
        for cells in groups.all() {
            for_each!(cell of cells => cell.warm(&u, warm));
        }
    } else if groups.greatest_force() > settings.max_start_force {
        u = program.with_known(&vec![[0.0; 3]; n]);
        groups = Groups::new(program, matrix, &u, settings);
    }
    let limits: usize = program.locals.iter().map(|l| l.count).sum();
    let limits = limits.max(1) as f64;
    let mut best: Option<Interior> = None;
    let mut since_best = 0;
    let mut iterations = 0;
    let mut last_merit = f64::INFINITY;
    let mut refused = f64::INFINITY;
    let mut merits = Vec::new();
    // Of the step that the interactions have still to make: every pass over them costs.
    let mut length = 0.0;
    let mut balance = vec![[0.0; 3]; n];
    let mut right = vec![[0.0; 3]; n];
    let mut du = vec![[0.0; 3]; n];
    let mut defect = vec![[0.0; 3]; n];
    let mut weight = vec![[0.0; 3]; n];
    loop {
        // Residuals.
        program.balance_of_bodies(&u, &mut balance);
        let sizes = groups.scatter(&mut balance, |cells, balance| {
            let mut size = Sizes::default();
            for_each!(cell of cells => cell.evaluate(length, &u, balance, &mut size));
            size
        });
        let size = sizes.into_iter().fold(Sizes::default(), Sizes::and);
        let mu = size.products / limits;
        let unbalance = greatest(&balance);
        let force = size.force.max(settings.min_force);
        let sum = unbalance + size.kinematic + size.primal + mu;
        // Products count by the greatest: started near a solution most of them are nothing.
        let merit = (unbalance.max(size.primal) / force)
            .max(size.kinematic)
            .max(settings.product_weight * size.product / force);
        if !sum.is_finite() {
            break;
        }
        if best.as_ref().is_none_or(|b| merit < b.merit) {
            let point = best.get_or_insert_with(|| Interior::of(program));
            point.u.clone_from(&u);
            point.merit = merit;
            for cells in groups.all() {
                for_each!(cell of cells => cell.store(&mut point.s, &mut point.lambda));
            }
            since_best = 0;
        } else {
            since_best += 1;
        }
        merits.push(best.as_ref().map_or(merit, |b| b.merit));
        let earlier = merits.len().checked_sub(settings.patience + 1);
        let earlier = earlier.map_or(f64::INFINITY, |k| merits[k]);
        let slow = merit > settings.slow * last_merit;
        let there = merit <= goal.residual;
        let is_near = there
            || (merit <= goal.first.unwrap_or(settings.near) * goal.residual
                && (slow || goal.first.is_some()));
        // Asked once of every point: it looks at the whole program.
        let near = best.as_ref().filter(|b| is_near && b.merit < refused);
        let enough = near.is_some_and(&is_enough);
        refused = near.map_or(refused, |b| b.merit);
        last_merit = merit;
        // The residual is relative to the scales of the program. Where bodies hardly move, what is good enough
        // may be far below it.
        let is_done = best.as_ref().is_some_and(|b| b.merit <= goal.residual)
            && since_best >= settings.max_idle_at_goal;
        if enough
            || is_done
            || iterations >= settings.max_iterations
            || (since_best > settings.max_idle_diverging
                && merit > settings.divergence * best.as_ref().map_or(0.0, |b| b.merit))
            || since_best > settings.max_idle
            || merits[merits.len() - 1] > settings.progress * earlier
        {
            break;
        }
        iterations += 1;

        // The condensed matrix.
        matrix.clear();
        let mut values = matrix.assembly();
        // A vanishing proximal weight keeps what nothing holds from going to infinity.
        let proximal = settings.min_proximal + settings.proximal * mu.min(1.0);
        for i in 0..n {
            for k in 0..3 {
                weight[i][k] = program.weight[i][k] + proximal;
                let diagonal = if program.free[i][k] { weight[i][k] } else { 1.0 };
                values.add_diagonal(i, k, diagonal);
            }
        }
        // The predictor takes all products away; it only aims the corrector.
        set_negative(&mut right, &balance);
        groups.condense(matrix, &mut right, |cells, values, right| {
            for_each!(cell of cells => cell.condense(values, right));
        });
        du.clone_from(&right);
        if !factorise_and_solve(matrix, &mut du) {
            break;
        }
        let ahead = steps(&mut groups, &du);
        let after = ahead.products_after() / limits;
        let ratio = if mu > 0.0 { after / mu } else { 0.0 };
        let target = ratio.powi(3).min(1.0) * mu;

        set_negative(&mut right, &balance);
        groups.scatter(&mut right, |cells, right| {
            for_each!(cell of cells => cell.aim(Aim::Target(target), right));
        });
        du.clone_from(&right);
        matrix.solve(&mut du);
        refine(program, matrix, &mut groups, settings, &weight, &right, &mut du, &mut defect);
        let step = steps(&mut groups, &du).length;
        let [lower, upper] = settings.step;
        length = if step < 1.0 { step * (1.0 - mu).clamp(lower, upper) } else { 1.0 };
        for (u, du) in u.iter_mut().zip(&du) {
            for k in 0..3 {
                u[k] += length * du[k];
            }
        }
    }
    let mut point = best?;
    point.iterations = iterations;
    Some(point)
}

/// The slack w of a limit whose multiplier lambda has `w - lambda = difference` and `w lambda = product`.
#[inline]
pub fn slack(difference: f64, product: f64) -> f64 {
    let root = difference.hypot(2.0 * product.sqrt());
    if difference > 0.0 { 0.5 * (difference + root) } else { 2.0 * product / (root - difference) }
}

/// Greatest magnitude; not a number if any of them is not.
pub fn greatest(rows: &[[f64; 3]]) -> f64 {
    let greater = |m: f64, r: &f64| if r.abs() <= m || m.is_nan() { m } else { r.abs() };
    rows.iter().flatten().fold(0.0, greater)
}

fn set_negative(rows: &mut [[f64; 3]], of: &[[f64; 3]]) {
    for (row, of) in rows.iter_mut().zip(of) {
        *row = of.map(|r| -r);
    }
}

/// Steps of forces, slacks and multipliers that belong to steps of the displacements.
fn steps(groups: &mut Groups, du: &[[f64; 3]]) -> Ahead {
    let ahead = groups.each(|cells| {
        let mut ahead = Ahead::default();
        for_each!(cell of cells => cell.step(du, &mut ahead));
        ahead
    });
    ahead.into_iter().fold(Ahead::default(), Ahead::and)
}

/// Factorises and solves, with a larger diagonal where round-off has cost positive definiteness.
pub(super) fn factorise_and_solve(matrix: &mut BodyMatrix, x: &mut [[f64; 3]]) -> bool {
    if matrix.factorise_and_solve(x) {
        return true;
    }
    let greatest = matrix.greatest_diagonal();
    for shift in [1e-14, 1e-12, 1e-10] {
        let bodies = matrix.bodies();
        let mut values = matrix.assembly();
        for body in 0..bodies {
            for k in 0..3 {
                values.add_diagonal(body, k, shift * greatest);
            }
        }
        if matrix.factorise_and_solve(x) {
            return true;
        }
    }
    false
}

/// Steps of refinement on the condensed operator, with the weights of the degrees of freedom.
fn refine(
    program: &Scaled,
    matrix: &mut BodyMatrix,
    groups: &mut Groups,
    settings: &InteriorSettings,
    weight: &[[f64; 3]],
    right: &[[f64; 3]],
    du: &mut [[f64; 3]],
    defect: &mut [[f64; 3]],
) {
    let scale = greatest(right);
    for _ in 0..settings.max_refinements {
        for (i, defect) in defect.iter_mut().enumerate() {
            for k in 0..3 {
                defect[k] =
                    if program.free[i][k] { right[i][k] - weight[i][k] * du[i][k] } else { 0.0 };
            }
        }
        groups.scatter(defect, |cells, defect| {
            for_each!(cell of cells => cell.take_away(du, defect));
        });
        if greatest(defect) <= settings.refined * scale {
            return;
        }
        matrix.solve(defect);
        for (du, d) in du.iter_mut().zip(&*defect) {
            for k in 0..3 {
                du[k] += d[k];
            }
        }
    }
}
