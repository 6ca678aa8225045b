//! Assigns identities to bodies and bonds on insertion, and turns `Bond::between(a, b, law)` into a
//! bond. An identity belongs to one entity and is never used twice.

mod joint;
#[cfg(test)]
mod tests;

use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::{ComponentHooks, HookContext};
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use clastic_components::prelude::*;

use crate::identities::{IdentityTable, NEXT_IDENTITIES};
use crate::state::{RegisterState, despawn_if};

/// Adds the component hooks that assign identities.
///
/// # Panics
/// If the world has had bodies or bonds before: they have no identities.
pub struct AssignIdentitiesPlugin;

impl Plugin for AssignIdentitiesPlugin {
    fn build(&self, app: &mut App) {
        let world = app.world_mut();
        hooks::<Particle>(world).on_add(body_added);
        hooks::<Wall>(world).on_add(body_added);
        hooks::<RigidGroup>(world).on_add(body_added);
        hooks::<BodyId>(world).on_insert(body_named).on_discard(body_gone);
        hooks::<Bond>(world).on_add(bond_added);
        hooks::<BondId>(world).on_insert(bond_named).on_discard(bond_gone);
        hooks::<Joint>(world).on_add(joined);
        world.init_resource::<IdentityTable>();
        // Identities are the first state, because the entities are created from them.
        app.register_part(
            NEXT_IDENTITIES,
            |world| world.get_resource::<IdentityTable>().map(IdentityTable::next),
            |next, world| world.get_resource_or_init::<IdentityTable>().skip_to(next),
        );
    }
}

/// The hooks of a component; panics if an entity has had it.
fn hooks<C: Component>(world: &mut World) -> &mut ComponentHooks {
    let id = world.register_component::<C>();
    assert!(
        !world.archetypes().iter().any(|archetype| archetype.contains(id)),
        "the world had bodies or bonds before the plugin that assigns their identities; add \
         ClasticPlugins before the first of them"
    );
    world.register_component_hooks::<C>()
}

/// Why a body or a bond is refused.
///
/// The error goes to Bevy's error handler, which panics unless the app sets another one. The
/// refused entity loses its identity and its body or bond.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum IdentityError {
    /// Two bodies, or two bonds, have one identity.
    #[error(
        "entity {newcomer} was given {component}({id}), but {kind} {id} is entity {owner}; leave \
         {component} out, and the {kind} gets the next free one"
    )]
    Taken {
        /// Component of the identity.
        component: &'static str,
        /// What it names.
        kind: &'static str,
        /// The identity.
        id: u32,
        /// The entity that has it.
        owner: Entity,
        /// The entity that was refused.
        newcomer: Entity,
    },
    /// An entity has two of `Particle`, `Wall` and `RigidGroup`.
    #[error("entity {0} is two of Particle, Wall and RigidGroup; spawn one entity for each body")]
    TwoBodies(Entity),
    /// The two entities cannot be joined.
    #[error("Bond::between({a}, {b}): {what}")]
    Joint {
        /// First entity.
        a: Entity,
        /// Second entity.
        b: Entity,
        /// What is wrong and what would be right.
        what: &'static str,
    },
}

/// Hook of bodies: adds an identity and an origin if they are missing.
fn body_added(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    world.commands().queue(move |world: &mut World| -> Result<(), IdentityError> {
        let Ok(body) = world.get_entity(entity) else { return Ok(()) };
        let kinds =
            [body.contains::<Particle>(), body.contains::<Wall>(), body.contains::<RigidGroup>()];
        match kinds.iter().filter(|is| **is).count() {
            // The hook of its other kind has refused it.
            0 => return Ok(()),
            1 => {}
            _ => {
                world.entity_mut(entity).remove::<(BodyId, Particle, Wall, RigidGroup)>();
                return Err(IdentityError::TwoBodies(entity));
            }
        }
        let place = body.get::<BodyPosition>().map_or_else(Default::default, |x| x.0);
        let id = BodyId(world.get_resource_or_init::<IdentityTable>().bodies.next);
        world.entity_mut(entity).insert_if_new(id).insert_if_new(BodyOrigin(place));
        Ok(())
    });
}

