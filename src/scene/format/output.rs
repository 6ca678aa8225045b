//! Output and recording.

use serde::{Deserialize, Serialize};

/// Output in addition to the history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Number of increments between frames; 0 writes only those of the start, the peak and the end.
    pub frames_every: u32,
    /// Whether the page `report.html` is written at the end.
    pub plots: bool,
    /// Whether the history contains the energy ledger.
    pub energy: bool,
}

impl Default for Output {
    fn default() -> Self {
        Self { frames_every: 0, plots: true, energy: false }
    }
}

/// Recording of a stage. Ruptures and key results use every increment in any case.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Record {
    /// Number of increments between rows of the history. The last increment of the stage always has
    /// a row.
    pub every: u32,
    /// Number of increments between frames; 0 for none; the value of `output` if left out.
    pub frames_every: Option<u32>,
    /// Numbers of increments of the stage, from 1, after which frames are written.
    pub frames: Vec<u32>,
}

impl Default for Record {
    fn default() -> Self {
        Self { every: 1, frames_every: None, frames: Vec::new() }
    }
}
