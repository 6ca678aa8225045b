//! Restraints that keep grains from being thrown, found in solutions that throw them. Grains
//! without load are regularised, and taut bonds [pull back](taut) grains that swing about them.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::{Bearing, Restraints};
use clastic_components::increment::Acceptance;
use clastic_cone::program::{ConeProgram, ConeSolution, Interaction};

use crate::assemble_program::regularise::find_loaded;
use crate::assemble_program::taut;
use crate::mechanism::{TAKES_PART, takes_part, translations};
use crate::turns::turns;

/// Judge: is a collapse the mechanism of grains that hang on taut bonds? The program lacks their
/// geometric stiffness and is solved again with it.
pub fn judge(
    bodies: Res<BodyTable>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut restraints: ResMut<Restraints>,
    mut attempt: ResMut<Attempt>,
) {
    let Some(certificate) = &solution.certificate else { return };
    let mut far = translations(certificate);
    far.truncate(bodies.particles);
    if pull_back(&bodies, &program, &mut restraints, takes_part(&far)) {
        attempt.verdict = Verdict::Again;
    }
}

/// Adds the restraints that a solution with thrown grains shows. Returns whether any of them
/// changes the program. With `all_regularised` another regularised grain does not.
pub fn restrain(
    (bodies, contacts, program, solution): (&BodyTable, &ContactTable, &ConeProgram, &ConeSolution),
    acceptance: &Acceptance,
    restraints: &mut Restraints,
    all_regularised: bool,
) -> bool {
    let turns = turns(bodies, contacts, program, solution);
    let far = |i: usize| turns[i] > TAKES_PART * acceptance.turn;
    let unloaded = !all_regularised && hold_unloaded(bodies, program, solution, restraints, far);
    let swinging = pull_back(bodies, program, restraints, far);
    unloaded || swinging
}

/// Finds grains without load, whose motion is not determined. A grain that is pushed after all was
/// part of the load-bearing structure.
fn hold_unloaded(
    bodies: &BodyTable,
    program: &ConeProgram,
    solution: &ConeSolution,
    restraints: &mut Restraints,
    far: impl Fn(usize) -> bool,
) -> bool {
    let forces = program.interactions.iter().zip(&solution.forces);
    let forces = forces.map(|(c, f)| (c.a, c.b, f[0].abs().max(f[1].abs())));
    let loaded = find_loaded(bodies.particles, forces);
    restraints.bearing.resize(program.bodies.len(), Bearing::Unknown);
    let mut found_new = false;
    for i in (0..bodies.particles).filter(|i| far(*i)) {
        let next = match (restraints.bearing[i], loaded[i]) {
            (Bearing::Unknown, false) => Bearing::Nothing,
            (Bearing::Nothing, true) => Bearing::Load,
            (known, _) => known,
        };
        found_new |= std::mem::replace(&mut restraints.bearing[i], next) != next;
    }
    found_new
}

/// Finds grains that swing. Only grains with a taut bond count as new.
fn pull_back(
    bodies: &BodyTable,
    program: &ConeProgram,
    restraints: &mut Restraints,
    far: impl Fn(usize) -> bool,
) -> bool {
    restraints.swinging.resize(bodies.particles, false);
    let mut found_new = vec![false; program.bodies.len()];
    for i in (0..bodies.particles).filter(|i| far(*i)) {
        found_new[i] = !std::mem::replace(&mut restraints.swinging[i], true) && !bodies.swinging[i];
    }
    let joins_particles = |c: &Interaction| (c.b as usize) < bodies.particles;
    let forces = program.interactions.iter().zip(&program.last_forces);
    let mut taut = forces.filter(|(c, last)| joins_particles(c) && taut::is_taut(c, last));
    taut.any(|(c, _)| found_new[c.a as usize] || found_new[c.b as usize])
}
