//! The solver, its settings, and what an increment must satisfy.

use serde::{Deserialize, Serialize};

/// Solves an increment again with normals and gaps at the new place.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Corrector {
    /// Cap on the passes.
    pub passes: u32,
    /// Greatest error of a gap or slip over the greatest displacement, and of a normal.
    pub tolerance: f64,
}

impl Default for Corrector {
    fn default() -> Self {
        Self { passes: 20, tolerance: 1e-6 }
    }
}

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

/// What an increment must satisfy to be committed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Acceptance {
    /// Greatest of the four residuals. Where it is more than 1e-8, dynamic and without bonds, the
    /// default solver aims at it.
    pub residual: f64,
    /// Greatest motion of a grain about the mean field in a static increment, in its radii.
    pub throw: f64,
    /// Greatest strain of the mean field in a static increment beyond what is imposed: a specimen
    /// that strains further under its loads has collapsed.
    pub snap: f64,
    /// How often an increment may be halved.
    pub halvings: u32,
}

impl Default for Acceptance {
    fn default() -> Self {
        Self { residual: 1e-8, throw: 0.3, snap: 0.02, halvings: 6 }
    }
}
