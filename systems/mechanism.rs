//! What moves in a mechanism, and why an increment has no equilibrium, in words.

use bevy_ecs::prelude::*;

use clastic_components::contact::BodyTable;
use clastic_components::contact_history::ContactHistory;
use clastic_cone::program::{Certificate, ConeProgram, ConeSolution};

use crate::places::moves_most;

/// Bodies that move further than this fraction of the accepted turn, or of the maximum motion of a
/// mechanism, take part in it.
pub(crate) const TAKES_PART: f64 = 0.1;

/// How far a mechanism moves each body, relative to the others.
pub(crate) fn translations(certificate: &Certificate) -> Vec<f64> {
    certificate.mechanism.iter().map(|u| u[0].hypot(u[1])).collect()
}

/// Whether a body takes part in a mechanism that moves the bodies this far.
pub(crate) fn takes_part(far: &[f64]) -> impl Fn(usize) -> bool + '_ {
    let maximum = far.iter().copied().fold(0.0, f64::max);
    move |i| far[i] > TAKES_PART * maximum
}

/// The reason for a collapse that a mechanism proves, with the body that moves most in it and the share
/// of the specimen that moves; `None` if no mechanism proves it.
pub fn proof(world: &World) -> Option<String> {
    let certificate = world.get_resource::<ConeSolution>()?.certificate.as_ref()?;
    let (bodies, program) =
        (world.get_resource::<BodyTable>()?, world.get_resource::<ConeProgram>()?);
    let most = moves_most(bodies, program, &certificate.mechanism);
    let most = most.map_or(String::new(), |most| format!(", in which {most}"));
    let mut far = translations(certificate);
    far.truncate(bodies.particles);
    let moving: Vec<_> = (0..bodies.particles).map(takes_part(&far)).collect();
    // One of walls, or of disks that turn, moves no particle.
    let share = if moving.contains(&true) {
        format!("; it moves {}", share(bodies, world.get_resource()?, &moving))
    } else {
        String::new()
    };
    Some(format!("no equilibrium exists: a mechanism proves it{most}{share}"))
}

/// Numbers and shares of the particles that move, and of the contacts with force that these have.
pub(crate) fn share(bodies: &BodyTable, history: &ContactHistory, moving: &[bool]) -> String {
    let masses = || moving.iter().zip(&bodies.masses);
    let all: f64 = masses().map(|(_, mass)| mass).sum();
    // The sum of no numbers is -0.0.
    let mass = masses().filter(|(moves, _)| **moves).map(|(_, mass)| mass).sum::<f64>() + 0.0;
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
