//! The solver and its settings.

use serde::{Deserialize, Serialize};

/// The solver and its settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Solver {
    /// The engine's own condensed solver, with Clarabel as its last resort.
    #[default]
    Condensed,
    /// The interior-point solver Clarabel.
    Clarabel {
        /// Feasibility and gap tolerance that Clarabel is asked for.
        #[serde(default = "clarabel_tolerance")]
        tolerance: f64,
        /// Cap on its iterations.
        #[serde(default = "clarabel_iterations")]
        max_iterations: u32,
    },
}

fn clarabel_tolerance() -> f64 {
    1e-10
}

fn clarabel_iterations() -> u32 {
    200
}
