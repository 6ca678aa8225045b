//! The identities of bodies and bonds that are in use. [`crate::assign_identities`] assigns them.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::body::BodyId;
use clastic_components::bond::BondId;

/// Name of [`NextIdentities`] in a state.
pub const NEXT_IDENTITIES: &str = "identities.next";

/// The identities in use, and the next free ones.
///
/// Component hooks update this resource.
#[derive(Resource, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct IdentityTable {
    pub(crate) bodies: Register,
    pub(crate) bonds: Register,
}

/// The identities of one kind.
#[derive(Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub(crate) struct Register {
    // This map is only looked up and never iterated, so that its order has no effect.
    owners: HashMap<u32, Entity>,
    /// The next free identity. It stays free until [`take`](Self::take).
    pub(crate) next: u32,
}

impl Register {
    /// Assigns an identity to an entity.
    ///
    /// # Errors
    /// The entity that has the identity already.
    pub(crate) fn take(&mut self, id: u32, entity: Entity) -> Result<(), Entity> {
        match self.owners.get(&id) {
            Some(owner) if *owner != entity => Err(*owner),
            _ => {
                self.owners.insert(id, entity);
                self.next = self.next.max(id.saturating_add(1));
                Ok(())
            }
        }
    }

    /// Ends the use of an identity by an entity.
    pub(crate) fn release(&mut self, id: u32, entity: Entity) {
        if self.owners.get(&id) == Some(&entity) {
            self.owners.remove(&id);
        }
    }
}

/// The next identities of bodies and bonds, as a checkpoint stores them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NextIdentities {
    /// Next identity of a body.
    pub body: u32,
    /// Next identity of a bond. It equals the number of bonds ever made unless a caller set
    /// identities.
    pub bond: u32,
}

impl IdentityTable {
    /// Entity of a body; `None` if the identity is not in use.
    pub fn body(&self, id: BodyId) -> Option<Entity> {
        self.bodies.owners.get(&id.0).copied()
    }

    /// Entity of a bond; `None` if the identity is not in use.
    pub fn bond(&self, id: BondId) -> Option<Entity> {
        self.bonds.owners.get(&id.0).copied()
    }

    /// The identities that the next body and the next bond get.
    pub fn next(&self) -> NextIdentities {
        NextIdentities { body: self.bodies.next, bond: self.bonds.next }
    }

    /// Skips all identities below these, which a resumed run has used before its checkpoint.
    pub fn skip_to(&mut self, next: NextIdentities) {
        self.bodies.next = self.bodies.next.max(next.body);
        self.bonds.next = self.bonds.next.max(next.bond);
    }
}

/// Removes the bodies and bonds whose identities these, or later ones, are: they have come since
/// these were the next.
pub(crate) fn go_back(world: &mut World, next: NextIdentities) {
    let identities = world.get_resource_or_init::<IdentityTable>();
    let since = |register: &Register, next: u32| -> Vec<Entity> {
        (next..register.next).filter_map(|id| register.owners.get(&id).copied()).collect()
    };
    // Bonds end with their bodies.
    let mut late = since(&identities.bonds, next.bond);
    late.extend(since(&identities.bodies, next.body));
    for entity in late {
        world.despawn(entity);
    }
    world.flush();
    let mut identities = world.resource_mut::<IdentityTable>();
    identities.bodies.next = next.body;
    identities.bonds.next = next.bond;
}
