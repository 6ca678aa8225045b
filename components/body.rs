//! What particles and walls have in common: an identity, a place, a motion, loads.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::identity::{body_gone, body_named};

/// Identity of a body. A particle or wall that is inserted without one gets the next; none is used
/// again.
///
/// Everything that needs an order uses this one: particles by identity, then walls by identity.
/// `Entity` values and query order depend on the history of the world and order nothing. Identities
/// may have gaps; [`Bodies`](crate::contact::Bodies) has one dense row per body.
#[derive(
    Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[component(immutable, on_insert = body_named, on_discard = body_gone)]
pub struct BodyId(pub u32);

/// Centre of a disk, or middle of a wall's drawn segment, m.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Position(pub DVec2);

/// Position at the start of the stage list, m; displacements in the record count from here.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Origin(pub DVec2);

/// Rotation since the start, rad, anticlockwise positive.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Rotation(pub f64);

/// Velocity, m/s. Static analysis leaves it alone.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Velocity(pub DVec2);

/// Angular velocity, rad/s.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct AngularVelocity(pub f64);

/// Displacement of the last committed increment: (x, y) in m and rotation in rad.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct LastMotion(pub [f64; 3]);

/// What the outside world does to one degree of freedom of a body during a whole increment.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub enum Drive {
    /// Nothing: the motion is an unknown.
    #[default]
    Free,
    /// The displacement (m) or rotation (rad) over the whole increment is imposed; 0 holds it.
    Imposed(f64),
}

/// Drives of the three degrees of freedom of a particle: x, y, rotation.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Drives(pub [Drive; 3]);

impl Drives {
    /// Imposes all three displacements of an increment: x, y (m) and rotation (rad); 0 holds.
    #[must_use]
    pub fn imposed(displacements: [f64; 3]) -> Self {
        Self(displacements.map(Drive::Imposed))
    }
}

/// A load that goes linearly from its value at the start of an increment to that at its end.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Ramp {
    /// Value at the start of the increment.
    pub from: f64,
    /// Value at the end of the increment.
    pub to: f64,
}

impl Ramp {
    /// The ramp times a factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { from: self.from * factor, to: self.to * factor }
    }

    /// The value after the given fraction of the increment.
    #[must_use]
    pub fn at(self, fraction: f64) -> f64 {
        // The end is returned as it is, so that a full increment carries the exact target.
        if fraction >= 1.0 { self.to } else { self.from + fraction * (self.to - self.from) }
    }
}

/// Force (x, y; N) and moment (N m) that the outside world applies to a particle, gravity apart.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct AppliedLoad(pub [Ramp; 3]);

/// Loads of a particle over the stage: (value at its start, value at its end) of force x, force y
/// (N) and moment (N m). [`AppliedLoad`] follows from it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct LoadControl(pub [(f64, f64); 3]);

/// Force (x, y; N) and moment (N m) that the outside world exerted on the body in the last
/// committed increment: applied loads, reactions of imposed motion, and for walls whatever
/// holds or moves them. Gravity is not in it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct ExternalForce(pub [f64; 3]);

/// Name under which the history records the body (`NAME.x_m`, ...).
#[derive(Component, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[component(immutable)]
pub struct Probe(pub String);

/// Name of a group of particles that stages can select.
#[derive(Component, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[component(immutable)]
pub struct Group(pub String);
