//! Specimens: sources of the particles, layers and minerals.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Select;

/// Source of the particles.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Specimen {
    /// List of particles.
    Particles(Vec<Particle>),
    /// A triangular lattice of equal, touching disks; the outermost ring is the group `boundary`.
    Lattice {
        /// Disks in a row. Every second row has one less.
        columns: u32,
        /// Rows.
        rows: u32,
        /// Radius, m.
        radius: f64,
        /// Centre of the lower left disk, m.
        #[serde(default)]
        origin: (f64, f64),
        /// Material; optional if the scene has only one.
        material: Option<String>,
    },
    /// Random disks on a loose square grid, one at a random position in each cell. A `Compact`
    /// stage makes a packing of them.
    Packing {
        /// Number of disks.
        count: u32,
        /// Columns of the grid.
        columns: u32,
        /// Spacing of the grid, m; at least the maximum diameter.
        spacing: f64,
        /// Lower left corner of the grid, m.
        #[serde(default)]
        origin: (f64, f64),
        /// Size distribution.
        sizes: Sizes,
        /// Seed of sizes and positions.
        seed: u64,
        /// Material; optional if the scene has only one.
        material: Option<String>,
    },
    /// A stored specimen: CSV with the columns x_m, y_m, radius_m (and optionally material).
    File {
        /// Path, relative to the scene file.
        path: String,
        /// Material of rows that name none.
        material: Option<String>,
    },
    /// The state at the end of another run, or where a `Save` stage kept it: particles with forces,
    /// velocities, bonds and loads, and its walls unless the scene lists walls.
    State {
        /// Path of the `.npz` file, relative to the scene file.
        path: String,
        /// Materials of the scene by the names that they have in the state. A name that is left out
        /// stays.
        #[serde(default)]
        materials: BTreeMap<String, String>,
    },
}

/// Size distribution of a packing.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Sizes {
    /// Equal radii.
    Equal {
        /// Radius, m.
        radius: f64,
    },
    /// Uniform distribution by number between two radii.
    Uniform {
        /// Minimum and maximum radius, m.
        radius: (f64, f64),
    },
    /// Log-normal distribution by number between limits.
    LogNormal {
        /// Median radius, m.
        radius: f64,
        /// Standard deviation of the logarithm.
        deviation: f64,
        /// Minimum and maximum radius, m.
        limits: (f64, f64),
    },
    /// A sieve curve by mass, linear in the logarithm of the diameter between its points.
    Sieve {
        /// Diameters, m, and the per cent by mass that pass them, from 0 to 100.
        passing: Vec<(f64, f64)>,
    },
}

impl Sizes {
    /// Minimum and maximum radius, m; `None` for a sieve curve without points.
    pub fn limits(&self) -> Option<(f64, f64)> {
        match self {
            Self::Equal { radius } => Some((*radius, *radius)),
            Self::Uniform { radius: limits } | Self::LogNormal { limits, .. } => Some(*limits),
            Self::Sieve { passing } => Some((0.5 * passing.first()?.0, 0.5 * passing.last()?.0)),
        }
    }
}

/// One particle.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Particle {
    /// Centre (x, y), m.
    pub position: (f64, f64),
    /// Radius, m.
    pub radius: f64,
    /// Material; optional if the scene has only one.
    pub material: Option<String>,
    /// Initial velocity, m/s.
    #[serde(default)]
    pub velocity: (f64, f64),
    /// Initial angular velocity, rad/s.
    #[serde(default)]
    pub angular_velocity: f64,
    /// Group for selection by stages.
    pub group: Option<String>,
    /// Name under which the history records the particle.
    pub probe: Option<String>,
}

/// A bond between two particles, by their index in the specimen (from 0).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ExplicitBond {
    /// First particle.
    pub a: u32,
    /// Second particle.
    pub b: u32,
}

/// Gives particles of the specimen a material, as those of a layer.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Mineral {
    /// Material that the particles get.
    pub material: String,
    /// Which particles get it, where they are in the specimen.
    #[serde(default = "all")]
    pub select: Select,
}

fn all() -> Select {
    Select::All
}
