//! Names of the materials in a state: particles have an index in [`Materials`].

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::material::Materials;

use crate::state::{RegisterState, StateOf};

/// Adds [`MaterialNames`] to states.
pub struct MaterialNamesPlugin;

impl Plugin for MaterialNamesPlugin {
    fn build(&self, app: &mut App) {
        app.register_state::<MaterialNames>(MATERIALS);
    }
}

/// Name of [`MaterialNames`] in a state.
pub const MATERIALS: &str = "materials.names";

/// Names of the materials, by the index that particles have. The materials are settings; a world
/// with other names is refused, because its particles would get other materials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaterialNames(pub Vec<String>);

impl StateOf for MaterialNames {
    fn take(world: &mut World) -> Option<Self> {
        world.get_resource::<Materials>().map(Self::of)
    }

    fn check(&self, world: &World) -> Result<(), String> {
        let there = world.get_resource::<Materials>().map_or_else(|| Self(Vec::new()), Self::of);
        if *self == there {
            return Ok(());
        }
        Err(format!(
            "it has {}, and the world {}; insert the Materials of the state before it is restored",
            self.shown(),
            there.shown()
        ))
    }

    fn put(self, _: &mut World) {}
}

impl MaterialNames {
    fn of(materials: &Materials) -> Self {
        Self(materials.0.iter().map(|material| material.name.clone()).collect())
    }

    fn shown(&self) -> String {
        if self.0.is_empty() {
            return "no materials".to_owned();
        }
        let names: Vec<_> = self.0.iter().map(|name| format!("`{name}`")).collect();
        format!("the materials {}", names.join(", "))
    }
}
