//! Bonds.

use bevy_ecs::prelude::*;
#[cfg(feature = "reflect")]
use bevy_ecs::reflect::ReflectComponent;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::{BodyId, Position};
use crate::identity::{IdentityError, bond_added, bond_gone, bond_named, joined};
use crate::material::BondLaw;
use crate::particle::Particle;
use crate::wall::Wall;
use crate::wall_shape::WallShape;

/// Identity of a bond. A bond that is inserted without an identity gets the next one. No identity
/// is used twice.
#[derive(
    Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable, on_insert = bond_named, on_discard = bond_gone)]
pub struct BondId(pub u32);

/// A bond between two bodies. The bodies are plain fields and not Bevy relationships, because
/// adding or removing relationships reorders archetypes.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(on_add = bond_added)]
#[require(BondState)]
pub struct Bond {
    /// First body, always a particle.
    pub a: BodyId,
    /// Second body, a particle or a wall.
    pub b: BodyId,
    /// Gap at creation, `g_b0`, m. The bond is free of stress at this gap.
    pub initial_gap: f64,
    /// Law of the bond.
    pub law: BondLaw,
}

impl Bond {
    /// A bond between two particles, or between a particle and a wall, that is free of stress at
    /// their current positions. Inserting it turns it into a `Bond`. The two bodies must be
    /// inserted before, in the same batch of commands or earlier.
    #[must_use]
    pub fn between(a: Entity, b: Entity, law: BondLaw) -> Joint {
        Joint { a, b, law }
    }
}

/// A bond that names entities; see [`Bond::between`]. It is replaced by a [`Bond`] on insertion.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(on_add = joined)]
pub struct Joint {
    a: Entity,
    b: Entity,
    law: BondLaw,
}

impl Joint {
    /// The bond between the bodies as they lie in `world`.
    pub(crate) fn resolve(self, world: &World) -> Result<Bond, IdentityError> {
        let Self { a, b, law } = self;
        let refuse = |what| IdentityError::Joint { a, b, what };
        let body = |entity| {
            let id = world.get::<BodyId>(entity).copied();
            id.ok_or(refuse("an entity is no body; insert its Particle or Wall first"))
        };
        let (id_a, id_b) = (body(a)?, body(b)?);
        let disk = |entity| {
            let place = world.get::<Position>(entity).map(|x| x.0).unwrap_or_default();
            world.get::<Particle>(entity).map(|disk| (place, disk.radius))
        };
        if a == b {
            return Err(refuse("they are one entity; join two"));
        }
        let (first, second, initial_gap) = match (disk(a), disk(b)) {
            (Some((x, r)), Some((y, s))) => (id_a.min(id_b), id_a.max(id_b), x.distance(y) - r - s),
            (Some((x, r)), None) => (id_a, id_b, height(world, b, x) - r),
            (None, Some((x, r))) => (id_b, id_a, height(world, a, x) - r),
            (None, None) => return Err(refuse("two walls do not bond; one must be a Particle")),
        };
        Ok(Bond { a: first, b: second, initial_gap, law })
    }
}

/// Distance of a point from a wall, m; negative on the outer side of a line.
fn height(world: &World, wall: Entity, point: DVec2) -> f64 {
    let middle = world.get::<Position>(wall).map(|x| x.0).unwrap_or_default();
    let shape = world.get::<WallShape>(wall).copied().unwrap_or_default();
    world
        .get::<Wall>(wall)
        .map_or(0.0, |wall| shape.nearest(wall.inward(), wall.half_length, point - middle).distance)
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
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tension => "tension",
            Self::Shear => "shear",
            Self::Rolling => "rolling",
        }
    }
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
    /// Shear force, N.
    pub q: f64,
    /// Rolling moment, N m.
    pub tau: f64,
}
