//! What is written and recorded.

use serde::{Deserialize, Serialize};

/// What is written beside the history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// A frame (CSV of all particles) every so many increments; 0 writes only the last.
    pub frames_every: u32,
    /// Pictures (SVG) of curves and specimen.
    pub plots: bool,
    /// The energy ledger in the history.
    pub energy: bool,
}

impl Default for Output {
    fn default() -> Self {
        Self { frames_every: 0, plots: true, energy: false }
    }
}

/// What a stage leaves in the results. Ruptures and key results see every increment in any case.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Record {
    /// A row of the history every so many increments of the stage, and at its end.
    pub every: u32,
    /// A frame every so many increments of the stage, 0 for none; left out, as `output` says.
    pub frames_every: Option<u32>,
    /// Frames after these increments of the stage, from 1.
    pub frames: Vec<u32>,
}

impl Default for Record {
    fn default() -> Self {
        Self { every: 1, frames_every: None, frames: Vec::new() }
    }
}
