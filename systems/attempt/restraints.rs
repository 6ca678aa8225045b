//! Restraints that keep grains without load from being thrown, found in solutions that throw them.

use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::{Bearing, Restraints};
use clastic_components::increment::Acceptance;
use clastic_cone::program::{ConeProgram, ConeSolution};

use crate::assemble_program::regularise::find_loaded;
use crate::mechanism::TAKES_PART;
use crate::turns::turns;

/// Finds grains without load that a solution throws: their motion is not determined. A grain that is
/// pushed after all was part of the load-bearing structure. Returns whether any of them changes the
/// program.
pub fn restrain(
    (bodies, contacts, program, solution): (&BodyTable, &ContactTable, &ConeProgram, &ConeSolution),
    acceptance: &Acceptance,
    restraints: &mut Restraints,
) -> bool {
    let turns = turns(bodies, contacts, program, solution);
    let forces = program.interactions.iter().zip(&solution.forces);
    let forces = forces.map(|(c, f)| (c.a, c.b, f[0].abs().max(f[1].abs())));
    let loaded = find_loaded(bodies.particles, forces);
    restraints.bearing.resize(program.bodies.len(), Bearing::Unknown);
    let mut found_new = false;
    for i in (0..bodies.particles).filter(|i| turns[*i] > TAKES_PART * acceptance.turn) {
        let next = match (restraints.bearing[i], loaded[i]) {
            (Bearing::Unknown, false) => Bearing::Nothing,
            (Bearing::Nothing, true) => Bearing::Load,
            (known, _) => known,
        };
        found_new |= std::mem::replace(&mut restraints.bearing[i], next) != next;
    }
    found_new
}
