//! A stage that pours grains in.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Analysis, Load, ParticleControl, Record, RigidControl, Sizes, Stop, WallControl};
use crate::scene::unique_keys;

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
    #[must_use]
    pub fn is_of_mass(self) -> bool {
        matches!(self, Self::Mass(_) | Self::MassOverStage(_))
    }

    /// Whether it is spread over the increments of the stage.
    #[must_use]
    pub fn is_over_stage(self) -> bool {
        matches!(self, Self::NumberOverStage(_) | Self::MassOverStage(_))
    }

    /// Number or mass (kg) that is due at the end of an increment of a stage.
    #[must_use]
    pub fn due(self, increments: f64, total: f64, dt: f64) -> f64 {
        match self {
            Self::Number(rate) | Self::Mass(rate) => rate * increments * dt,
            Self::NumberOverStage(number) => f64::from(number) * increments / total,
            Self::MassOverStage(mass) => mass * increments / total,
        }
    }
}

/// The stage as written.
#[derive(Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields, rename = "Pour")]
struct Fields {
    name: String,
    increments: u32,
    through: Opening,
    rate: Rate,
    sizes: Sizes,
    seed: u64,
    #[serde(default)]
    material: Option<String>,
    #[serde(default, deserialize_with = "unique_keys::deserialize")]
    minerals: BTreeMap<String, f64>,
    #[serde(default)]
    velocity: (f64, f64),
    #[serde(default)]
    group: Option<String>,
    #[serde(default)]
    analysis: Option<Analysis>,
    #[serde(default)]
    gravity: Option<(f64, f64)>,
    #[serde(default, deserialize_with = "unique_keys::deserialize")]
    walls: BTreeMap<String, WallControl>,
    #[serde(default)]
    remove_walls: Vec<String>,
    #[serde(default)]
    add_walls: Vec<String>,
    #[serde(default)]
    particles: Vec<ParticleControl>,
    #[serde(default, deserialize_with = "unique_keys::deserialize")]
    rigid: BTreeMap<String, RigidControl>,
    #[serde(default)]
    release: Vec<String>,
    #[serde(default)]
    stop: Vec<Stop>,
    #[serde(default)]
    record: Record,
}

impl From<Fields> for Pour {
    fn from(of: Fields) -> Self {
        let stream = Stream {
            through: of.through,
            rate: of.rate,
            sizes: of.sizes,
            seed: of.seed,
            material: of.material,
            minerals: of.minerals,
            velocity: of.velocity,
            group: of.group,
        };
        let load = Load {
            scale: super::Scale::default(),
            name: of.name,
            increments: of.increments,
            analysis: of.analysis,
            gravity: of.gravity,
            walls: of.walls,
            remove_walls: of.remove_walls,
            add_walls: of.add_walls,
            particles: of.particles,
            rigid: of.rigid,
            release: of.release,
            membranes: BTreeMap::new(),
            remove_membranes: Vec::new(),
            cell: None,
            accuracy: None,
            stop: of.stop,
            record: of.record,
        };
        Self { stream, load }
    }
}

impl From<Pour> for Fields {
    fn from(Pour { stream, load }: Pour) -> Self {
        Self {
            name: load.name,
            increments: load.increments,
            through: stream.through,
            rate: stream.rate,
            sizes: stream.sizes,
            seed: stream.seed,
            material: stream.material,
            minerals: stream.minerals,
            velocity: stream.velocity,
            group: stream.group,
            analysis: load.analysis,
            gravity: load.gravity,
            walls: load.walls,
            remove_walls: load.remove_walls,
            add_walls: load.add_walls,
            particles: load.particles,
            rigid: load.rigid,
            release: load.release,
            stop: load.stop,
            record: load.record,
        }
    }
}
