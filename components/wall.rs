//! Straight rigid walls.

use bevy_ecs::prelude::*;
#[cfg(feature = "reflect")]
use bevy_ecs::reflect::ReflectComponent;
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
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
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
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable)]
pub struct WallName(pub String);

/// How a wall is controlled during a stage.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub enum WallControl {
    /// It stays where it is.
    #[default]
    Fixed,
    /// It moves by this displacement (m) in every increment.
    Displacement(DVec2),
    /// It moves with this velocity (m/s); dynamic analysis only.
    Velocity(DVec2),
    /// A force (N) along the inward normal, positive into the specimen. It varies linearly over the
    /// stage from `from` to `to`.
    Force {
        /// Value at the start of the stage, N.
        from: f64,
        /// Value at the end of the stage, N.
        to: f64,
    },
    /// A stress (Pa, compression positive) along the inward normal. The force is stress times
    /// current loaded length times thickness. It varies linearly over the stage.
    Stress {
        /// Value at the start of the stage, Pa.
        from: f64,
        /// Value at the end of the stage, Pa.
        to: f64,
        /// Length that the stress acts on.
        length: LoadedLength,
    },
    /// Another system writes the wall's [`WallDrive`].
    Custom,
}

impl WallControl {
    /// Changes the value at the end of the stage and keeps the current value. With `s = done/total`
    /// the ramp starts at `(current - to s)/(1 - s)`, so that its line passes through the current
    /// value. Controls without a load do not change.
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

/// Length that the stress of a stress-controlled wall acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum LoadedLength {
    /// Length of the drawn segment of the wall.
    Segment,
    /// Current distance between two other walls, measured along this wall. Opposite walls that name
    /// one pair share one length, so that their forces balance exactly.
    Between(Entity, Entity),
}

/// Motion or load of a wall during a whole increment, which follows from its control.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
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
