//! How much of the specimen a collapse moves, in words.

use clastic_components::contact::BodyTable;
use clastic_components::contact_history::ContactHistory;

/// Numbers and shares of the particles that move, and of the contacts with force that these have.
pub(super) fn share(bodies: &BodyTable, history: &ContactHistory, moving: &[bool]) -> String {
    let masses = || moving.iter().zip(&bodies.masses);
    let all: f64 = masses().map(|(_, mass)| mass).sum();
    let mass: f64 = masses().filter(|(moves, _)| **moves).map(|(_, mass)| mass).sum();
    let of_mass = if all > 0.0 {
        format!(" ({:.1} % of the mass)", 100.0 * mass / all)
    } else {
        String::new()
    };
    let is_moving = |row: u32| moving.get(row as usize).is_some_and(|moves| *moves);
    let contacts = history.0.iter().filter(|m| is_moving(m.a) || is_moving(m.b)).count();
    let of_contacts = match history.0.len() {
        0 => String::new(),
        all => format!(", which have {contacts} of the {all} contacts with force"),
    };
    let count = moving.iter().filter(|moves| **moves).count();
    format!("{count} of {} particles{of_mass}{of_contacts}", bodies.particles)
}
