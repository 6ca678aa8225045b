//! Proof of a collapse where the interior point has not solved a static program: the
//! [mechanism](crate::mechanism) of the loads, sought by an interior point of its own.
//!
//! Without a solution the displacements of the program grow without bound, and its iterates
//! approach a mechanism slowly. The program of the mechanism always has a solution, and the method
//! ends with the first point whose [certificate] proves the collapse.
//! Where forces within the limits balance the loads there is no mechanism: the motion vanishes, and
//! the method ends there too.

use super::Condensed;
use super::interior::{self, Interior};
use super::parallel::in_pool;
use super::scaled::Scaled;
use crate::certificate::{certificate, proves};
use crate::lowering::units;
use crate::mechanism;
use crate::program::{Certificate, ConeProgram, ConeSolution, Dof, SolveStatus};

impl Condensed {
    /// The proof that a static program has no solution; `None` if none is found. Adds the
    /// factorisations to `iterations` in any case.
    pub(super) fn try_proof(
        &mut self,
        program: &ConeProgram,
        iterations: &mut u32,
    ) -> Option<ConeSolution> {
        let is_held = |dof: &Dof| match dof {
            Dof::Fixed(_) => true,
            Dof::Free(free) => free.inertia + free.proximal > 0.0,
        };
        // A program with a weight on every degree of freedom has a solution.
        let has_solution = program.bodies.iter().all(|body| body.dofs.iter().all(is_held));
        if has_solution || program.is_dynamic() || program.interactions.is_empty() {
            return None;
        }
        let motion = mechanism::of_loads(program);
        self.prepare(&motion)?;
        let matrix = self.matrix.as_mut()?;
        let order = matrix.order().to_vec();
        let has_branches = !matrix.branches().is_empty();
        let scaled = Scaled::new(&motion, &order);
        matrix.set_images(&scaled.images);
        let proof = |point: &Interior| proof(program, &motion, &order, point);
        let settings = &self.settings;
        let minimum = settings.proof.min_motion * motion.scales.length / motion.scales.displacement;
        let vanishes = |point: &Interior| interior::max_magnitude(&point.u) <= minimum;
        let start = vec![[0.0; 3]; order.len()];
        let goal = interior::Goal::enough(settings.proof.residual, settings.proof.max_residual);
        let point = in_pool(has_branches, || {
            interior::solve(&scaled, matrix, &start, &settings.interior, goal, |point| {
                vanishes(point) || proof(point).is_some()
            })
        })?;
        *iterations += point.iterations;
        let certificate = proof(&point)?;
        Some(ConeSolution {
            status: SolveStatus::Collapsed,
            certificate: Some(certificate),
            message: "mechanism".to_owned(),
            iterations: *iterations,
            ..ConeSolution::default()
        })
    }
}

/// The certificate of a point of the mechanism's program, if it proves the collapse.
fn proof(
    program: &ConeProgram,
    motion: &ConeProgram,
    order: &[usize],
    point: &Interior,
) -> Option<Certificate> {
    let (du, _) = units(motion);
    let mut displacements = vec![[0.0; 3]; order.len()];
    for (u, &i) in point.u.iter().zip(order) {
        displacements[i] = [0, 1, 2].map(|k| u[k] * du[k]);
    }
    certificate(program, &displacements).filter(proves)
}
