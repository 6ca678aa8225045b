//! Walls and their controls.

use serde::{Deserialize, Serialize};

use super::{Bond, Contact};

/// A straight wall. Material is on the left of the direction from start to end.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Name.
    pub name: String,
    /// Start of the drawn segment, m.
    pub start: (f64, f64),
    /// End of the drawn segment, m.
    pub end: (f64, f64),
    /// Law of contacts with particles; rigid and frictionless if left out.
    #[serde(default)]
    pub contact: Contact,
    /// Law of bonds with particles; that of the particle's material if left out.
    #[serde(default)]
    pub bond: Option<Bond>,
    /// Whether the wall exists from the start. A stage can add it.
    #[serde(default = "super::yes")]
    pub present: bool,
    /// Name under which the history records the wall.
    #[serde(default)]
    pub probe: Option<String>,
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
    /// Force along the inward normal at the end of the stage, N.
    Force(f64),
    /// Stress along the inward normal at the end of the stage, Pa.
    Stress {
        /// Stress, Pa, compression positive.
        stress: f64,
        /// The two walls whose current distance is the loaded length; if left out, the length of
        /// the drawn segment.
        #[serde(default)]
        between: Option<(String, String)>,
    },
    /// A system of an embedding program drives the wall. The `clastic` program refuses it.
    Custom,
}
