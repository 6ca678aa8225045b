//! Judge: was a grain thrown? A barely supported grain may be moved by many radii in one static
//! increment whose residuals are perfect; it lands on others, and the increments that follow lose
//! load for no physical reason. Motion is judged about the affine field that fits all grains best.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::findings::{AddedPairs, Restraints};
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind};
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::closed_pairs::add_closed;
use super::restraints::restrain;
use crate::detect_contacts::Candidates;
use crate::mean_field::furthest;

/// Attempts in a row that are made with what a throw has shown, before the motion is followed.
const MAX_REPLIES: u32 = 3;

/// Rejects a static solution in which a grain moves further than [`Acceptance::throw`] radii
/// about the mean field.
pub fn judge(
    bodies: Res<Bodies>,
    candidates: Res<Candidates>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    acceptance: Res<Acceptance>,
    analysis: Res<Analysis>,
    mut pairs: ResMut<AddedPairs>,
    mut restraints: ResMut<Restraints>,
    mut attempt: ResMut<Attempt>,
) {
    if analysis.kind != AnalysisKind::Static {
        return;
    }
    if let Some(reason) = thrown(&bodies, &program, &solution, &acceptance) {
        attempt.verdict = reply(
            &bodies,
            &candidates,
            &contacts,
            &program,
            &solution,
            &acceptance,
            &mut pairs,
            &mut restraints,
            reason,
        );
    }
}

/// What to do about a throw. It shows pairs that were not in the program, or
/// [restraints](super::restraints): the next attempt has them. Where it shows nothing, or where that has not
/// helped, the solution lies too far away.
pub(super) fn reply(
    bodies: &Bodies,
    candidates: &Candidates,
    contacts: &Contacts,
    program: &ConeProgram,
    solution: &ConeSolution,
    acceptance: &Acceptance,
    pairs: &mut AddedPairs,
    restraints: &mut Restraints,
    reason: String,
) -> Verdict {
    // What stops a grain must not be mistaken for what holds it back.
    let learnt = add_closed(bodies, candidates, contacts, program, solution, acceptance, pairs)
        || restrain(bodies, program, solution, acceptance, restraints);
    if learnt && restraints.replies < MAX_REPLIES {
        restraints.replies += 1;
        Verdict::Again
    } else {
        Verdict::TooFar(reason)
    }
}

/// Complaint about the grain that a solution throws furthest, if it throws any too far.
#[must_use]
pub fn thrown(
    bodies: &Bodies,
    program: &ConeProgram,
    solution: &ConeSolution,
    acceptance: &Acceptance,
) -> Option<String> {
    let (i, far) = furthest(bodies, program, solution)?;
    (!(far <= acceptance.throw)).then(|| {
        let at = bodies.positions[i];
        format!(
            "{} at ({:.4e}, {:.4e}) m was thrown by {far:.2} radii about the mean motion; accepted {}",
            bodies.name(i), at.x, at.y, acceptance.throw
        )
    })
}
