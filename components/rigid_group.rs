//! Rigid groups: particles and walls that move as one body with three degrees of freedom.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::{
    AppliedLoad, BodyDrive, BodyDrives, BodyExternalForce, BodyId, BodyPosition, BodyRotation,
    LastMotion, LoadControl, Ramp,
};

/// Particles and walls that move as one body. Walls have no mass.
///
/// [`BodyDrives`] and [`LoadControl`] of the group hold, drive or load its three degrees of
/// freedom: the translations of its centre and its rotation. Loads of the members act on the group.
/// Drives of the members have no effect. The centre is the centre of mass, or a pivot that moves
/// with the body; [`BodyPosition`] is its place. A group with walls has a pivot. A body is a member
/// of one group at most.
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable)]
#[require(
    BodyPosition,
    BodyRotation,
    LastMotion,
    BodyDrives,
    LoadControl,
    AppliedLoad,
    BodyExternalForce,
    ContactForce
)]
pub struct RigidGroup {
    /// Name.
    pub name: String,
    /// The members, ascending.
    pub members: Vec<BodyId>,
    /// Whether the centre is a pivot instead of the centre of mass. A dynamic analysis needs its
    /// translations held.
    pub has_pivot: bool,
    /// Rotation of the first member when the group was made, rad. [`BodyRotation`] counts from
    /// there. Particles come before walls.
    pub reference: f64,
}

/// Force (x, y; N) on a body by the contacts and bonds with all other bodies, and their moment
/// about its position at the start of the increment (N m), in the last committed increment.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct ContactForce(pub [f64; 3]);

/// A rigid group of [`BodyTable`](crate::contact::BodyTable). Its row follows those of particles
/// and walls. In the cone program it is the body on which the forces of its members act.
#[derive(Clone, Debug, PartialEq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct GroupRow {
    /// Row of the body.
    pub body: u32,
    /// Rows of the members, ascending.
    pub members: Vec<u32>,
    /// Sum of the masses of the members, kg.
    pub mass: f64,
    /// Moment of inertia about the centre, kg m^2: `sum J + m r^2`.
    pub inertia: f64,
    /// Maximum distance of a member's centre, or of a drawn point of a wall, from the centre, m.
    pub extent: f64,
    /// Drives of the three degrees of freedom.
    pub drives: [BodyDrive; 3],
    /// Loads of the group itself, without those of its members.
    pub loads: [Ramp; 3],
}

impl GroupRow {
    /// Displacement (m, m, rad) of a member at `lever` (m) from the centre, by a finite rotation
    /// about the centre: `u + (R - 1) lever`.
    pub fn carried(u: [f64; 3], lever: DVec2) -> [f64; 3] {
        // 1 - cos = 2 sin^2(alpha/2), without cancellation.
        let half = (0.5 * u[2]).sin();
        let turned = u[2].sin() * lever.perp() - 2.0 * half * half * lever;
        [u[0] + turned.x, u[1] + turned.y, u[2]]
    }

    /// Displacement of a member to first order in the rotation, as the cone program has it.
    pub fn carried_linearly(u: [f64; 3], lever: DVec2) -> [f64; 3] {
        let turned = u[2] * lever.perp();
        [u[0] + turned.x, u[1] + turned.y, u[2]]
    }

    /// Mass of degree of freedom `k`: kg, or kg m^2 of the rotation.
    pub fn mass_of(&self, k: usize) -> f64 {
        if k < 2 { self.mass } else { self.inertia }
    }
}
