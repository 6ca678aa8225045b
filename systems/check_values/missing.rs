//! Components that a body needs and that a program has removed, and components that have no effect on
//! it. Without the former it would silently leave the tables; the latter would silently be ignored.

use bevy_ecs::archetype::Archetypes;
use bevy_ecs::component::{ComponentId, Components};
use bevy_ecs::prelude::*;

use clastic_components::body::{
    AppliedLoad, BodyAngularVelocity, BodyDrives, BodyExternalForce, BodyPosition, BodyRotation,
    BodyVelocity, LastMotion, LoadControl,
};
use clastic_components::bond::{Bond, BondState};
use clastic_components::material::ContactLaw;
use clastic_components::particle::{MaterialIndex, Particle};
use clastic_components::rigid_group::{ContactForce, RigidGroup};
use clastic_components::wall::{Wall, WallControl, WallDrive, WallSlide, WallTable};

use super::bad::Bad;

/// The first entity without a component of its kind, or with one of another kind. The kinds of
/// entities are archetypes, so that no entity is visited.
pub(super) fn misfit(archetypes: &Archetypes, components: &Components) -> Option<(Entity, Bad)> {
    kinds(components).into_iter().find_map(|Kind { id, needed, idle }| {
        let id = id?;
        let mut of_kind = archetypes.iter().filter(|all| all.contains(id) && !all.is_empty());
        of_kind.find_map(|archetype| {
            let has = |id: &Option<ComponentId>| id.is_some_and(|id| archetype.contains(id));
            let missing = || {
                let (name, _) = needed.iter().find(|(_, id)| !has(id))?;
                Some(Bad::new(name, "missing", "one, which its kind of entity needs"))
            };
            let ignored = || {
                let (name, _) = idle.iter().find(|(_, id)| has(id))?;
                Some(Bad::new(name, "a component", "none: it has no effect on this kind of entity"))
            };
            Some((archetype.entities().first()?.id(), missing().or_else(ignored)?))
        })
    })
}

type Named = (&'static str, Option<ComponentId>);

/// A kind of entity, which a component marks.
struct Kind {
    id: Option<ComponentId>,
    needed: Vec<Named>,
    /// Components of other kinds.
    idle: Vec<Named>,
}

fn kinds(components: &Components) -> [Kind; 4] {
    macro_rules! named {
        ($($component:ty),*) => {
            vec![$((stringify!($component), components.component_id::<$component>())),*]
        };
    }
    [
        Kind {
            id: components.component_id::<Particle>(),
            needed: named![
                BodyPosition,
                BodyRotation,
                BodyVelocity,
                BodyAngularVelocity,
                LastMotion,
                BodyDrives,
                LoadControl,
                AppliedLoad,
                BodyExternalForce,
                MaterialIndex
            ],
            idle: named![ContactLaw, WallControl, WallDrive, WallSlide, WallTable],
        },
        Kind {
            id: components.component_id::<Wall>(),
            needed: named![
                BodyPosition,
                LastMotion,
                BodyExternalForce,
                ContactLaw,
                WallDrive,
                WallControl
            ],
            idle: named![
                BodyRotation,
                BodyVelocity,
                BodyAngularVelocity,
                BodyDrives,
                LoadControl,
                MaterialIndex
            ],
        },
        Kind {
            id: components.component_id::<RigidGroup>(),
            needed: named![
                BodyPosition,
                BodyRotation,
                LastMotion,
                BodyDrives,
                LoadControl,
                AppliedLoad,
                BodyExternalForce,
                ContactForce
            ],
            idle: named![BodyVelocity, BodyAngularVelocity, ContactLaw, MaterialIndex],
        },
        Kind { id: components.component_id::<Bond>(), needed: named![BondState], idle: named![] },
    ]
}
