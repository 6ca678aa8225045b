//! Collisions.

use bevy_ecs::prelude::*;
use glam::DVec2;

/// Two bodies without a bond that carried no force carry one after this increment: a message, which
/// [`BodyHit`] says to observers. Collisions are looked for only in an app that asks for them with
/// `app.add_message::<Collision>()`.
#[derive(Message, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Collision {
    /// The increment.
    pub increment: u64,
    /// Entities of the bodies: a particle, and a particle or a wall.
    pub bodies: [Entity; 2],
    /// Unit normal from the first to the second at the start of the increment.
    pub normal: DVec2,
    /// Normal force, N.
    pub force: f64,
}

/// Event of a [`Collision`]: a body has hit another one. It is triggered on the entities of both.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct BodyHit {
    /// Entity of the body.
    #[event_target]
    pub body: Entity,
    /// Entity of the other body.
    pub other: Entity,
    /// The collision, with its bodies in the order of identities.
    pub collision: Collision,
}
