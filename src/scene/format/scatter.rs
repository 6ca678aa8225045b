//! Scatter of the strengths and stiffnesses of bonds.

use serde::{Deserialize, Serialize};

/// Random factors of the strengths and stiffnesses of a law, each with a mean of 1. Every bond has
/// draws of its own, which follow from the seed and from where its particles were at the start of
/// the run.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// Seed of the draws.
    pub seed: u64,
    /// One factor for cohesion and tensile strength.
    pub strength: Option<Spread>,
    /// One factor for normal and tangential stiffness.
    pub stiffness: Option<Spread>,
    /// Factor of the cohesion alone.
    pub cohesion: Option<Spread>,
    /// Factor of the tensile strength alone.
    pub tensile_strength: Option<Spread>,
    /// Factor of the normal stiffness alone.
    pub normal_stiffness: Option<Spread>,
    /// Factor of the tangential stiffness alone.
    pub tangential_stiffness: Option<Spread>,
}

/// Distribution of a factor with a mean of 1.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Spread {
    /// Weibull distribution without a threshold.
    Weibull {
        /// Modulus m. The coefficient of variation is about 1.2 / m.
        modulus: f64,
    },
    /// Log-normal distribution.
    LogNormal {
        /// Standard deviation of the logarithm.
        deviation: f64,
    },
}
