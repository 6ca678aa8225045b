//! How far a step of a followed motion carries grains: the measure of whether its geometry is valid.
//!
//! A long step has two errors:
//!
//! - The normal of a bond, or of a contact that carries load, turns on the way. The grain's motion along
//!   the contact, over its radius, measures it.
//! - A grain passes through others, whose contacts the program does not have. Its displacement over
//!   its radius measures it, times `DISPLACEMENT_FACTOR` if it carries load. Bodies move with
//!   what drives them, so that the maximum imposed motion is subtracted first.
//!
//! The travel of a grain is the larger of the two, in radii.

use crate::assemble_program::scales::maximum_imposed;
use crate::solved::Solved;
use crate::turns::{is_imposed, of_pairs};

/// Factor of the displacement of a grain that carries load. The maximum travel of a step then allows a
/// displacement of one radius, in which it passes no other grain.
const DISPLACEMENT_FACTOR: f64 = 0.3;

/// The grain with the maximum travel, and this travel in its radii. Grains whose whole translation is
/// imposed have none.
pub fn furthest(solved: Solved) -> Option<(usize, f64)> {
    let Solved { bodies, contacts, solution, .. } = solved;
    let imposed = maximum_imposed(bodies);
    let turns = of_pairs(solved, |k| contacts.0[k].normal).loaded;
    let travel = |i: usize| {
        let u = &solution.displacements[i];
        let way = (u[0].hypot(u[1]) - imposed).max(0.0) / bodies.radii[i];
        turns[i].map_or(way, |turn| (2.0 * turn).max(DISPLACEMENT_FACTOR * way))
    };
    let free = (0..bodies.particles).filter(|i| !is_imposed(bodies, *i));
    free.map(|i| (i, travel(i))).max_by(|a, b| a.1.total_cmp(&b.1))
}
