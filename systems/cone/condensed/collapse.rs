//! Proof of a collapse where the interior point has not solved a static program: the
//! [mechanism](crate::mechanism) of the loads, sought by an interior point of its own.
//!
//! Without a solution the displacements of the program grow without bound, and its iterates
//! approach a mechanism slowly. The program of the mechanism always has a solution, and the method
//! ends with the first point whose [certificate] proves the collapse.
//! Only programs with bonds are examined. A loose packing without bonds that has no equilibrium
//! nearby is followed as a motion; a mechanism would add the pairs that it closes, and the next
//! solution would jump to another packing (decision 015).
//! Where forces within the limits balance the loads there is no mechanism: the motion vanishes, and
//! the method ends there too. A small residual does not end it: it says nothing about a point that
//! still moves and proves no collapse.

use super::interior::{self, Interior};
use super::parallel::in_pool;
use super::scaled::Scaled;
use super::{Condensed, ROUND_OFF};
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
        // Zero forces are within all limits and balance zero loads.
        let is_loaded = |dof: &Dof| matches!(dof, Dof::Free(free) if free.load != 0.0);
        let is_loaded = program.bodies.iter().any(|body| body.dofs.iter().any(is_loaded));
        if has_solution || !is_loaded || program.is_dynamic() || !program.has_bonds() {
            return None;
        }
        let motion = mechanism::of_loads(program);
        self.prepare(&motion)?;
        let matrix = self.matrix.as_mut()?;
        let order = matrix.order().to_vec();
        let is_shared = matrix.is_shared();
        let scaled = Scaled::new(&motion, &order);
        matrix.set_images(&scaled.images);
        let proof = |point: &Interior| proof(program, &motion, &order, point);
        let settings = &self.settings;
        let minimum = settings.proof.min_motion * motion.scales.length / motion.scales.displacement;
        let vanishes = |point: &Interior| interior::max_magnitude(&point.u) <= minimum;
        let start = vec![[0.0; 3]; order.len()];
        let goal = interior::Goal::enough(ROUND_OFF, settings.proof.max_residual);
        let point = in_pool(is_shared, || {
            interior::solve(&scaled, matrix, &start, &settings.interior, goal, |point| {
                vanishes(point) || proof(point).is_some()
            })
        })?;
        *iterations += point.iterations;
        let certificate = proof(&point)?;
        let (_, df) = units(&motion);
        Some(ConeSolution {
            status: SolveStatus::Collapsed,
            message: "mechanism".to_owned(),
            iterations: *iterations,
            forces: point.s.iter().map(|s| [s[0] * df[0], s[1] * df[0], s[2] * df[2]]).collect(),
            displacements: certificate.mechanism.clone(),
            certificate: Some(certificate),
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

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::CondensedSettings;
    use super::super::samples::{contact, held, loaded};
    use super::*;
    use crate::program::Limits;

    /// A body on an elastic contact with |q| <= 0.2 + 0.5 p, p >= -0.4, under these loads.
    fn on_a_floor(x: f64, y: f64) -> ConeProgram {
        let mut floor = contact(0, 1, DVec2::Y, 1.0, 0.5);
        floor.limits = Limits { cohesion: 0.2, tension: 0.4, ..Limits::new(0.0, 0.5, 0.0, 0.0) };
        ConeProgram {
            bodies: vec![held(), loaded(x, y)],
            interactions: vec![floor],
            ..ConeProgram::default()
        }
    }

    fn sought(program: &ConeProgram) -> (Option<ConeSolution>, u32) {
        let mut iterations = 0;
        let found = Condensed::default().try_proof(program, &mut iterations);
        (found, iterations)
    }

    /// Of all mechanisms u = (1, y), y >= 0.5, that of sliding has the maximum margin: with
    /// y = 0.5 the loads (1, -1) do the work 0.5, and 0.2 is dissipated, so that it is 0.6.
    #[test]
    fn a_body_that_slides_off_is_proved_to_collapse() {
        let (found, iterations) = sought(&on_a_floor(1.0, -1.0));
        let certificate = found.unwrap().certificate.unwrap();
        assert!(certificate.margin > 0.5 && certificate.margin <= 0.6 + 1e-6, "{certificate:?}");
        assert!(certificate.defect < 1e-6 && iterations <= 20, "{iterations} {certificate:?}");
        assert_eq!(certificate.mechanism[0], [0.0; 3]);
    }

    #[test]
    fn contacts_without_bonds_are_left_to_the_fallback() {
        let mut program = on_a_floor(1.0, -1.0);
        program.interactions[0].limits = Limits::new(0.0, 0.5, 0.0, 0.0);
        assert!(sought(&program).0.is_none());
    }

    #[test]
    fn nothing_is_sought_without_loads() {
        let (found, iterations) = sought(&on_a_floor(0.0, 0.0));
        assert!(found.is_none() && iterations == 0);
    }

    /// The shear limit at p = 1 is 0.7: forces balance 0.699 and do not balance 0.701.
    #[test]
    fn the_proof_begins_where_forces_no_longer_balance_the_loads() {
        assert!(sought(&on_a_floor(0.699, -1.0)).0.is_none());
        assert!(sought(&on_a_floor(0.701, -1.0)).0.is_some());
    }

    #[test]
    fn a_program_with_a_weight_on_every_degree_of_freedom_has_a_solution() {
        let mut program = on_a_floor(1.0, -1.0);
        for dof in &mut program.bodies[1].dofs {
            if let Dof::Free(free) = dof {
                free.proximal = 1e-3;
            }
        }
        let (found, iterations) = sought(&program);
        assert!(found.is_none() && iterations == 0);
    }

    /// Clarabel, with no iteration allowed, has no part in the verdict of a whole solve.
    #[test]
    fn a_collapse_needs_no_fallback() {
        let mut settings = CondensedSettings::default();
        settings.fallback.max_iterations = 0;
        settings.fallback.polish = None;
        let solution =
            crate::solver::ConeSolver::solve(&mut Condensed::new(settings), &on_a_floor(1.0, -1.0));
        assert_eq!(solution.unwrap().status, SolveStatus::Collapsed);
    }
}
