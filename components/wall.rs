//! Straight rigid walls.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::{BodyExternalForce, BodyPosition, LastMotion, Ramp};
use crate::increment::ClasticProgress;
use crate::material::ContactLaw;
use crate::progress::value_at;

/// A rigid wall: an infinite line for contact, drawn between its ends, unless it has another
/// [`WallShape`](crate::wall_shape::WallShape).
///
/// Its [`BodyPosition`] is the middle of the drawn segment; of an arc its middle, of a whole circle
/// its centre. Material lies on the left of the way from start to end: the inward normal is the
/// tangent turned by +90 degrees.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[require(BodyPosition, LastMotion, BodyExternalForce, ContactLaw, WallDrive, WallControl)]
pub struct Wall {
    /// Unit vector from the start to the end of the segment, or along the chord of an arc.
    pub tangent: DVec2,
    /// Half the length of the drawn segment, or of the chord of an arc, m.
    pub half_length: f64,
}

impl Wall {
    /// The wall between two points (m), with its [`BodyPosition`]. Material lies on the left of the
    /// way from start to end.
    ///
    /// # Panics
    /// If the points are one point or not finite, because the wall then has no direction.
    pub fn between(start: DVec2, end: DVec2) -> (Self, BodyPosition) {
        let Some(tangent) = (end - start).try_normalize() else {
            panic!("a wall from {start} to {end} has no direction; give it two different ends")
        };
        let wall = Self { tangent, half_length: 0.5 * start.distance(end) };
        (wall, BodyPosition(0.5 * (start + end)))
    }

    /// Unit normal that points into the specimen.
    pub fn inward(&self) -> DVec2 {
        self.tangent.perp()
    }

    /// The wall turned about its position. `by` is the unit vector (cos, sin) of the angle.
    pub fn turned(&self, by: DVec2) -> Self {
        Self { tangent: by.rotate(self.tangent).normalize(), ..*self }
    }
}

/// Rotation of a wall since the start of the stage list, rad. A wall has it from the first stage
/// that turns it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct WallRotation(pub f64);

/// Name of a wall in the scene.
#[derive(Component, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable)]
pub struct WallName(pub String);

/// How a wall is controlled during a stage.
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub enum WallControl {
    /// It stays where it is.
    #[default]
    Fixed,
    /// It moves by this displacement (m) in every increment.
    Displacement(DVec2),
    /// It moves with this velocity (m/s); dynamic analysis only.
    Velocity(DVec2),
    /// It turns about a point by an angle in every increment.
    Rotation {
        /// The point, which does not move, m.
        about: DVec2,
        /// Angle, rad, anticlockwise.
        angle: f64,
    },
    /// It turns about a point; dynamic analysis only.
    Spin {
        /// The point, which does not move, m.
        about: DVec2,
        /// Angular velocity, rad/s.
        rate: f64,
    },
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
    /// The wall follows its [`WallTable`].
    Table(TableOf),
}

impl WallControl {
    /// Whether the load on the wall changes over the stage.
    pub fn is_ramp(&self) -> bool {
        match self {
            Self::Force { from, to } | Self::Stress { from, to, .. } => from != to,
            Self::Table(_) => true,
            _ => false,
        }
    }

    /// The walls on whose distance its stress acts.
    pub fn loaded_between(&mut self) -> Option<[&mut Entity; 2]> {
        match self {
            Self::Stress { length: LoadedLength::Between(a, b), .. }
            | Self::Table(TableOf::Stress(LoadedLength::Between(a, b))) => Some([a, b]),
            _ => None,
        }
    }
}

/// The quantity of a [`WallTable`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum TableOf {
    /// Displacement (x, y) since the start of the stage, m.
    Displacement,
    /// Force along the inward normal, N.
    Force,
    /// Stress along the inward normal, Pa.
    Stress(LoadedLength),
    /// Angle about this point (m), which does not move, since the start of the stage, rad.
    Rotation(DVec2),
}

/// Motion of a wall along its tangent while it carries a force or a stress: a shear lid.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub enum WallSlide {
    /// Displacement in every increment, m, positive from the start to the end of the wall.
    Displacement(f64),
    /// Velocity, m/s; dynamic analysis only.
    Velocity(f64),
}

/// Points (s, x, y) of a control that is linear between them and constant beyond the last. s is the
/// time since the start of the stage (s) in dynamic analysis, and the part of the stage that is
/// done (0 to 1) in static analysis. In statics s is 1 after the stage, and in an app that has
/// begun none: forces and stresses have their last value, displacements and angles no longer
/// change. A force, a stress or an angle is x.
#[derive(Component, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct WallTable(pub Vec<[f64; 3]>);

impl WallTable {
    /// Ramps of x and y over the whole increment that follows `progress.done`.
    pub fn next(&self, progress: &ClasticProgress, dt: Option<f64>) -> [Ramp; 2] {
        let s = |n: f64| dt.map_or_else(|| progress.part(n), |dt| n * dt);
        [1, 2].map(|k| progress.next(|n| value_at(&self.0, s(n), k)))
    }
}

/// Length that the stress of a stress-controlled wall acts on. A state stores the two walls beside
/// it, by identity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum LoadedLength {
    /// Length of the drawn segment of the wall.
    Segment,
    /// Current distance between two other walls, measured along this wall. Opposite walls that name
    /// one pair share one length, so that their forces balance exactly.
    Between(#[serde(skip, default = "unknown")] Entity, #[serde(skip, default = "unknown")] Entity),
}

fn unknown() -> Entity {
    Entity::PLACEHOLDER
}

/// Motion or load of a wall during a whole increment, which follows from its control.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub enum WallDrive {
    /// Displacement over the increment, m.
    Imposed(DVec2),
    /// Force along the inward normal, N; the wall moves along its normal only.
    Loaded(Ramp),
    /// Force along the inward normal, N, while the wall is moved along its tangent.
    Sliding {
        /// The force.
        load: Ramp,
        /// Displacement along the tangent over the increment, m.
        along: f64,
    },
    /// Rotation over the increment.
    Turning {
        /// The point about which it turns, m.
        about: DVec2,
        /// Angle, rad.
        angle: f64,
    },
}

impl WallDrive {
    /// Force along the inward normal, N; `None` if the motion along the normal is imposed.
    pub fn load(&self) -> Option<Ramp> {
        match *self {
            Self::Imposed(_) | Self::Turning { .. } => None,
            Self::Loaded(load) | Self::Sliding { load, .. } => Some(load),
        }
    }

    /// Imposed translation over the increment, m; zero where the wall turns. `tangent` is that of
    /// the wall.
    pub fn imposed(&self, tangent: DVec2) -> DVec2 {
        match *self {
            Self::Imposed(u) => u,
            Self::Loaded(_) | Self::Turning { .. } => DVec2::ZERO,
            Self::Sliding { along, .. } => along * tangent,
        }
    }
}

impl Default for WallDrive {
    fn default() -> Self {
        Self::Imposed(DVec2::ZERO)
    }
}
