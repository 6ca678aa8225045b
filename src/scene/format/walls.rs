//! Walls and what drives them.

use serde::{Deserialize, Serialize};

use super::{Bond, Contact};

/// A straight wall. Material lies on the left of the way from start to end.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Name.
    pub name: String,
    /// Start of the drawn segment, m.
    pub start: (f64, f64),
    /// End of the drawn segment, m.
    pub end: (f64, f64),
    /// Law of its contacts with particles; without it rigid and frictionless.
    #[serde(default)]
    pub contact: Contact,
    /// Bonds of particles to it; without it they have the law of the particle's material.
    #[serde(default)]
    pub bond: Option<Bond>,
    /// Whether it is there from the start; a stage can bring it in.
    #[serde(default = "yes")]
    pub present: bool,
    /// Name under which the history records it.
    #[serde(default)]
    pub probe: Option<String>,
}

fn yes() -> bool {
    true
}

/// Control of a wall.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum WallControl {
    /// It stays where it is.
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
        /// The two walls whose current distance is the loaded length; without them the length
        /// of the drawn segment.
        #[serde(default)]
        between: Option<(String, String)>,
    },
    /// A system of an embedding program drives it. The `clastic` program refuses it.
    Custom,
}
