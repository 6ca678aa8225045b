//! Why an increment has no equilibrium, in words.

use bevy_ecs::prelude::*;

use clastic_components::contact::BodyTable;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::places::moves_most;

/// The reason for a collapse that a mechanism proves, with the body that moves most in it; `None`
/// if no mechanism proves it.
#[must_use]
pub fn proof(world: &World) -> Option<String> {
    let certificate = world.get_resource::<ConeSolution>()?.certificate.as_ref()?;
    let (bodies, program) =
        (world.get_resource::<BodyTable>()?, world.get_resource::<ConeProgram>()?);
    let most = moves_most(bodies, program, &certificate.mechanism);
    let most = most.map_or(String::new(), |(body, _)| format!(", in which {body} moves most"));
    Some(format!("no equilibrium exists: a mechanism proves it{most}"))
}
