//! `Save` stages: the state between two increments, kept for the system that writes it.

use bevy_ecs::prelude::*;

use clastic_systems::stepping::ClasticHalted;

use super::script::Script;
use crate::saved;
use crate::scene::format::Save;
use crate::tables::Tables;
use crate::text::shown::label;

/// States that `Save` stages have kept and nothing has written yet, with the names of their files.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct SavedStates(pub Vec<(String, Tables)>);

/// Why the state cannot be kept: a stage before collapsed, so that it is not the state that this
/// stage was to reach.
pub(super) fn refusal(world: &World) -> Option<String> {
    let collapse = world.resource::<Script>().collapse.as_ref()?;
    Some(format!(
        "the specimen collapsed in stage {}, so that its state is not the one to be kept; end that stage \
         before the collapse (`final_state.npz` has the state)",
        label(&collapse.stage)
    ))
}

/// Keeps the state. Exclusive, because it reads everything that plugins have registered.
pub fn save(world: &mut World, stage: &Save) {
    match saved::save(world) {
        Ok(tables) => {
            world.get_resource_or_init::<SavedStates>().0.push((stage.file(), tables));
        }
        Err(error) => {
            world.insert_resource(ClasticHalted(format!("stage `{}`: {error}", stage.name)));
        }
    }
}
