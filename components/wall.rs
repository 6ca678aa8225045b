//! Straight rigid walls.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::{ExternalForce, LastMotion, Position, Ramp};
use crate::identity::body_added;
use crate::increment::Progress;
use crate::material::ContactLaw;

/// A straight rigid wall: an infinite line for contact, drawn between its ends.
///
/// Its [`Position`] is the middle of the drawn segment. Material lies on the left of the way from
/// start to end: the inward normal is the tangent turned by +90 degrees. A wall does not rotate.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[component(on_add = body_added)]
#[require(Position, LastMotion, ExternalForce, ContactLaw, WallDrive, WallControl)]
pub struct Wall {
    /// Unit vector from the start to the end of the segment.
    pub tangent: DVec2,
    /// Half the length of the drawn segment, m.
    pub half_length: f64,
}

impl Wall {
    /// Unit normal that points into the specimen.
    #[must_use]
    pub fn inward(&self) -> DVec2 {
        self.tangent.perp()
    }
}

/// Name of a wall in the scene.
#[derive(Component, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[component(immutable)]
pub struct WallName(pub String);

/// How a wall is controlled during a stage.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default)]
pub enum WallControl {
    /// It stays where it is.
    #[default]
    Fixed,
    /// It moves by this displacement (m) in every increment.
    Displacement(DVec2),
    /// It moves with this velocity (m/s); dynamic analysis only.
    Velocity(DVec2),
    /// A force (N) along the inward normal, positive into the specimen. It goes linearly from
    /// `from`, its value at the start of the stage, to `to` over the stage's increments.
    Force {
        /// Value at the start of the stage, N.
        from: f64,
        /// Value at the end of the stage, N.
        to: f64,
    },
    /// A stress (Pa, compression positive) times the current loaded length times the thickness,
    /// along the inward normal, ramped over the stage like a force.
    Stress {
        /// Value at the start of the stage, Pa.
        from: f64,
        /// Value at the end of the stage, Pa.
        to: f64,
        /// What the stress acts on.
        length: LoadedLength,
    },
    /// Another system writes the wall's [`WallDrive`].
    Custom,
}

impl WallControl {
    /// The same load on its way to another value at the end of the stage. It goes on from what it has reached:
    /// with `s = done/total` the ramp starts at `(reached - to s)/(1 - s)`, so that its line passes through the
    /// value reached. Controls that are no load stay as they are.
    #[must_use]
    pub fn retarget(self, progress: &Progress, target: f64) -> Self {
        let aim = |from: f64, to: f64| {
            let s = progress.done / progress.total;
            let reached = progress.ramp(from, to).from;
            if s < 1.0 { (reached - target * s) / (1.0 - s) } else { target }
        };
        match self {
            Self::Force { from, to } => Self::Force { from: aim(from, to), to: target },
            Self::Stress { from, to, length } => {
                Self::Stress { from: aim(from, to), to: target, length }
            }
            other => other,
        }
    }
}

/// The length that a stress-controlled wall is loaded over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadedLength {
    /// The length of its drawn segment.
    Segment,
    /// The current distance between two other walls, measured along this wall. Opposite walls
    /// that name the same two share one length, so that their forces balance exactly.
    Between(Entity, Entity),
}

/// What a wall does during a whole increment: the result of its control.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum WallDrive {
    /// Displacement over the increment, m.
    Imposed(DVec2),
    /// Force along the inward normal, N; the wall moves along its normal only.
    Loaded(Ramp),
}

impl Default for WallDrive {
    fn default() -> Self {
        Self::Imposed(DVec2::ZERO)
    }
}
