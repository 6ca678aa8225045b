//! Walls and their controls.

use serde::{Deserialize, Serialize};

use super::{Bond, Contact, Slide};

/// A wall. Material is on the left of the direction from start to end of a line; all other shapes
/// are thin, with material on their two sides.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Name.
    pub name: String,
    /// Start of the drawn segment, m.
    pub start: (f64, f64),
    /// End of the drawn segment, m.
    pub end: (f64, f64),
    /// Shape between the two, for contact.
    #[serde(default)]
    pub shape: WallShape,
    /// Law of contacts with particles; rigid and frictionless if left out.
    #[serde(default)]
    pub contact: Contact,
    /// Law of bonds with particles; that of the particle's material if left out.
    pub bond: Option<Bond>,
    /// Whether the wall exists from the start. A stage can add it.
    #[serde(default = "super::yes")]
    pub present: bool,
    /// Whether the wall comes at the outermost particles: moved along its inward normal from the
    /// outside until it touches the first one. Such a wall is one that a stage adds.
    #[serde(default)]
    pub touching: bool,
    /// Name under which the history records the wall.
    pub probe: Option<String>,
}

impl Wall {
    /// Whether the wall is where it is drawn. One that a stage brings to the outermost particles is
    /// not.
    pub(crate) fn is_placed(&self) -> bool {
        self.present || !self.touching
    }
}

/// Shape of a wall.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum WallShape {
    /// An infinite line, drawn between start and end.
    #[default]
    Line,
    /// The straight piece from start to end.
    Segment,
    /// Straight pieces from start through these corners to end, m. It is closed where the end is
    /// the start.
    Polyline(Vec<(f64, f64)>),
    /// The circular arc from start through a point to end. Where the end is the start it is the
    /// whole circle on the diameter from there to the point.
    Arc {
        /// A point of the arc between start and end, m.
        through: (f64, f64),
    },
}

impl WallShape {
    /// Whether the wall is one straight piece.
    pub(crate) fn is_straight(&self) -> bool {
        matches!(self, Self::Line | Self::Segment)
    }

    /// Whether it is that of a wall that does not say. Records of such walls do not say either.
    pub fn is_line(&self) -> bool {
        *self == Self::Line
    }
}

/// Control of a wall.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum WallControl {
    /// The wall stays where it is.
    Fixed,
    /// Displacement (x, y) in every increment, m.
    Displacement(f64, f64),
    /// Velocity (x, y), m/s.
    Velocity(f64, f64),
    /// Rotation about a point in every increment.
    Rotation {
        /// The point, which does not move, m.
        about: (f64, f64),
        /// Angle, rad, anticlockwise.
        angle: f64,
    },
    /// Rotation about a point with an angular velocity.
    Spin {
        /// The point, which does not move, m.
        about: (f64, f64),
        /// Angular velocity, rad/s, anticlockwise.
        angular_velocity: f64,
    },
    /// Force along the inward normal at the end of the stage, N.
    Force(f64),
    /// Stress along the inward normal at the end of the stage, Pa.
    Stress {
        /// Stress, Pa, compression positive.
        stress: f64,
        /// The two walls whose current distance is the loaded length; if left out, the length of
        /// the drawn segment.
        between: Option<(String, String)>,
    },
    /// A system of an embedding program drives the wall. The `clastic` program refuses it.
    Custom,
    /// The wall carries a load along its inward normal while it is moved along its tangent.
    Lid {
        /// The load at the end of the stage.
        load: LidLoad,
        /// Motion along the wall, positive from start to end.
        slide: Slide,
    },
    /// The wall follows a table, linear between its points.
    Follow(Table),
}

/// Load of a [`WallControl::Lid`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum LidLoad {
    /// See [`WallControl::Force`].
    Force(f64),
    /// See [`WallControl::Stress`].
    Stress {
        /// Stress, Pa, compression positive.
        stress: f64,
        /// The two walls whose current distance is the loaded length.
        between: Option<(String, String)>,
    },
}

/// Points of a [`WallControl::Follow`]. The first number is the time since the start of the stage,
/// s, in a dynamic stage, and the part of the stage that is done, 0 to 1, in a static one.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Table {
    /// Displacement (x, y) since the start of the stage, m.
    Displacement(Vec<(f64, f64, f64)>),
    /// Force along the inward normal, N.
    Force(Vec<(f64, f64)>),
    /// Rotation about a fixed point. The pieces of a polyline turn together.
    Rotation {
        /// The point, m.
        about: (f64, f64),
        /// Points: angle since the start of the stage, rad, anticlockwise.
        angle: Vec<(f64, f64)>,
    },
    /// Stress along the inward normal.
    Stress {
        /// Points: stress, Pa, compression positive.
        stress: Vec<(f64, f64)>,
        /// The two walls whose current distance is the loaded length.
        between: Option<(String, String)>,
    },
}

impl WallControl {
    /// The two walls whose distance is the length that a stress acts on: `None` without a stress,
    /// `Some(None)` where it acts on the drawn length of the wall.
    pub fn loaded_between(&self) -> Option<Option<&(String, String)>> {
        match self {
            Self::Stress { between, .. }
            | Self::Lid { load: LidLoad::Stress { between, .. }, .. }
            | Self::Follow(Table::Stress { between, .. }) => Some(between.as_ref()),
            _ => None,
        }
    }
}
