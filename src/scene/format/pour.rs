//! A stage that pours grains in.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Analysis, Load, ParticleControl, Record, RigidControl, Sizes, Stop, WallControl};

/// A loading stage in which grains come in through an opening.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(from = "Fields", into = "Fields")]
pub struct Pour {
    /// The grains, and how they come.
    pub stream: Stream,
    /// The stage without its grains.
    pub load: Load,
}

/// Grains that are poured, and how they come.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// Opening, within which the grains appear.
    pub through: Opening,
    /// How many of them come.
    pub rate: Rate,
    /// Size distribution.
    pub sizes: Sizes,
    /// Seed of sizes, places and minerals.
    pub seed: u64,
    /// Material; optional if the scene has only one.
    pub material: Option<String>,
    /// Shares of grains (0 to 1) of other materials, by their names.
    pub minerals: BTreeMap<String, f64>,
    /// Velocity with which they come, m/s.
    pub velocity: (f64, f64),
    /// Group to which they belong, for selections.
    pub group: Option<String>,
}

/// Opening through which grains come. They are within it as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Opening {
    /// Centres lie on this line, at least a radius from its ends.
    Segment {
        /// One end, m.
        start: (f64, f64),
        /// The other end, m.
        end: (f64, f64),
    },
    /// Grains appear anywhere in this rectangle.
    Box {
        /// Lower left corner, m.
        min: (f64, f64),
        /// Upper right corner, m.
        max: (f64, f64),
    },
}

/// Rate at which grains come. The number of grains is within half a grain of it while they find
/// room.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Rate {
    /// Number per second, 1/s.
    Number(f64),
    /// Mass per second, kg/s.
    Mass(f64),
    /// Number over all increments of the stage.
    NumberOverStage(u32),
    /// Mass over all increments of the stage, kg.
    MassOverStage(f64),
}

impl Rate {
    /// Whether it counts mass.
    pub(crate) fn is_of_mass(self) -> bool {
        matches!(self, Self::Mass(_) | Self::MassOverStage(_))
    }

    /// Whether it is spread over the increments of the stage.
    pub(crate) fn is_over_stage(self) -> bool {
        matches!(self, Self::NumberOverStage(_) | Self::MassOverStage(_))
    }

    /// Number or mass (kg) that is due at the end of an increment of a stage.
    pub fn due(self, increments: f64, total: f64, dt: f64) -> f64 {
        match self {
            Self::Number(rate) | Self::Mass(rate) => rate * increments * dt,
            Self::NumberOverStage(number) => f64::from(number) * increments / total,
            Self::MassOverStage(mass) => mass * increments / total,
        }
    }
}

/// Declares the stage as written, whose fields are those of its parts: first and last some of the
/// load, and those of the stream between.
macro_rules! as_written {
    (
        load { $($(#[$a:meta])* $first:ident: $first_type:ty,)* }
        stream { $($(#[$b:meta])* $grain:ident: $grain_type:ty,)* }
        load { $($(#[$c:meta])* $last:ident: $last_type:ty,)* }
    ) => {
        #[derive(Clone, Deserialize, Serialize)]
        #[serde(deny_unknown_fields, rename = "Pour")]
        struct Fields {
            $($(#[$a])* $first: $first_type,)*
            $($(#[$b])* $grain: $grain_type,)*
            $($(#[$c])* $last: $last_type,)*
        }

        impl From<Fields> for Pour {
            fn from(of: Fields) -> Self {
                Self {
                    stream: Stream { $($grain: of.$grain,)* },
                    load: Load { $($first: of.$first,)* $($last: of.$last,)* ..Load::default() },
                }
            }
        }

        impl From<Pour> for Fields {
            fn from(Pour { stream, load }: Pour) -> Self {
                Self {
                    $($first: load.$first,)*
                    $($grain: stream.$grain,)*
                    $($last: load.$last,)*
                }
            }
        }
    };
}

as_written! {
    load {
        name: String,
        increments: u32,
    }
    stream {
        through: Opening,
        rate: Rate,
        sizes: Sizes,
        seed: u64,
        material: Option<String>,
        #[serde(default)]
        minerals: BTreeMap<String, f64>,
        #[serde(default)]
        velocity: (f64, f64),
        group: Option<String>,
    }
    load {
        analysis: Option<Analysis>,
        gravity: Option<(f64, f64)>,
        #[serde(default)]
        walls: BTreeMap<String, WallControl>,
        #[serde(default)]
        remove_walls: Vec<String>,
        #[serde(default)]
        add_walls: Vec<String>,
        #[serde(default)]
        particles: Vec<ParticleControl>,
        #[serde(default)]
        rigid: BTreeMap<String, RigidControl>,
        #[serde(default)]
        release: Vec<String>,
        #[serde(default)]
        stop: Vec<Stop>,
        #[serde(default)]
        record: Record,
    }
}
