//! Search for the mechanism by which a static specimen collapses, for programs in which the solvers
//! found neither an equilibrium nor a proof that none exists.
//!
//! Of all motions u that the contacts allow, it is the one that minimises `1/2 w |u|^2 + D(u) -
//! load . u`, with D the dissipation at the limits of strength. This is a cone program too: the
//! bodies have the inertia w, all interactions are rigid and closed, and no motion is imposed. Its
//! solution is unique. It is zero if forces within the limits balance the loads; otherwise the
//! loads do more work on it than is dissipated (Moreau's decomposition of the loads), and it is the
//! mechanism of a [certificate](super::certificate).

use crate::program::{ConeProgram, ConeSolution, Dof, FreeDof, Interaction, Scales, SolveStatus};

use super::certificate::{certificate, proves};
use super::condensed::Condensed;
use super::solver::ConeSolver;

/// Returns a solution with the status `Collapsed` and a certificate that proves it, or `Stalled`.
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

/// The program of the mechanism. Its inertia w is such that the maximum load moves a free body by
/// one unit of length.
fn of_loads(program: &ConeProgram) -> ConeProgram {
    let length = program.scales.length;
    let mut maximum = 0.0_f64;
    for body in &program.bodies {
        for (k, dof) in body.dofs.iter().enumerate() {
            if let Dof::Free(free) = dof {
                maximum = maximum.max(free.load.abs() / if k < 2 { 1.0 } else { length });
            }
        }
    }
    let force = if maximum > 0.0 { maximum } else { program.scales.force };
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
            rolling_compliance: 0.0,
            previous_moment: 0.0,
            ..*c
        };
    }
    out.scales = Scales { length, displacement: 0.1 * length, force };
    out.tolerance = 0.0;
    out.last_forces.clear();
    out
}
