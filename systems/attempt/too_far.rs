//! Judge: does a static solution turn contacts further than its constant normals are valid? It may
//! move a barely supported grain by many radii although its residuals are small. The grain lands on
//! others, and later increments lose load without a physical reason.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Effort, Verdict};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::{Corrections, Restraints};
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis};
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::converged::impossible_or;
use super::restraints::restrain;
use crate::places::{digits, near};
use crate::turns::{furthest, of_bonded};

/// Rejects a static solution that [turns](crate::turns) a bond or a contact that carries load by more
/// than [`Acceptance::turn`]. It may show [restraints](super::restraints), which the next attempt then
/// includes. Every such reply adds a restraint, of which a specimen has a finite number.
pub fn judge(
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    program: Res<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
    acceptance: Res<Acceptance>,
    analysis: Res<ClasticAnalysis>,
    corrections: Res<Corrections>,
    mut restraints: ResMut<Restraints>,
    mut attempt: ResMut<Attempt>,
) {
    if analysis.kind != AnalysisKind::Static {
        return;
    }
    // The passes have followed elastic bonds, which have no memory of the way.
    let is_followed = corrections.idle_motion.is_some();
    let found = furthest(&bodies, &contacts, &program, &solution, is_followed);
    let Some((grain, turn)) = found.filter(|(_, turn)| !(*turn <= acceptance.turn)) else { return };
    let all_regularised = attempt.effort() == Some(Effort::Regularised);
    let tables = (&*bodies, &*contacts, &*program, &*solution);
    attempt.turn = of_bonded(&bodies, (grain, turn));
    // With all grains regularised another regularised grain changes nothing.
    let is_new = !all_regularised && restrain(tables, &acceptance, &mut restraints);
    attempt.verdict = if is_new {
        Verdict::Again
    } else {
        let reason = format!(
            "one solution turns the contacts of {} by {} rad; `acceptance.turn` allows {}",
            near(&bodies, [grain, grain]),
            digits(turn),
            acceptance.turn
        );
        impossible_or(&program, &mut solution, Verdict::TooFar(reason))
    };
}
