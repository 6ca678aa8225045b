//! Materials: laws of contacts and bonds.

use serde::{Deserialize, Serialize};

/// A particle material.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Density, kg/m^3; needed where there is gravity or dynamics.
    #[serde(default = "rock_density")]
    pub density: f64,
    /// Contacts between particles of this material.
    #[serde(default)]
    pub contact: Contact,
    /// Bonds between particles of this material.
    #[serde(default)]
    pub bond: Option<Bond>,
}

fn rock_density() -> f64 {
    2650.0
}

/// Law of a contact. Without a stiffness it is rigid, without friction frictionless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Contact {
    /// Normal stiffness k_N, N/m; none is rigid.
    pub normal_stiffness: Option<f64>,
    /// Tangential stiffness k_T, N/m; none is rigid.
    pub tangential_stiffness: Option<f64>,
    /// Coefficient of friction.
    pub friction: f64,
    /// Coefficient of rolling friction. With 0 the contact has no rolling moment.
    pub rolling_friction: f64,
    /// Coefficient of restitution, 0 to 1, of a rigid contact in dynamic stages.
    pub restitution: f64,
}

/// Law of a bond. Without a stiffness it is rigid.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Bond {
    /// Normal stiffness k_N, N/m; none is rigid.
    #[serde(default)]
    pub normal_stiffness: Option<f64>,
    /// Tangential stiffness k_T, N/m; none is rigid.
    #[serde(default)]
    pub tangential_stiffness: Option<f64>,
    /// Internal friction coefficient.
    #[serde(default)]
    pub friction: f64,
    /// Coefficient of rolling friction. With 0 the bond has no rolling moment and never breaks in rolling.
    #[serde(default)]
    pub rolling_friction: f64,
    /// Cohesion c, Pa.
    pub cohesion: f64,
    /// Tensile strength sigma_t, Pa.
    pub tensile_strength: f64,
}
