//! Bonds.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::BodyId;
use crate::material::BondLaw;

/// Dense identity of a bond, in order of creation. It never changes and is never used again.
#[derive(
    Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[component(immutable)]
pub struct BondId(pub u32);

/// A bond between two bodies. The endpoints are plain fields, not relationships: adding or
/// removing relationships reorders archetypes.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[require(BondState)]
pub struct Bond {
    /// First body, always a particle; `a < b`.
    pub a: BodyId,
    /// Second body, a particle or a wall.
    pub b: BodyId,
    /// Gap at creation, `g_b0`, m: the bond is free of stress there.
    pub initial_gap: f64,
    /// Its law.
    pub law: BondLaw,
}

/// Whether a bond still holds.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum BondState {
    /// Carries tension, shear and moment up to its strength.
    #[default]
    Intact,
    /// Broken for good.
    Broken(RuptureMode),
}

/// The limit on which a bond broke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RuptureMode {
    /// `p = -f_t`.
    Tension,
    /// `|q| = c A + mu_b p`.
    Shear,
    /// `|tau| = mu_r r (p + f_t)`.
    Rolling,
}

impl RuptureMode {
    /// The word that the event file uses.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tension => "tension",
            Self::Shear => "shear",
            Self::Rolling => "rolling",
        }
    }
}

/// One rupture: which bond, on which limit, where, and the forces that it carried then.
#[derive(Message, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rupture {
    /// Increment of the rupture.
    pub increment: u64,
    /// The bond.
    pub bond: BondId,
    /// Its first body.
    pub a: BodyId,
    /// Its second body.
    pub b: BodyId,
    /// The limit that was reached.
    pub mode: RuptureMode,
    /// Contact point at the start of the increment, m.
    pub position: DVec2,
    /// Unit normal from a to b at the start of the increment.
    pub normal: DVec2,
    /// Normal force, compression positive, N.
    pub p: f64,
    /// Shear force, N.
    pub q: f64,
    /// Rolling moment, N m.
    pub tau: f64,
}
