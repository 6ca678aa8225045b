//! Increments of a static stage that are chosen by their error.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// Chooses the increments of the current stage by their error. A world without it makes the
/// increments that the stage asks for.
#[derive(Resource, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct StepControl {
    /// Error of the mean stress that is aimed at, over the norm of the stress.
    pub accuracy: f64,
    /// Fraction of a whole increment that meets the accuracy by the last estimate; above 1 where the
    /// stage asks for smaller increments.
    pub step: f64,
    /// Error over the norm of the stress (xx, xy, yx, yy) for a fraction of 1: a mean over the last
    /// estimates. `None` before the first.
    pub error: Option<[f64; 4]>,
    /// Number of increments since the last estimate.
    pub unchecked: u32,
    /// Two increments that were solved in one, of which the second is still to come.
    pub whole: Option<Whole>,
}

/// End of two increments as one solve finds it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Whole {
    /// Progress of the stage at its end.
    pub end: f64,
    /// Sum of f (x) l over the contacts (xx, xy, yx, yy), N m.
    pub moment: [f64; 4],
}

impl StepControl {
    /// Fraction of the first increments of a stage, whose error is not known.
    const FIRST: f64 = 0.125;

    /// At the start of a stage.
    pub fn new(accuracy: f64) -> Self {
        Self { accuracy, step: Self::FIRST, error: None, unchecked: 0, whole: None }
    }
}
