//! Materials: laws of contacts and bonds.

use serde::{Deserialize, Serialize};

use super::Scatter;

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
