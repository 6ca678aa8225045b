//! Bonds.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::BodyId;
use crate::material::BondLaw;

/// Identity of a bond. A bond that is inserted without an identity gets the next one. No identity
/// is used twice.
#[derive(
    Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable, clone_behavior = Ignore)]
pub struct BondId(pub u32);

/// A bond between two bodies. The bodies are plain fields and not Bevy relationships, because
/// adding or removing relationships reorders archetypes.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[require(BondState)]
pub struct Bond {
    /// First body, always a particle.
    pub a: BodyId,
    /// Second body, a particle or a wall.
    pub b: BodyId,
    /// Gap without normal force, `g_b0`, m: the gap at creation, plus `C_N p` of a contact there.
    pub initial_gap: f64,
    /// Law of the bond.
    pub law: BondLaw,
}

impl Bond {
    /// A bond between two particles, or between a particle and a wall, that is free of stress at
    /// their current positions. Inserting it turns it into a `Bond`. The two bodies must be
    /// inserted before, in the same batch of commands or earlier.
    ///
    /// An entity that is no body, an entity with itself, and two walls are refused by Bevy's error
    /// handler, which panics unless the app sets another one.
    pub fn between(a: Entity, b: Entity, law: BondLaw) -> Joint {
        Joint { a, b, law }
    }
}

/// A bond that names entities; see [`Bond::between`]. It is replaced by a [`Bond`] on insertion.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct Joint {
    /// First body.
    pub a: Entity,
    /// Second body.
    pub b: Entity,
    /// Law of the bond.
    pub law: BondLaw,
}

/// Whether a bond still holds.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub enum BondState {
    /// Carries tension, shear and moment up to its strength.
    #[default]
    Intact,
    /// Broken for good.
    Broken(RuptureMode),
}

/// The limit at which a bond broke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[serde(rename_all = "lowercase")]
pub enum RuptureMode {
    /// `p = -f_t`.
    Tension,
    /// `|q| = c A + mu_b p`.
    Shear,
    /// `|tau| = mu_r r (p + f_t)`.
    Rolling,
}

impl RuptureMode {
    /// The word that the event file uses.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tension => "tension",
            Self::Shear => "shear",
            Self::Rolling => "rolling",
        }
    }
}

/// Event on the entity of a bond: it has broken. An increment that is undone triggers none. Systems
/// read the message [`Rupture`] instead.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct BondBroken {
    /// Entity of the bond.
    #[event_target]
    pub bond: Entity,
    /// Entities of its bodies, a and b.
    pub bodies: [Entity; 2],
    /// The limit, the place, and the forces that the bond carried.
    pub rupture: Rupture,
}

/// One rupture: the bond, the limit, the place, and the forces that the bond carried.
#[derive(Message, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Rupture {
    /// Increment of the rupture.
    pub increment: u64,
    /// The bond.
    pub bond: BondId,
    /// First body of the bond.
    pub a: BodyId,
    /// Second body of the bond.
    pub b: BodyId,
    /// The limit that the bond reached.
    pub mode: RuptureMode,
    /// Contact point at the start of the increment, m.
    pub position: DVec2,
    /// Unit normal from a to b at the start of the increment.
    pub normal: DVec2,
    /// Normal force, compression positive, N.
    pub p: f64,
    /// Shear force on b, N, positive along the normal turned by +90 degrees.
    pub q: f64,
    /// Rolling moment on b, N m, anticlockwise positive.
    pub tau: f64,
}
