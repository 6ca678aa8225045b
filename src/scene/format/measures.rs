//! What a run measures.

use serde::{Deserialize, Serialize};

use super::quantities::Quantity;

/// Names of the measures that define strain and stress. They have columns of their own in the
/// history, and key results follow from them.
pub const ROLES: [&str; 4] = ["axial_strain", "lateral_strain", "axial_stress", "lateral_stress"];

/// A measure with a name: a column of the history, and usable in `stop`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Name.
    pub name: String,
    /// What is measured.
    pub of: Quantity,
}
