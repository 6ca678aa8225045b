//! Why an increment has no equilibrium, in words.

use bevy_ecs::prelude::*;

use clastic_components::contact::BodyTable;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::restraints::{takes_part, translations};
use super::share::share;
use crate::places::moves_most;

/// The reason for a collapse that a mechanism proves, with the body that moves most in it and the share
/// of the specimen that moves; `None` if no mechanism proves it.
#[must_use]
pub fn proof(world: &World) -> Option<String> {
    let certificate = world.get_resource::<ConeSolution>()?.certificate.as_ref()?;
    let (bodies, program) =
        (world.get_resource::<BodyTable>()?, world.get_resource::<ConeProgram>()?);
    let most = moves_most(bodies, program, &certificate.mechanism);
    let most = most.map_or(String::new(), |(body, _)| format!(", in which {body} moves most"));
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
