//! The solver.

use serde::{Deserialize, Serialize};

/// The solver.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Solver {
    /// The engine's own condensed solver, with Clarabel as its last resort.
    #[default]
    Condensed,
    /// The interior-point solver Clarabel.
    Clarabel {
        /// Feasibility and gap tolerance that Clarabel is asked for.
        #[serde(default = "tolerance")]
        tolerance: f64,
        /// Cap on its iterations.
        #[serde(default = "max_iterations")]
        max_iterations: u32,
    },
}

fn tolerance() -> f64 {
    1e-10
}

fn max_iterations() -> u32 {
    200
}
