//! How far a step of a followed motion carries grains: the measure of whether its geometry is valid.
//!
//! Two things go wrong in a long step. The normal of a contact that carries load, or of a bond, turns:
//! the tangential motion of the grain relative to its partner, over its radius, is its travel. And a
//! grain passes through others that are not in the program: its way over the radius counts with the
//! factor `WAY`, without load as a whole. The way is that beyond the greatest imposed motion, since
//! bodies move with what drives them.

use clastic_components::contact::{BodyTable, ContactTable};
use clastic_cone::program::{ConeProgram, ConeSolution};

use crate::assemble_program::scales::maximum_imposed;
use crate::turns::{is_imposed, of_pairs};

/// Travel of a grain that carries load over its way in radii. A step of the maximum travel carries it
/// by one radius, so that it passes no other grain.
const WAY: f64 = 0.3;

/// The grain with the maximum travel, and this travel in its radii. Grains with an imposed motion have
/// none.
#[must_use]
pub fn furthest(
    bodies: &BodyTable,
    contacts: &ContactTable,
    program: &ConeProgram,
    solution: &ConeSolution,
) -> Option<(usize, f64)> {
    let imposed = maximum_imposed(bodies);
    let turns = of_pairs(bodies, contacts, program, solution).loaded;
    let travel = |i: usize| {
        let u = &solution.displacements[i];
        let way = (u[0].hypot(u[1]) - imposed).max(0.0) / bodies.radii[i];
        turns[i].map_or(way, |turn| (2.0 * turn).max(WAY * way))
    };
    let free = (0..bodies.particles).filter(|i| !is_imposed(bodies, *i));
    free.map(|i| (i, travel(i))).max_by(|a, b| a.1.total_cmp(&b.1))
}
