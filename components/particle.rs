//! Disks.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::body::{
    AppliedLoad, BodyAngularVelocity, BodyDrives, BodyExternalForce, BodyPosition, BodyRotation,
    BodyVelocity, LastMotion, LoadControl,
};

/// A rigid disk. It cannot be changed in place: insert another `Particle`.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable)]
#[require(
    BodyPosition,
    BodyRotation,
    BodyVelocity,
    BodyAngularVelocity,
    LastMotion,
    BodyDrives,
    LoadControl,
    AppliedLoad,
    BodyExternalForce,
    MaterialIndex
)]
pub struct Particle {
    /// Radius, m.
    pub radius: f64,
    /// Mass, kg: density x pi r^2 h.
    pub mass: f64,
    /// Mass moment of inertia, kg m^2: m r^2 / 2.
    pub inertia: f64,
    /// Thickness h for which the mass was computed, m, if it is known. The world halts if
    /// [`ClasticAnalysis`](crate::increment::ClasticAnalysis), whose thickness gives forces and
    /// stresses, has another one.
    #[serde(skip)]
    pub thickness: Option<f64>,
}

impl Particle {
    /// A homogeneous disk of the given radius (m), density (kg/m^3) and thickness (m).
    pub fn disk(radius: f64, density: f64, thickness: f64) -> Self {
        let mass = density * std::f64::consts::PI * radius * radius * thickness;
        let inertia = 0.5 * mass * radius * radius;
        Self { radius, mass, inertia, thickness: Some(thickness) }
    }
}

/// Index of a particle's material in [`Materials`](crate::material::Materials), by default 0. If
/// the list is empty, contacts are rigid and frictionless, whatever the index. An index beyond the
/// last material of a list halts the world.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct MaterialIndex(pub u32);

/// Marks a particle that static stages have set aside: it fell or rolled without finding rest, and
/// carried nothing but itself. Its weight does not act in static increments until a force acts on it
/// again. A dynamic increment takes the mark away.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct SetAside;
