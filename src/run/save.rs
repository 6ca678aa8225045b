//! `Save` stages: the state between two increments, kept for the system that writes it.

use bevy_ecs::prelude::*;

use clastic_systems::stepping::Halted;

use crate::saved;
use crate::scene::format::Save;
use crate::tables::Tables;

/// States that `Save` stages have kept and nothing has written yet, with the names of their files.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct SavedStates(pub Vec<(String, Tables)>);

/// Keeps the state. Exclusive, because it reads everything that plugins have registered.
pub fn save(world: &mut World, stage: &Save) {
    match saved::save(world) {
        Ok(tables) => {
            world.get_resource_or_init::<SavedStates>().0.push((stage.file(), tables));
        }
        Err(error) => {
            world.insert_resource(Halted(format!("stage `{}`: {error}", stage.name)));
        }
    }
}
