//! Flexible membranes in a stage.

use serde::{Deserialize, Serialize};

use super::Sides;

/// Control of a membrane in a stage. The first entry of a name makes the membrane.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MembraneControl {
    /// Pressure at the end of the stage, Pa. It varies linearly.
    pub pressure: f64,
    /// The two walls between which it lies; closed around the specimen if left out. Only where it
    /// is made.
    pub between: Option<(String, String)>,
    /// Sides of the way from the first of these walls to the second; both if left out.
    pub sides: Option<Sides>,
    /// Radius of the ball that finds the outermost grains, m; the maximum radius of the particles
    /// if left out. Only where the membrane is made.
    pub ball: Option<f64>,
}
