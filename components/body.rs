//! Components that particles and walls share: identity, position, motion and loads.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Identity of a body. A particle or wall that is inserted without an identity gets the next one.
/// No identity is used twice: a clone of the entity gets another one.
///
/// All ordered tables use the order of identities: first particles, then walls, each ascending.
/// `Entity` values and query order depend on the history of the world, so nothing is ordered by
/// them. Identities may have gaps; [`BodyTable`](crate::contact::BodyTable) has one dense row per
/// body.
#[derive(
    Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable, clone_behavior = Ignore)]
pub struct BodyId(pub u32);

/// Centre of a disk, or middle of a wall's drawn segment, m.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct BodyPosition(pub DVec2);

/// Position at the start of the stage list, m. Recorded displacements are relative to it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(clone_behavior = Ignore)]
pub struct BodyOrigin(pub DVec2);

/// Rotation since the start, rad, anticlockwise positive.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct BodyRotation(pub f64);

/// Velocity, m/s. Static analysis does not change it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct BodyVelocity(pub DVec2);

/// Angular velocity, rad/s.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct BodyAngularVelocity(pub f64);

/// Displacement of the last committed increment: (x, y) in m and rotation in rad.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct LastMotion(pub [f64; 3]);

/// Boundary condition of one degree of freedom of a body during a whole increment.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum BodyDrive {
    /// Free: the motion is an unknown.
    #[default]
    Free,
    /// Imposed displacement (m) or rotation (rad) over the whole increment; 0 holds the body.
    Imposed(f64),
}

impl BodyDrive {
    /// The imposed displacement (m) or rotation (rad); `None` if it is free.
    pub fn imposed(self) -> Option<f64> {
        if let Self::Imposed(u) = self { Some(u) } else { None }
    }
}

/// Drives of the three degrees of freedom of a particle: x, y, rotation.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct BodyDrives(pub [BodyDrive; 3]);

impl BodyDrives {
    /// Imposes the displacements x, y (m) and the rotation (rad) over an increment; 0 holds the
    /// body.
    pub fn imposed(displacements: [f64; 3]) -> Self {
        Self(displacements.map(BodyDrive::Imposed))
    }
}

/// A load that varies linearly over an increment.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Ramp {
    /// Value at the start of the increment.
    pub from: f64,
    /// Value at the end of the increment.
    pub to: f64,
}

impl Ramp {
    /// The ramp multiplied by a factor.
    pub fn times(self, factor: f64) -> Self {
        Self { from: self.from * factor, to: self.to * factor }
    }

    /// Value after the given fraction of the increment.
    pub fn at(self, fraction: f64) -> f64 {
        // The end is returned unchanged, so that a full increment carries the exact target.
        if fraction >= 1.0 { self.to } else { self.from + fraction * (self.to - self.from) }
    }
}

/// Force (x, y; N) and moment (N m) that the outside world applies to a particle over the next
/// increment, without gravity. It follows from [`LoadControl`] and cannot be set.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct AppliedLoad([Ramp; 3]);

impl AppliedLoad {
    /// The loads over the next whole increment.
    pub fn next(control: &LoadControl, progress: &crate::increment::ClasticProgress) -> Self {
        Self(control.0.map(|(from, to)| progress.ramp(from, to)))
    }

    /// Force x, force y (N) and moment (N m).
    pub fn ramps(&self) -> [Ramp; 3] {
        self.0
    }
}

/// Loads of a particle over the stage: (value at the start, value at the end) of force x, force y
/// (N) and moment (N m). [`AppliedLoad`] follows from them.
///
/// The stage has [`ClasticProgress::total`](crate::increment::ClasticProgress::total) increments. Where it is 0,
/// as in an app without stages, the values at the end act from the next increment on; an app begins
/// a stage with `clastic_systems::load_stage::begin_stage`.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct LoadControl(pub [(f64, f64); 3]);

impl LoadControl {
    /// Constant force x, y (N) and moment (N m).
    pub fn constant(loads: [f64; 3]) -> Self {
        Self(loads.map(|load| (load, load)))
    }
}

/// Force (x, y; N) and moment (N m) of the outside world on the body in the last committed
/// increment: applied loads, reactions to imposed motion, and the forces that hold or move walls.
/// Gravity is excluded. It is a result and no input: [`LoadControl`] loads a body.
#[non_exhaustive]
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct BodyExternalForce(pub [f64; 3]);

impl BodyExternalForce {
    /// The force as a stored state has it.
    pub fn of_state(force: [f64; 3]) -> Self {
        Self(force)
    }
}

/// Name under which the history records the body (`NAME.x_m`, ...).
#[derive(Component, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable)]
pub struct Probe(pub String);

/// Name of a group of particles that stages can select.
#[derive(Component, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable)]
pub struct Group(pub String);
