//! What a run measures.

use clastic_components::measure;
use clastic_components::observation::{MeasureArea, MeasureLength, StrainMeasure, StressMeasure};
use serde::{Deserialize, Serialize};

use super::Select;

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

/// What is measured, with the names of walls and membranes, and the indices of particles.
pub type Quantity = measure::Quantity<String, u32, Select>;
/// A strain since the start of the reference stage.
pub type Strain = StrainMeasure<String, u32>;
/// A stress.
pub type Stress = StressMeasure<String>;
/// Length of a wall stress.
pub type Length = MeasureLength<String>;
/// Area of an average stress.
pub type Area = MeasureArea<String>;
