//! Judge: does a static solution turn contacts further than its constant normals are valid, or move
//! bodies that nothing holds? It may move a barely supported grain by many radii although its
//! residuals are small. The grain lands on others, and later increments lose load without a physical
//! reason. A lid that is unloaded to nothing would be anywhere above the specimen.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Effort, Verdict};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::{Bearing, Corrections};
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis};
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::converged::impossible_or;
use crate::assemble_program::regularise::MIN_LOAD;
use crate::mechanism::TAKES_PART;
use crate::places::{digits, near};
use crate::solved::Solved;
use crate::turns::{of_bonded, too_far, turns};
use clastic_cone::residuals::force_scale;

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
    let solved =
        Solved { bodies: &bodies, contacts: &contacts, program: &program, solution: &solution };
    let far = too_far(solved, &acceptance, &corrections);
    // With all grains regularised another regularised grain changes nothing.
    let is_new = attempt.effort() != Some(Effort::Regularised)
        && restrain(solved, far.map(|_| acceptance.turn), &mut attempt.bearing);
    attempt.turn = far.and_then(|far| of_bonded(&bodies, far));
    if is_new {
        attempt.verdict = Verdict::Again;
        return;
    }
    let Some((grain, turn)) = far else { return };
    let reason = format!(
        "one solution turns the contacts of {} by {} rad; `acceptance.turn` allows {}",
        near(&bodies, [grain, grain]),
        digits(turn),
        acceptance.turn
    );
    attempt.verdict = impossible_or(&program, &mut solution, Verdict::TooFar(reason));
}

/// Displacement, mean radii, up to which a body that carries nothing may move further than it must.
const MIN_MOTION: f64 = 1e-4;

/// Finds bodies without load whose motion is not determined: those that move further than the scale of
/// displacements. Where the solution turns contacts `too_far` (rad), they are also the grains that it
/// turns, and a grain that is pushed after all was part of the load-bearing structure. Returns whether
/// any of them changes the program.
fn restrain(solved: Solved, too_far: Option<f64>, bearing: &mut Vec<Bearing>) -> bool {
    let Solved { program, solution, .. } = solved;
    let rows = program.bodies.len();
    let (mut loaded, mut bonded) = (vec![false; rows], vec![false; rows]);
    // Beside a specimen that is unloaded to nothing all forces are round-off.
    let least = MIN_LOAD * force_scale(program, &solution.forces);
    for (c, f) in program.interactions.iter().zip(&solution.forces) {
        for body in [c.a as usize, c.b as usize] {
            loaded[body] |= f[0].abs().max(f[1].abs()) > least;
            bonded[body] |= c.limits.has_strength();
        }
    }
    if let Some(cell) = &program.cell {
        loaded[cell.body as usize] = loaded.contains(&true);
    }
    let far = program.scales.displacement.max(MIN_MOTION * program.scales.length);
    let is_loose = |i: usize| {
        let (body, u) = (&program.bodies[i], &solution.displacements[i]);
        let has_no_load = body.free().all(|(_, dof)| dof.proximal == 0.0 && dof.load == 0.0);
        let is_held = loaded[i] || bonded[i] || !body.is_free();
        !is_held && u[0].hypot(u[1]) > far && has_no_load
    };
    let turns = too_far.map_or(Vec::new(), |_| turns(solved));
    let is_thrown = |i: usize| {
        too_far.zip(turns.get(i)).is_some_and(|(turn, of_grain)| *of_grain > TAKES_PART * turn)
    };
    bearing.resize(rows, Bearing::Unknown);
    let mut found_new = false;
    for i in 0..rows {
        let next = match bearing[i] {
            Bearing::Unknown if !loaded[i] && (is_thrown(i) || is_loose(i)) => Bearing::Nothing,
            Bearing::Nothing if loaded[i] && is_thrown(i) => Bearing::Load,
            known => known,
        };
        found_new |= std::mem::replace(&mut bearing[i], next) != next;
    }
    found_new
}
