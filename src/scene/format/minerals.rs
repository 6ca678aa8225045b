//! Layers and minerals of a specimen.

use serde::{Deserialize, Serialize};

use super::Select;

/// Gives particles of the specimen a material: a layer, or clusters of a mineral.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Mineral {
    /// Material that the particles get.
    pub material: String,
    /// Which particles may get it, where they are in the specimen.
    #[serde(default = "all")]
    pub select: Select,
    /// Only in clusters; all selected particles if left out.
    pub clusters: Option<Clusters>,
}

fn all() -> Select {
    Select::All
}

/// Clusters of a mineral: cells of a random tessellation.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Clusters {
    /// Share of the selected particles by area.
    pub share: f64,
    /// Mean size of a cluster, m: the square root of its area.
    pub size: f64,
    /// Seed of the tessellation.
    pub seed: u64,
}
