//! Judge: does a static solution turn contacts further than its constant normals are valid? It may
//! move a barely supported grain by many radii although its residuals are small. The grain lands on
//! others, and later increments lose load without a physical reason.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Effort, Verdict};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::{Bearing, Corrections};
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis};
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::converged::impossible_or;
use crate::assemble_program::regularise::find_loaded;
use crate::mechanism::TAKES_PART;
use crate::places::{digits, near};
use crate::solved::Solved;
use crate::turns::{furthest, of_bonded, turns};

/// Rejects a static solution that [turns](crate::turns) a bond or a contact that carries load by more
/// than [`Acceptance::turn`]. It may show [`Bearing`], which the next attempt then includes. Every
/// such reply adds a restraint, of which a specimen has a finite number.
pub fn judge(
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    program: Res<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
    acceptance: Res<Acceptance>,
    analysis: Res<ClasticAnalysis>,
    corrections: Res<Corrections>,
    mut attempt: ResMut<Attempt>,
) {
    if analysis.kind != AnalysisKind::Static {
        return;
    }
    // The passes have followed elastic bonds, which have no memory of the way.
    let is_followed = corrections.idle_motion.is_some();
    let solved =
        Solved { bodies: &bodies, contacts: &contacts, program: &program, solution: &solution };
    let found = furthest(solved, is_followed);
    let Some((grain, turn)) = found.filter(|(_, turn)| !(*turn <= acceptance.turn)) else { return };
    let all_regularised = attempt.effort() == Some(Effort::Regularised);
    attempt.turn = of_bonded(&bodies, (grain, turn));
    // With all grains regularised another regularised grain changes nothing.
    let is_new = !all_regularised && restrain(solved, &acceptance, &mut attempt.bearing);
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

/// Finds grains without load that a solution throws: their motion is not determined. A grain that is
/// pushed after all was part of the load-bearing structure. Returns whether any of them changes the
/// program.
pub fn restrain(solved: Solved, acceptance: &Acceptance, bearing: &mut Vec<Bearing>) -> bool {
    let Solved { bodies, program, solution, .. } = solved;
    let turns = turns(solved);
    let forces = program.interactions.iter().zip(&solution.forces);
    let forces = forces.map(|(c, f)| (c.a, c.b, f[0].abs().max(f[1].abs())));
    let loaded = find_loaded(bodies.particles, forces);
    bearing.resize(program.bodies.len(), Bearing::Unknown);
    let mut found_new = false;
    for i in (0..bodies.particles).filter(|i| turns[*i] > TAKES_PART * acceptance.turn) {
        let next = match (bearing[i], loaded[i]) {
            (Bearing::Unknown, false) => Bearing::Nothing,
            (Bearing::Nothing, true) => Bearing::Load,
            (known, _) => known,
        };
        found_new |= std::mem::replace(&mut bearing[i], next) != next;
    }
    found_new
}
