//! Primal-dual interior-point method on the condensed system, with the predictor and corrector of
//! Mehrotra (1992).
//!
//! An interaction's forces and multipliers are eliminated through its own small system
//! (`local_system`): `ds = T (G' du) + ds_0`, which leaves `(M + G T G') du = r` for the bodies.
//!
//! | file | what |
//! |---|---|
//! | `iteration` | the current point, and the steps that make an iteration |
//! | `history` | the best point so far, and what ends the method |
//! | `groups` | the interactions by branches of the matrix |
//! | `cell` | one interaction |
//! | `local_system` | elimination of one interaction |

mod cell;
mod groups;
mod history;
mod iteration;
mod local_system;

use self::history::History;
use self::iteration::Iteration;
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
    /// Number of factorisations.
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
    /// Residual, over the goal, at which the first point that is good enough ends the method.
    /// `None` if only a slow method ends there.
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

/// Forces near the solution to start from.
#[derive(Clone, Copy, Debug)]
pub struct Warm<'a> {
    /// Forces by interaction.
    pub forces: &'a [[f64; 3]],
    /// Products of slacks and multipliers at the start.
    pub product: f64,
}

/// Runs the method from the displacements `start` until a point near the `goal` `is_enough`, or the
/// residual no longer falls. Returns the best point on the way, `None` if there is none.
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

/// Runs the method from displacements and forces; without forces from the elastic trial at the
/// displacements.
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
    let mut iteration = Iteration::new(program, matrix, settings, start, warm);
    let mut history = History::new(settings, goal);
    let mut iterations = 0;
    loop {
        iteration.update_residuals();
        if !iteration.is_finite() {
            break;
        }
        history.record(&mut iteration);
        let enough = history.is_enough(&is_enough);
        if enough || history.is_over() || iterations >= settings.max_iterations {
            break;
        }
        iterations += 1;
        iteration.assemble();
        if !iteration.predict() {
            break;
        }
        let target = iteration.target();
        iteration.correct(target);
        iteration.make_step();
    }
    let point = history.into_best()?;
    Some(Interior { iterations, ..point })
}

/// The slack w of a limit whose multiplier lambda has `w - lambda = difference` and
/// `w lambda = product`.
#[inline]
pub fn slack(difference: f64, product: f64) -> f64 {
    let root = difference.hypot(2.0 * product.sqrt());
    if difference > 0.0 { 0.5 * (difference + root) } else { 2.0 * product / (root - difference) }
}

/// Maximum magnitude; not a number if any of them is not.
pub fn max_magnitude(rows: &[[f64; 3]]) -> f64 {
    let larger = |m: f64, r: &f64| if r.abs() <= m || m.is_nan() { m } else { r.abs() };
    rows.iter().flatten().fold(0.0, larger)
}
