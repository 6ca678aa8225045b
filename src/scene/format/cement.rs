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
    pub length: Option<f64>,
    /// Mean number of new bonds of a particle: the pairs with the smallest gaps are bonded. It
    /// takes the place of the length.
    pub coordination: Option<f64>,
    /// Whether particles are also bonded to walls.
    #[serde(default)]
    pub walls: bool,
    /// Whether particles are bonded to each other.
    #[serde(default = "super::yes")]
    pub particles: bool,
    /// Particles that are bonded, to each other and to walls; all if left out.
    pub select: Option<Select>,
    /// Law of the bonds; that of the materials and walls if left out.
    pub bond: Option<Bond>,
}
