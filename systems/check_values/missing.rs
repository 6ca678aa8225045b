//! Components that a body needs and a program has removed, and components that have no effect on
//! it. Without a message the body would leave the tables, or the component would be ignored.

use bevy_ecs::archetype::Archetypes;
use bevy_ecs::component::Components;
use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use super::bad::Bad;

/// The first entity without a component that its kind [requires](Component), or with one of another
/// kind. The kinds of entities are archetypes, so that no entity is visited.
pub(super) fn misfit(archetypes: &Archetypes, components: &Components) -> Option<(Entity, Bad)> {
    macro_rules! named {
        ($($component:ty),*) => {
            [$((stringify!($component), components.component_id::<$component>())),*]
        };
    }
    let parts = named![
        BodyPosition,
        BodyRotation,
        BodyVelocity,
        BodyAngularVelocity,
        LastMotion,
        BodyDrives,
        LoadControl,
        AppliedLoad,
        BodyExternalForce,
        MaterialIndex,
        ContactLaw,
        WallDrive,
        WallControl,
        WallSlide,
        WallTable,
        ContactForce,
        BondState
    ];
    let kinds = named![Particle, Wall, RigidGroup, Bond];
    // Components that an entity of a kind may have but does not need.
    let choices = named![ContactForce];
    let choices_of_walls = named![WallSlide, WallTable];
    kinds.into_iter().find_map(|(kind_name, kind)| {
        let kind = kind?;
        let needed: Vec<_> = components.get_info(kind)?.required_components().iter_ids().collect();
        let mut of_kind = archetypes.iter().filter(|all| all.contains(kind) && !all.is_empty());
        of_kind.find_map(|archetype| {
            let misfit = parts.iter().find_map(|part @ (name, id)| {
                let id = (*id)?;
                let is_choice = kind_name != "Bond" && choices.contains(part)
                    || kind_name == "Wall" && choices_of_walls.contains(part);
                match (needed.contains(&id), archetype.contains(id)) {
                    (true, false) => {
                        let wanted = "one, which its kind of entity needs";
                        Some(Bad::new(name, "missing", wanted))
                    }
                    (false, true) if !is_choice => {
                        let wanted = "none: it has no effect on this kind of entity";
                        Some(Bad::new(name, "a component", wanted))
                    }
                    _ => None,
                }
            })?;
            Some((archetype.entities().first()?.id(), misfit))
        })
    })
}
