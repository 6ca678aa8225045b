//! Grains that stages have poured in so far.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// Grains that stages have poured in since the start of the run, or of the run that saved the state
/// from which it starts. A run that has poured nothing has no such resource.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Poured {
    /// Number of grains.
    pub number: u64,
    /// Their mass, kg.
    pub mass: f64,
    /// Number and mass (kg) before the stage that pours, or that poured last.
    pub before: (u64, f64),
    /// Number of places that were tried in that stage, which is the number of random places drawn.
    pub tries: u64,
    /// Time at which the grain that waits first found no room, s; `None` if no grain waits.
    pub waits_since: Option<f64>,
}
