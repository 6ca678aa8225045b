//! How much of the specimen a collapse moves, in words.

use clastic_components::contact::BodyTable;
use clastic_components::contact_history::ContactHistory;

/// Number of the particles that move.
pub(super) fn count(moving: &[bool]) -> usize {
    moving.iter().filter(|moves| **moves).count()
}

/// Numbers and shares of the particles that move, and of the contacts with force that these have.
pub(super) fn share(bodies: &BodyTable, history: &ContactHistory, moving: &[bool]) -> String {
    let masses = || moving.iter().zip(&bodies.masses);
    let all: f64 = masses().map(|(_, mass)| mass).sum();
    let mass: f64 = masses().filter(|(moves, _)| **moves).map(|(_, mass)| mass).sum();
    let of_mass = match all > 0.0 {
        true => format!(" ({:.1} % of the mass)", 100.0 * mass / all),
        false => String::new(),
    };
    let is_moving = |row: u32| moving.get(row as usize).is_some_and(|moves| *moves);
    let contacts = history.0.iter().filter(|m| is_moving(m.a) || is_moving(m.b)).count();
    let of_contacts = match history.0.len() {
        0 => String::new(),
        all => format!(", which have {contacts} of the {all} contacts with force"),
    };
    format!("{} of {} particles{of_mass}{of_contacts}", count(moving), bodies.particles)
}
