//! Identities of bodies and bonds. Each is assigned on insertion, belongs to one entity, and is
//! never used twice.

use std::collections::HashMap;

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
#[cfg(feature = "reflect")]
use bevy_ecs::reflect::ReflectResource;
use bevy_ecs::world::DeferredWorld;
use serde::{Deserialize, Serialize};

use crate::body::{BodyId, Origin, Position};
use crate::bond::{Bond, BondId, BondState, Joint};
use crate::contact_history::{ContactHistory, KeptRows};
use crate::particle::Particle;
use crate::wall::Wall;

/// The identities in use, and the next free ones.
///
/// Component hooks update this resource. It is created when the first body is inserted.
#[derive(Resource, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Identities {
    bodies: Register,
    bonds: Register,
}

#[derive(Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
struct Register {
    // This map is only looked up and never iterated, so that its order has no effect.
    owners: HashMap<u32, Entity>,
    next: u32,
}

impl Register {
    fn give(&mut self) -> u32 {
        self.next
    }

    /// Assigns an identity to an entity. The error is the entity that has the identity already.
    fn take(&mut self, id: u32, entity: Entity) -> Result<(), Entity> {
        match self.owners.get(&id) {
            Some(owner) if *owner != entity => Err(*owner),
            _ => {
                self.owners.insert(id, entity);
                self.next = self.next.max(id.saturating_add(1));
                Ok(())
            }
        }
    }

    fn leave(&mut self, id: u32, entity: Entity) {
        if self.owners.get(&id) == Some(&entity) {
            self.owners.remove(&id);
        }
    }
}

/// The next identities of bodies and bonds, as a checkpoint stores them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct NextIdentities {
    /// Next identity of a body.
    pub body: u32,
    /// Next identity of a bond. It equals the number of bonds ever made unless a caller set
    /// identities.
    pub bond: u32,
}

impl Identities {
    /// Entity of a body; `None` if the identity is not in use.
    #[must_use]
    pub fn body(&self, id: BodyId) -> Option<Entity> {
        self.bodies.owners.get(&id.0).copied()
    }

    /// Entity of a bond; `None` if the identity is not in use.
    #[must_use]
    pub fn bond(&self, id: BondId) -> Option<Entity> {
        self.bonds.owners.get(&id.0).copied()
    }

    /// The identities that the next body and the next bond get.
    #[must_use]
    pub fn next(&self) -> NextIdentities {
        NextIdentities { body: self.bodies.next, bond: self.bonds.next }
    }

    /// Skips all identities below these, which a resumed run has used before its checkpoint.
    pub fn skip_to(&mut self, next: NextIdentities) {
        self.bodies.next = self.bodies.next.max(next.body);
        self.bonds.next = self.bonds.next.max(next.bond);
    }
}

/// Why an identity, a body or a bond is refused. The error goes to Bevy's error handler, which
/// panics unless the app sets another one. The refused component or bond is removed from the world.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum IdentityError {
    /// Two bodies have one identity.
    #[error(
        "body {id} is entity {owner} already, and entity {newcomer} was given the same BodyId; leave \
         BodyId out and every body gets one of its own"
    )]
    Body {
        /// The identity.
        id: u32,
        /// The entity that has it.
        owner: Entity,
        /// The entity that was refused.
        newcomer: Entity,
    },
    /// Two bonds have one identity.
    #[error(
        "bond {id} is entity {owner} already, and entity {newcomer} was given the same BondId; leave \
         BondId out and every bond gets one of its own"
    )]
    Bond {
        /// The identity.
        id: u32,
        /// The entity that has it.
        owner: Entity,
        /// The entity that was refused.
        newcomer: Entity,
    },
    /// A bond joins entities that cannot be joined.
    #[error("Bond::between({a}, {b}) joins no two bodies: {what}")]
    Joint {
        /// First entity.
        a: Entity,
        /// Second entity.
        b: Entity,
        /// The mistake and its remedy.
        what: &'static str,
    },
}

/// Hook of [`Particle`] and [`Wall`]: adds an identity and an origin if they are missing.
pub(crate) fn body_added(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    world.commands().queue(move |world: &mut World| {
        let Ok(body) = world.get_entity(entity) else { return };
        let place = body.get::<Position>().map_or_else(Default::default, |x| x.0);
        let (has_id, has_origin) = (body.contains::<BodyId>(), body.contains::<Origin>());
        if !has_id {
            let id = BodyId(world.get_resource_or_init::<Identities>().bodies.give());
            world.entity_mut(entity).insert(id);
        }
        if !has_origin {
            world.entity_mut(entity).insert(Origin(place));
        }
    });
}

/// Hook of [`BodyId`]: registers the identity.
pub(crate) fn body_named(mut world: DeferredWorld, context: HookContext) {
    let newcomer = context.entity;
    world.commands().queue(move |world: &mut World| -> Result<(), IdentityError> {
        let Some(BodyId(id)) = world.get::<BodyId>(newcomer).copied() else { return Ok(()) };
        let taken = world.get_resource_or_init::<Identities>().bodies.take(id, newcomer);
        taken.map_err(|owner| {
            world.entity_mut(newcomer).remove::<(BodyId, Particle, Wall)>();
            IdentityError::Body { id, owner, newcomer }
        })
    });
}