/// Hook of [`BodyId`]: registers the identity.
fn body_named(mut world: DeferredWorld, context: HookContext) {
    let newcomer = context.entity;
    world.commands().queue(move |world: &mut World| -> Result<(), IdentityError> {
        let Some(BodyId(id)) = world.get::<BodyId>(newcomer).copied() else { return Ok(()) };
        let taken = world.get_resource_or_init::<IdentityTable>().bodies.take(id, newcomer);
        taken.map_err(|owner| {
            world.entity_mut(newcomer).remove::<(BodyId, Particle, Wall, RigidGroup)>();
            IdentityError::Taken { component: "BodyId", kind: "body", id, owner, newcomer }
        })
    });
}

/// Hook of [`BodyId`]: removes the intact bonds and the links of the body, and the memory of its
/// contacts. Bonds that broke before stay in the record.
fn body_gone(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    let Some(id) = world.get::<BodyId>(entity).copied() else { return };
    world.commands().queue(move |world: &mut World| {
        let mut identities = world.get_resource_or_init::<IdentityTable>();
        if identities.body(id) != Some(entity) {
            return;
        }
        identities.bodies.release(id.0, entity);
        let kept = world.get_resource::<KeptRows>();
        let row = kept.and_then(|kept| kept.ids.iter().position(|kept| *kept == id));
        if let (Some(row), Some(mut history)) = (row, world.get_resource_mut::<ContactHistory>()) {
            let row = row as u32;
            history.0.retain(|memory| memory.a != row && memory.b != row);
        }
        let mut bonds = world.query::<(Entity, &Bond, &BondState)>();
        let joins = |(_, bond, state): &(Entity, &Bond, &BondState)| {
            **state == BondState::Intact && (bond.a == id || bond.b == id)
        };
        let ended: Vec<_> = bonds.iter(world).filter(joins).map(|(bond, ..)| bond).collect();
        for bond in ended {
            world.despawn(bond);
        }
        despawn_if(world, |link: &Link| link.a == id || link.b == id);
    });
}

/// Hook of [`Bond`]: adds an identity if it is missing.
fn bond_added(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    world.commands().queue(move |world: &mut World| {
        if world.get_entity(entity).is_ok_and(|bond| !bond.contains::<BondId>()) {
            let id = BondId(world.get_resource_or_init::<IdentityTable>().bonds.next);
            world.entity_mut(entity).insert(id);
        }
    });
}

/// Hook of [`BondId`]: registers the identity.
fn bond_named(mut world: DeferredWorld, context: HookContext) {
    let newcomer = context.entity;
    world.commands().queue(move |world: &mut World| -> Result<(), IdentityError> {
        let Some(BondId(id)) = world.get::<BondId>(newcomer).copied() else { return Ok(()) };
        let taken = world.get_resource_or_init::<IdentityTable>().bonds.take(id, newcomer);
        taken.map_err(|owner| {
            world.entity_mut(newcomer).remove::<(BondId, Bond)>();
            IdentityError::Taken { component: "BondId", kind: "bond", id, owner, newcomer }
        })
    });
}

/// Hook of [`BondId`]: releases the identity.
fn bond_gone(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    let Some(BondId(id)) = world.get::<BondId>(entity).copied() else { return };
    world.commands().queue(move |world: &mut World| {
        world.get_resource_or_init::<IdentityTable>().bonds.release(id, entity);
    });
}

/// Hook of [`Joint`]: replaces it by a [`Bond`] that is free of stress at the positions of its
/// bodies.
fn joined(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    world.commands().queue(move |world: &mut World| -> Result<(), IdentityError> {
        let Some(joint) = world.entity_mut(entity).take::<Joint>() else { return Ok(()) };
        let bond = joint::resolve(joint, world)?;
        world.entity_mut(entity).insert(bond);
        Ok(())
    });
}
