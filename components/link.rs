//! Links between two bodies: hinges, rods and springs.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::BodyId;

/// What a link holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum LinkKind {
    /// The two points stay in one place; the bodies turn about it. A hinge at a held body is a pin.
    Hinge,
    /// The distance of the two points, m: without force it is this one.
    Length(f64),
}

/// A link between a point of one body and a point of another. It acts in tension and in pressure,
/// never breaks, and is measured where an increment begins, so that errors do not add up.
///
/// With d the vector from the first point to the second and C the compliance, the bodies pull each
/// other with the force
///
/// ```text
/// d / C                  hinge
/// (|d| - length) / C     length, along d                                      N
/// ```
///
/// and with C = 0 the numerator is zero at the end of every increment. Two linked bodies have no
/// contact with each other, and can have no bond.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct Link {
    /// First body, a particle or a wall.
    pub a: BodyId,
    /// Second body, a particle or a wall.
    pub b: BodyId,
    /// Point of the first body relative to its position where its rotation is 0, m.
    pub on_a: DVec2,
    /// Point of the second body relative to its position where its rotation is 0, m.
    pub on_b: DVec2,
    /// What it holds.
    pub kind: LinkKind,
    /// Compliance, m/N; 0 is rigid.
    pub compliance: f64,
}

impl Link {
    /// A rigid hinge of two bodies at `point`, m, where they are now. Inserting it turns it into a
    /// `Link`. The bodies must be inserted before, in the same batch of commands or earlier.
    ///
    /// An entity that is no particle and no wall, and an entity with itself, are refused by Bevy's
    /// error handler, which panics unless the app sets another one.
    pub fn hinge(a: Entity, b: Entity, point: DVec2) -> LinkBetween {
        LinkBetween { bodies: [a, b], points: [point; 2], is_hinge: true, compliance: 0.0 }
    }

    /// A rod between a point of each body, m, which are apart: their distance stays. Inserted like a
    /// [`hinge`](Self::hinge).
    pub fn rod(bodies: [Entity; 2], points: [DVec2; 2]) -> LinkBetween {
        LinkBetween { bodies, points, is_hinge: false, compliance: 0.0 }
    }

    /// A spring of this stiffness, N/m, between a point of each body, m; it carries no force where
    /// they are now. Inserted like a [`hinge`](Self::hinge).
    pub fn spring(bodies: [Entity; 2], points: [DVec2; 2], stiffness: f64) -> LinkBetween {
        LinkBetween { compliance: 1.0 / stiffness, ..Self::rod(bodies, points) }
    }
}

/// A link that names entities and places; see [`Link::hinge`]. It is replaced by a [`Link`] on
/// insertion.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct LinkBetween {
    /// The bodies.
    pub bodies: [Entity; 2],
    /// The points, m.
    pub points: [DVec2; 2],
    /// Whether it is a hinge; else it holds the distance of the points.
    pub is_hinge: bool,
    /// Compliance, m/N.
    pub compliance: f64,
}

/// A link of [`BodyTable`](crate::contact::BodyTable).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct LinkRow {
    /// Rows of its bodies, the smaller one first.
    pub rows: [u32; 2],
    /// Its points relative to these bodies where their rotation is 0, m.
    pub arms: [DVec2; 2],
    /// Entity of the link.
    pub entity: Entity,
    /// What it holds.
    pub kind: LinkKind,
    /// Compliance, m/N.
    pub compliance: f64,
}