/// Hook of [`BodyId`]: removes the intact bonds of the body and the memory of its contacts. Bonds
/// that broke before stay in the record.
pub(crate) fn body_gone(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    let Some(id) = world.get::<BodyId>(entity).copied() else { return };
    world.commands().queue(move |world: &mut World| {
        let mut identities = world.get_resource_or_init::<Identities>();
        if identities.body(id) != Some(entity) {
            return;
        }
        identities.bodies.leave(id.0, entity);
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
    });
}

/// Hook of [`Bond`]: adds an identity if it is missing.
pub(crate) fn bond_added(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    world.commands().queue(move |world: &mut World| {
        if world.get_entity(entity).is_ok_and(|bond| !bond.contains::<BondId>()) {
            let id = BondId(world.get_resource_or_init::<Identities>().bonds.give());
            world.entity_mut(entity).insert(id);
        }
    });
}

/// Hook of [`BondId`]: registers the identity.
pub(crate) fn bond_named(mut world: DeferredWorld, context: HookContext) {
    let newcomer = context.entity;
    world.commands().queue(move |world: &mut World| -> Result<(), IdentityError> {
        let Some(BondId(id)) = world.get::<BondId>(newcomer).copied() else { return Ok(()) };
        let taken = world.get_resource_or_init::<Identities>().bonds.take(id, newcomer);
        taken.map_err(|owner| {
            world.entity_mut(newcomer).remove::<(BondId, Bond)>();
            IdentityError::Bond { id, owner, newcomer }
        })
    });
}

/// Hook of [`BondId`]: releases the identity.
pub(crate) fn bond_gone(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    let Some(BondId(id)) = world.get::<BondId>(entity).copied() else { return };
    world.commands().queue(move |world: &mut World| {
        world.get_resource_or_init::<Identities>().bonds.leave(id, entity);
    });
}

/// Hook of [`Joint`]: replaces it by a [`Bond`] that is free of stress at the positions of its
/// bodies.
pub(crate) fn joined(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    world.commands().queue(move |world: &mut World| -> Result<(), IdentityError> {
        let Some(joint) = world.entity_mut(entity).take::<Joint>() else { return Ok(()) };
        let bond = joint.resolve(world)?;
        world.entity_mut(entity).insert(bond);
        Ok(())
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_ecs::error::{BevyError, ErrorContext, FallbackErrorHandler};
    use glam::DVec2;
    use std::sync::Mutex;

    use crate::material::BondLaw;

    fn disk(x: f64) -> (Particle, Position) {
        (Particle::disk(1.0, 2650.0, 1.0), Position(DVec2::new(x, 0.0)))
    }

    #[test]
    fn identities_follow_the_order_of_insertion_and_are_not_used_again() {
        let mut world = World::new();
        let [a, b] = [0.0, 2.0].map(|x| world.spawn(disk(x)).id());
        assert_eq!(world.get::<BodyId>(a), Some(&BodyId(0)));
        assert_eq!(world.get::<Origin>(b), Some(&Origin(DVec2::new(2.0, 0.0))));
        world.despawn(b);
        let c = world.spawn(disk(4.0)).id();
        assert_eq!(world.get::<BodyId>(c), Some(&BodyId(2)));
        let d = world.spawn((disk(6.0), BodyId(9))).id();
        let e = world.spawn(disk(8.0)).id();
        assert_eq!(world.get::<BodyId>(e), Some(&BodyId(10)));
        assert_eq!(world.resource::<Identities>().body(BodyId(9)), Some(d));
        assert_eq!(world.resource::<Identities>().body(BodyId(1)), None);
    }

    #[test]
    fn a_batch_of_commands_holds_two_disks_and_their_bond() {
        let mut world = World::new();
        let mut commands = world.commands();
        let [a, b] = [2.5, 0.0].map(|x| commands.spawn(disk(x)).id());
        let bond = commands.spawn(Bond::between(b, a, BondLaw::default())).id();
        world.flush();
        let found = world.get::<Bond>(bond).copied().unwrap_or_else(|| panic!("no bond"));
        assert_eq!((found.a, found.b), (BodyId(0), BodyId(1)));
        assert!((found.initial_gap - 0.5).abs() < 1e-15);
        assert_eq!(world.get::<BondId>(bond), Some(&BondId(0)));
        assert!(world.get::<Joint>(bond).is_none());
        // Removing the body removes the bond.
        world.despawn(a);
        assert!(world.get_entity(bond).is_err());
    }

    #[test]
    fn a_second_body_of_one_identity_is_refused() {
        let mut world = World::new();
        static SAID: Mutex<String> = Mutex::new(String::new());
        fn hear(error: BevyError, _: ErrorContext) {
            SAID.lock().unwrap_or_else(|e| panic!("{e}")).push_str(&error.to_string());
        }
        world.insert_resource(FallbackErrorHandler(hear));
        let first = world.spawn((disk(0.0), BodyId(3))).id();
        let second = world.spawn((disk(2.0), BodyId(3))).id();
        assert_eq!(world.resource::<Identities>().body(BodyId(3)), Some(first));
        assert!(world.get::<Particle>(second).is_none());
        let said = SAID.lock().unwrap_or_else(|e| panic!("{e}")).clone();
        assert!(said.contains("body 3") && said.contains("BodyId"), "{said}");
    }
}
