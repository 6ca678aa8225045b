//! Conditions that end a stage.

use serde::{Deserialize, Serialize};

/// A condition that ends a stage. A collapse always ends it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Stop {
    /// After its peak, the axial stress falls below this fraction of the peak. The drop must exceed
    /// the error of the stress that `acceptance.residual` allows.
    StressDrop(f64),
    /// The maximum speed of a particle falls below this value, m/s (after the first increment).
    Rest(f64),
    /// A measure, by name, is at or below this value.
    Below(String, f64),
    /// A measure, by name, is at or above this value.
    Above(String, f64),
    /// A measure, by name, lands on this value: the last increment is shortened.
    Until(String, f64),
    /// No grain that is due has found room for this time, s, in a stage that pours.
    Full(f64),
}

impl Stop {
    /// Name of the measure that the condition is about.
    #[must_use]
    pub fn measure(&self) -> Option<&str> {
        match self {
            Self::StressDrop(_) => Some("axial_stress"),
            Self::Rest(_) | Self::Full(_) => None,
            Self::Below(name, _) | Self::Above(name, _) | Self::Until(name, _) => Some(name),
        }
    }
}
