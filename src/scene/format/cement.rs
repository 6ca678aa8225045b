//! Stages that bond particles.

use serde::{Deserialize, Serialize};

use super::{Bond, Select};

/// See [`Stage::Cement`](super::Stage::Cement).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Cement {
    /// Name.
    pub name: String,
    /// Bond length g_int, m: pairs with a smaller gap are bonded (3.4.1 of the paper).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Mean number of new bonds of a particle: the pairs with the smallest gaps are bonded. It
    /// takes the place of the length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coordination: Option<f64>,
    /// Whether particles are also bonded to walls.
    #[serde(default)]
    pub walls: bool,
    /// Whether particles are bonded to each other.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub particles: bool,
    /// Particles that are bonded, to each other and to walls; all if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub select: Option<Select>,
    /// Law of the bonds; that of the materials and walls if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bond: Option<Bond>,
}

fn yes() -> bool {
    true
}

fn is_true(value: &bool) -> bool {
    *value
}
