//! Which interactions of a solution carry a force.

use super::{displacement_scale, force_scale, multipliers};
use crate::program::{ConeProgram, ConeSolution};

/// Tells which interactions carry a normal force. An interior point leaves a small force on open
/// contacts: the complementarity product over the gap.
pub struct Carrying<'a> {
    program: &'a ConeProgram,
    solution: &'a ConeSolution,
    /// Maximum normal force that counts as zero, N.
    threshold: f64,
    /// Maximum force, N, and displacement, m, if gaps count too.
    units: Option<[f64; 2]>,
}

impl<'a> Carrying<'a> {
    /// The interactions of a solution.
    ///
    /// In statics an interaction carries a force above 1e-9 of the maximum force. In dynamics a
    /// solution may have products up to the tolerance, and the force must also exceed the gap, each
    /// over its maximum.
    pub fn new(program: &'a ConeProgram, solution: &'a ConeSolution) -> Self {
        let force = force_scale(program, &solution.forces);
        let dynamic = program.is_dynamic();
        let products = if dynamic { solution.tolerance } else { 0.0 };
        let threshold = products.max(MIN_RELATIVE_FORCE) * force;
        let units = (dynamic && solution.displacements.len() == program.bodies.len())
            .then(|| [force, displacement_scale(program, &solution.displacements)]);
        Self { program, solution, threshold, units }
    }

    /// Whether interaction `k` carries a normal force.
    pub fn is_carrying(&self, k: usize) -> bool {
        let (c, f) = (&self.program.interactions[k], &self.solution.forces[k]);
        let p = f[0].abs();
        p > self.threshold
            && self.units.is_none_or(|[force, displacement]| {
                let e = self.program.kinematics(c, &self.solution.displacements);
                p * displacement >= multipliers(self.solution.law, c, &e, f).tension * force
            })
    }
}

/// Normal force, over the maximum force, below which an interaction carries none.
const MIN_RELATIVE_FORCE: f64 = 1e-9;
