//! Looks for a mechanism by which a static specimen collapses, where no solver found equilibrium and none
//! said why.
//!
//! Of all motions u that the contacts allow, the one sought makes `1/2 w |u|^2 + D(u) - load . u` least, with
//! D the dissipation at the limits of strength. That is a cone program of the same kind: the bodies have
//! inertia w and nothing else, all interactions are rigid and closed, nothing is imposed. It has one solution,
//! which is zero where forces within the limits balance the loads, and otherwise does more work than is
//! dissipated (Moreau's decomposition of the loads): the mechanism of a
//! [certificate](super::certificate).

use crate::program::{ConeProgram, ConeSolution, Dof, FreeDof, Interaction, Scales, SolveStatus};

use super::certificate::{certificate, proves};
use super::condensed::Condensed;
use super::solver::ConeSolver;

/// Collapsed with a certificate that proves it, or stalled.
#[must_use]
pub fn find(program: &ConeProgram) -> ConeSolution {
    let motion = Condensed::default().solve(&of_loads(program)).unwrap_or_default();
    let iterations = motion.iterations;
    let solved = motion.status == SolveStatus::Solved;
    let found = solved.then(|| certificate(program, &motion.displacements)).flatten();
    match found.filter(proves) {
        Some(mechanism) => ConeSolution {
            status: SolveStatus::Collapsed,
            certificate: Some(mechanism),
            message: "mechanism".to_owned(),
            iterations,
            ..ConeSolution::default()
        },
        None => ConeSolution { iterations, ..ConeSolution::default() },
    }
}

/// The program of the motion along which the loads do most. The greatest of them would move a body on its
/// own by one unit of length.
fn of_loads(program: &ConeProgram) -> ConeProgram {
    let length = program.scales.length;
    let mut greatest = 0.0_f64;
    for body in &program.bodies {
        for (k, dof) in body.dofs.iter().enumerate() {
            if let Dof::Free(free) = dof {
                greatest = greatest.max(free.load.abs() / if k < 2 { 1.0 } else { length });
            }
        }
    }
    let force = if greatest > 0.0 { greatest } else { program.scales.force };
    let weight = force / length;
    let mut out = program.clone();
    for body in &mut out.bodies {
        for (k, dof) in body.dofs.iter_mut().enumerate() {
            *dof = match dof {
                Dof::Fixed(_) => Dof::Fixed(0.0),
                Dof::Free(free) => {
                    let inertia = if k < 2 { weight } else { weight * length * length };
                    Dof::Free(FreeDof { load: free.load, inertia, ..FreeDof::default() })
                }
            };
        }
    }
    for c in &mut out.interactions {
        *c = Interaction {
            offset: 0.0,
            normal_compliance: 0.0,
            tangential_compliance: 0.0,
            previous_shear: 0.0,
            ..*c
        };
    }
    out.scales = Scales { length, displacement: 0.1 * length, force };
    out.tolerance = 0.0;
    out.last_forces.clear();
    out
}
