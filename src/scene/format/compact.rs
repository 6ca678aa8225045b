//! Stages that compact a packing.

use serde::{Deserialize, Serialize};

use super::{Record, Stop};

/// See [`Stage::Compact`](super::Stage::Compact).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Compact {
    /// Name.
    pub name: String,
    /// The wall that moves, along its inward normal. A periodic cell has none: it shrinks along both
    /// of its vectors.
    #[serde(default)]
    pub wall: String,
    /// The fixed wall opposite, which is the reference of the height.
    #[serde(default)]
    pub base: String,
    /// Target that ends the compaction.
    pub target: CompactTarget,
    /// What moves.
    #[serde(default)]
    pub by: CompactBy,
    /// Maximum motion of the wall, change of the width or height of a cell, or growth of the
    /// largest radius, in an increment, m.
    pub step: f64,
    /// Shaking: maximum random motion in an increment, in mean radii, of particles that nothing
    /// pushes, beside that with the wall or the cell in proportion to their height. Without it a
    /// random packing jams before it is dense.
    #[serde(default)]
    pub agitation: f64,
    /// Seed of the shaking.
    #[serde(default)]
    pub seed: u64,
    /// Conditions on measures that end the stage before its target.
    #[serde(default)]
    pub stop: Vec<Stop>,
    /// Recording.
    #[serde(default)]
    pub record: Record,
}

/// Target of a compaction.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum CompactTarget {
    /// Distance between the two walls, m.
    Height(f64),
    /// Porosity between the two walls over the length of the base, or of the cell.
    Porosity(f64),
    /// As dense as the packing gets: until it is jammed.
    Jammed,
}

/// What brings the packing to its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum CompactBy {
    /// The wall, or the cell, moves.
    #[default]
    Boundary,
    /// All radii grow by the same factor, while walls and cell stand still (radius expansion).
    Radii,
}
