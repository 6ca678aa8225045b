//! Components that a body needs and that a program has removed. Without one of them the body would
//! silently leave the tables.

use bevy_ecs::archetype::Archetypes;
use bevy_ecs::component::{ComponentId, Components};
use bevy_ecs::prelude::*;

use clastic_components::body::{
    AppliedLoad, BodyAngularVelocity, BodyDrives, BodyPosition, BodyRotation, BodyVelocity,
    ExternalForce, LastMotion, LoadControl,
};
use clastic_components::bond::{Bond, BondState};
use clastic_components::material::ContactLaw;
use clastic_components::particle::{MaterialIndex, Particle};
use clastic_components::rigid_group::{ContactForce, RigidGroup};
use clastic_components::wall::{Wall, WallControl, WallDrive};

use super::bad::Bad;

/// The first entity without a component of its kind. The kinds of entities are archetypes, so that
/// no entity is visited.
pub(super) fn missing(archetypes: &Archetypes, components: &Components) -> Option<(Entity, Bad)> {
    kinds(components).into_iter().find_map(|(kind, needed)| {
        let kind = kind?;
        let mut of_kind = archetypes.iter().filter(|all| all.contains(kind) && !all.is_empty());
        of_kind.find_map(|archetype| {
            let lacks = |id: &Option<ComponentId>| id.is_none_or(|id| !archetype.contains(id));
            let (name, _) = needed.iter().find(|(_, id)| lacks(id))?;
            let wanted = "one, which its kind of entity needs";
            Some((archetype.entities().first()?.id(), Bad::new(name, "missing", wanted)))
        })
    })
}

type Needed = (&'static str, Option<ComponentId>);

/// The kinds of entities and what they need.
fn kinds(components: &Components) -> [(Option<ComponentId>, Vec<Needed>); 4] {
    macro_rules! needed {
        ($($component:ty),+) => {
            vec![$((stringify!($component), components.component_id::<$component>())),+]
        };
    }
    [
        (
            components.component_id::<Particle>(),
            needed![
                BodyPosition,
                BodyRotation,
                BodyVelocity,
                BodyAngularVelocity,
                LastMotion,
                BodyDrives,
                LoadControl,
                AppliedLoad,
                ExternalForce,
                MaterialIndex
            ],
        ),
        (
            components.component_id::<Wall>(),
            needed![BodyPosition, LastMotion, ExternalForce, ContactLaw, WallDrive, WallControl],
        ),
        (
            components.component_id::<RigidGroup>(),
            needed![
                BodyPosition,
                BodyRotation,
                LastMotion,
                BodyDrives,
                LoadControl,
                AppliedLoad,
                ExternalForce,
                ContactForce
            ],
        ),
        (components.component_id::<Bond>(), needed![BondState]),
    ]
}
