//! Judge: did the solve end in a state that its residuals or its certificate support?

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, IncrementStatus, Verdict};
use clastic_components::contact::Bodies;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind};
use clastic_components::program::{ConeSolution, SolveStatus};

use super::magnitudes;
use crate::assemble_program::loose;

/// Moves of the centre of the regularisation in one attempt.
const MAX_CENTRES: u32 = 30;

/// Accepts solved and collapsed programs, moves the centre of a regularised one until its bias is
/// gone, rejects the rest.
pub fn judge(
    solution: Res<ConeSolution>,
    acceptance: Res<Acceptance>,
    analysis: Res<Analysis>,
    bodies: Res<Bodies>,
    mut attempt: ResMut<Attempt>,
    mut centres: Local<u32>,
) {
    attempt.status = match solution.status {
        SolveStatus::Solved => IncrementStatus::Solved,
        SolveStatus::Collapsed => IncrementStatus::Collapsed,
        SolveStatus::Locked => IncrementStatus::Locked,
        SolveStatus::Stalled => IncrementStatus::Stalled,
    };
    let r = &solution.residuals;
    attempt.verdict = match solution.status {
        SolveStatus::Solved | SolveStatus::Collapsed => Verdict::Accept,
        SolveStatus::Locked => {
            Verdict::Reject("locked: rigid bodies have no feasible motion".into())
        }
        SolveStatus::Stalled => {
            let biased = analysis.kind == AnalysisKind::Static
                && attempt.effort >= loose::RETRY
                && r.balance > acceptance.residual
                && r.kinematics.max(r.cone).max(r.complementarity) <= acceptance.residual;
            if attempt.centre.is_empty() {
                *centres = 0;
            }
            if biased && *centres < MAX_CENTRES {
                *centres += 1;
                attempt.centre.clone_from(&solution.displacements);
                Verdict::Again
            } else {
                Verdict::Reject(format!(
                    "the solver ended with {:?}; residuals: balance {:.1e}, kinematics {:.1e}, \
                     cone {:.1e}, complementarity {:.1e}; accepted {:.0e}",
                    solution.message, r.balance, r.kinematics, r.cone, r.complementarity,
                    acceptance.residual
                ))
            }
        }
    };
    if matches!(attempt.verdict, Verdict::Reject(_)) {
        attempt.magnitudes = magnitudes(&solution, bodies.mean_radius);
    }
}
