//! A point of the method, where the method starts and where it ends.

use crate::condensed::scaled::{ROWS, Scaled};

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
    pub(super) fn of(program: &Scaled) -> Self {
        let count = program.locals.len();
        let (s, lambda) = (vec![[0.0; 3]; count], vec![[0.0; ROWS]; count]);
        Self { u: Vec::new(), s, lambda, iterations: 0, merit: f64::INFINITY }
    }
}

/// Conditions that end the method.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// Residual at which it is done.
    pub(super) residual: f64,
    /// Residual, over the goal, at which the first point that is good enough ends the method.
    /// `None` if only a slow method ends there.
    pub(super) first: Option<f64>,
}

impl Goal {
    /// The goal is this residual, or a slightly larger one where the method is slow.
    #[must_use]
    pub fn exact(residual: f64) -> Self {
        Self { residual, first: None }
    }

    /// The goal is the first point that is accurate enough, from a residual of `near` on.
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
