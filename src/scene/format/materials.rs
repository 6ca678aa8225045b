//! Materials: laws of contacts and bonds, and the scatter of bonds.

use serde::{Deserialize, Serialize};

/// A particle material.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Density, kg/m^3; required with gravity or dynamics.
    #[serde(default = "rock_density")]
    pub density: f64,
    /// Contacts between particles of this material.
    #[serde(default)]
    pub contact: Contact,
    /// Bonds between particles of this material.
    pub bond: Option<Bond>,
}

fn rock_density() -> f64 {
    2650.0
}

/// Law of a contact. It is rigid without stiffness, and frictionless without friction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Contact {
    /// Normal stiffness k_N, N/m; rigid if left out.
    pub normal_stiffness: Option<f64>,
    /// Tangential stiffness k_T, N/m; rigid if left out.
    pub tangential_stiffness: Option<f64>,
    /// Rolling stiffness k_R, N m/rad; rigid if left out.
    pub rolling_stiffness: Option<f64>,
    /// Coefficient of friction.
    pub friction: f64,
    /// Coefficient of rolling friction. 0 means that the contact has no rolling moment.
    pub rolling_friction: f64,
    /// Coefficient of restitution, 0 to 1, of a rigid contact in dynamic stages.
    pub restitution: f64,
}

impl Contact {
    /// Normal, tangential and rolling stiffness.
    pub fn stiffnesses(&self) -> [Option<f64>; 3] {
        [self.normal_stiffness, self.tangential_stiffness, self.rolling_stiffness]
    }
}

/// Law of a bond, which is rigid without stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Bond {
    /// Normal stiffness k_N, N/m; that of the contact if left out.
    pub normal_stiffness: Option<f64>,
    /// Tangential stiffness k_T, N/m; that of the contact if left out.
    pub tangential_stiffness: Option<f64>,
    /// Rolling stiffness k_R, N m/rad; that of the contact if left out.
    pub rolling_stiffness: Option<f64>,
    /// Internal friction coefficient.
    #[serde(default)]
    pub friction: f64,
    /// Coefficient of rolling friction. 0 means that the bond has no rolling moment and never
    /// breaks by rolling.
    #[serde(default)]
    pub rolling_friction: f64,
    /// Cohesion c, Pa.
    pub cohesion: f64,
    /// Tensile strength sigma_t, Pa.
    pub tensile_strength: f64,
    /// Scatter of strengths and stiffnesses about these values.
    pub scatter: Option<Scatter>,
}

impl Bond {
    /// Normal, tangential and rolling stiffness.
    pub fn stiffnesses(&self) -> [Option<f64>; 3] {
        [self.normal_stiffness, self.tangential_stiffness, self.rolling_stiffness]
    }
}

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
