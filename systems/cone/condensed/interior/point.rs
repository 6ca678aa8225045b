//! A point of the method, where the method starts and where it ends.

use crate::condensed::scaled::{ROWS, Scaled};
use crate::program::SolveStatus;
use crate::residuals::max_or_nan;

/// An interior point.
#[derive(Clone)]
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
    /// A point at rest without forces.
    pub(super) fn of(program: &Scaled) -> Self {
        let count = program.locals.len();
        let (s, lambda) = (vec![[0.0; 3]; count], vec![[0.0; ROWS]; count]);
        let u = vec![[0.0; 3]; program.free.len()];
        Self { u, s, lambda, iterations: 0, merit: f64::INFINITY }
    }
}

/// The program's own judgement of points and directions, in units and order of the matrix.
pub trait Judge {
    /// Whether the point solves the program within its tolerance.
    fn is_solution(&self, point: &Interior) -> bool;

    /// What a point or a step proves: a collapse if the displacements are a mechanism, or that rigid
    /// bodies are locked by the forces.
    fn proof(&self, point: &Interior) -> Option<SolveStatus>;
}

/// Conditions that end the method.
#[derive(Clone, Copy, Debug, Default)]
pub struct Goal {
    /// Residual at which it is done, or at a slightly larger one where it is slow.
    pub residual: f64,
    /// Whether the first point that solves the program ends the method.
    pub at_once: bool,
    /// Maximum of the smaller of slack and multiplier of a limit, which decides of every limit
    /// whether it is active; `None` for no maximum.
    pub decided: Option<f64>,
    /// Whether a solution stays in the middle of the set of solutions, with limits undecided.
    pub in_middle: bool,
    /// Whether the method looks for proofs that the program has no solution.
    pub seeks_proofs: bool,
}

/// Part of the way to the boundary that a step takes at a mean product. Near a solution it may take
/// nearly all of it: decision 001 has 0.99 and 0.9995.
pub(crate) fn part_of_way(mean_product: f64) -> f64 {
    (1.0 - mean_product).clamp(0.99, 0.9995)
}

/// Maximum magnitude; not a number if any of them is not.
pub(crate) fn max_magnitude(rows: &[[f64; 3]]) -> f64 {
    rows.iter().flatten().map(|r| r.abs()).fold(0.0, max_or_nan)
}
