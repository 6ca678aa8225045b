//! Why an increment has no equilibrium, in words.

use bevy_ecs::prelude::*;

use clastic_components::contact::BodyTable;
use clastic_cone::program::{Certificate, ConeProgram, ConeSolution};

use super::places::moves_most;
use super::restraints::{takes_part, translations};
use super::share::{count, share};

/// The reason for a collapse that a mechanism proves, with the body that moves most in it and the share
/// of the specimen that moves; `None` if no mechanism proves it.
#[must_use]
pub fn proof(world: &World) -> Option<String> {
    let certificate = world.get_resource::<ConeSolution>()?.certificate.as_ref()?;
    let (bodies, program) =
        (world.get_resource::<BodyTable>()?, world.get_resource::<ConeProgram>()?);
    let most = moves_most(bodies, program, &certificate.mechanism);
    let most = most.map_or(String::new(), |(body, _)| format!(", in which {body} moves most"));
    let moving = share(bodies, world.get_resource()?, &moving(bodies, certificate));
    Some(format!("no equilibrium exists: a mechanism proves it{most}; it moves {moving}"))
}

/// Which particles a mechanism moves.
fn moving(bodies: &BodyTable, certificate: &Certificate) -> Vec<bool> {
    let far = translations(certificate);
    (0..bodies.particles).map(takes_part(&far)).collect()
}

/// Drops a mechanism that moves less than a quarter of the `moved` particles that the motion without rest
/// has moved: a grain that falls on a slope is no proof that the slope slides.
pub(super) fn drop_a_lesser_one(world: &mut World, moved: usize) {
    let bodies = world.resource::<BodyTable>();
    let is_less = |certificate: &Certificate| 4 * count(&moving(bodies, certificate)) < moved;
    if world.resource::<ConeSolution>().certificate.as_ref().is_some_and(is_less) {
        world.resource_mut::<ConeSolution>().certificate = None;
    }
}
