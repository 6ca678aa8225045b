//! Controls of walls as stored in a state, which names other walls by identity instead of entity.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::body::BodyId;
use clastic_components::wall::WallControl;

use crate::identities::IdentityTable;
use crate::state::StateOf;

/// Name of [`ControlStates`] in a state.
pub const WALL_CONTROL: &str = "wall_control";

/// The controls of all walls by identity, each with the two walls on whose distance its stress acts.
/// `None` means that it acts on none, or that the wall was removed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlStates(pub Vec<(BodyId, WallControl, [Option<BodyId>; 2])>);

impl StateOf for ControlStates {
    fn take(world: &mut World) -> Option<Self> {
        let mut query = world.query::<(&BodyId, &WallControl)>();
        let state = |(id, control): (&BodyId, &WallControl)| {
            let mut control = *control;
            let walls = control.loaded_between();
            let ids = walls.map(|walls| walls.map(|wall| world.get::<BodyId>(*wall).copied()));
            (*id, control, ids.unwrap_or_default())
        };
        let mut walls: Vec<_> = query.iter(world).map(state).collect();
        walls.sort_unstable_by_key(|(id, ..)| *id);
        Some(Self(walls))
    }

    fn put(self, world: &mut World) {
        for (id, mut control, between) in self.0 {
            let identities = world.get_resource_or_init::<IdentityTable>();
            let Some(entity) = identities.body(id) else { continue };
            for (wall, id) in control.loaded_between().into_iter().flatten().zip(between) {
                *wall = id.and_then(|id| identities.body(id)).unwrap_or(Entity::PLACEHOLDER);
            }
            world.entity_mut(entity).insert(control);
        }
    }
}
