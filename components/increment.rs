//! How increments are solved and judged, and how bonds break.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

pub use crate::analysis::{AnalysisKind, ClasticAnalysis, Coulomb, FrictionLaw};
pub use crate::progress::ClasticProgress;

/// What a bond does at its rolling limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum RollingLimit {
    /// It breaks, as in 3.4.2 of the paper.
    #[default]
    Breaks,
    /// It stays intact, and its moment stays on the limit.
    Yields,
}

/// How the specimen comes to rest at constant load after a bond has broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Avalanche {
    /// By equilibria at constant load: in each, the most overloaded bond above its limit breaks.
    #[default]
    MostOverloaded,
    /// By a motion with inertia and kinetic damping ([`Motion`](crate::motion::Motion)), in which
    /// bonds break as they reach their limits.
    Dynamic,
}

/// In which order bonds break.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum RuptureOrder {
    /// From event to event: an increment is committed at the fraction at which the next bond
    /// reaches its limit, that bond breaks, and the specimen comes to equilibrium at constant load
    /// before it is loaded further. It applies to static analysis where all bonds are elastic and
    /// have strength. Elsewhere bonds break as with `OneRound`.
    #[default]
    Events,
    /// All bonds that are on a limit at the end of an increment break, once (3.4.2 of the paper).
    OneRound,
}

/// Rules of rupture: `rupture` of a scene, which has `rolling`, `order`, `density`, `brittleness` and
/// `avalanche`.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
#[serde(rename = "Rupture", deny_unknown_fields, default)]
pub struct RuptureRules {
    /// What a bond does at its rolling limit.
    pub rolling: RollingLimit,
    /// The order in which bonds break.
    pub order: RuptureOrder,
    /// With `Events`: a bond is at its limit when its overload R lies between 1 - tolerance and 1.
    #[serde(skip)]
    pub tolerance: f64,
    /// With `Events`: density of ruptures (share of the bonds per relative change of force) from
    /// which many bonds break together at the end of an increment. Above 20, the maximum, never.
    pub density: f64,
    /// With `Events`: maximum force that ruptures release, as a multiple of the mean contact force,
    /// at which many bonds break together at the end of an increment. 0: only `density` decides.
    pub brittleness: f64,
    /// With `Events`: what happens after the first bond of an avalanche.
    pub avalanche: Avalanche,
    /// A bond is on a limit if its slack is below this fraction of the limit.
    #[serde(skip)]
    pub slack: f64,
    /// Relative rotation, rad, or slip over mean radius, above which a rigid limit counts as
    /// active.
    #[serde(skip)]
    pub multiplier: f64,
}

impl RuptureRules {
    /// Default of [`density`](Self::density).
    pub const DENSITY: f64 = 0.1;
    /// Default of [`brittleness`](Self::brittleness).
    pub const BRITTLENESS: f64 = 0.5;
}

impl Default for RuptureRules {
    fn default() -> Self {
        Self {
            rolling: RollingLimit::default(),
            order: RuptureOrder::default(),
            tolerance: 5e-4,
            density: Self::DENSITY,
            brittleness: Self::BRITTLENESS,
            avalanche: Avalanche::default(),
            slack: 1e-7,
            multiplier: 1e-9,
        }
    }
}

/// What an increment must satisfy before it is committed: `acceptance` of a scene, which has
/// `residual`, `turn` and `halvings`.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
#[serde(deny_unknown_fields, default)]
pub struct Acceptance {
    /// Maximum residual of an accepted solution, without dimension. In dynamic increments without
    /// bonds the default solver aims at it if it is above 1e-8.
    pub residual: f64,
    /// Maximum angle by which one static solution turns a bond or a contact that carries load, rad.
    /// Beyond it constant normals are wrong, and the motion is followed.
    pub turn: f64,
    /// Travel of the furthest grain that a step of a followed motion aims at,
    /// in its radii; at most half of [`MAX_TRAVEL`](Self::MAX_TRAVEL).
    #[serde(skip)]
    pub motion_step: f64,
    /// Maximum overlap of a pair that was not in the program, in mean radii.
    #[serde(skip)]
    pub overlap: f64,
    /// Maximum number of times that an increment is halved.
    pub halvings: u32,
    /// Weight of the proximal term on bodies that nothing holds, in units of force scale over
    /// displacement scale: small enough that results do not depend on it.
    #[serde(skip)]
    pub regularisation: f64,
}

impl Acceptance {
    /// Maximum travel of the furthest grain in a step of a followed motion, in
    /// its radii. Constant normals allow no more.
    pub const MAX_TRAVEL: f64 = 0.3;

    /// Whether a fraction of an increment may be halved. The limit refers to the whole increment and not to
    /// the last fraction. Otherwise a specimen without equilibrium would continue in ever smaller steps.
    pub fn halves(&self, fraction: f64) -> bool {
        0.5 * fraction >= 0.5_f64.powf(f64::from(self.halvings))
    }
}

impl Default for Acceptance {
    fn default() -> Self {
        Self {
            residual: 1e-8,
            turn: 0.2,
            motion_step: 0.15,
            overlap: 1e-6,
            halvings: 6,
            regularisation: 1e-9,
        }
    }
}
