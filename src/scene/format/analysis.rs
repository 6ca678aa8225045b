//! Kind of analysis, friction law, rupture rules.

use serde::{Deserialize, Serialize};

/// Kind of analysis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Analysis {
    /// No inertia, no damping.
    #[default]
    Static,
    /// Theta-method with theta-averaged elastic forces.
    Dynamic {
        /// Time step of an increment, s.
        dt: f64,
        /// 0 < theta <= 1: 1/2 keeps energy, 1 is plastic impact; rebound is (1 - theta)/theta.
        #[serde(default = "super::one")]
        theta: f64,
    },
}

/// Friction law of unbonded contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum FrictionLaw {
    /// The paper's associated law: sliding opens a contact by mu |slip|.
    #[default]
    Associated,
    /// Coulomb's law in dynamic stages, the associated one in static stages.
    ByAnalysis,
    /// Coulomb's law: sliding does not open a contact.
    Coulomb {
        /// Maximum number of factorisations in a solve.
        #[serde(default = "coulomb_factorisations")]
        factorisations: u32,
        /// Read for scenes of earlier builds, and without effect.
        #[serde(default, skip_serializing)]
        tolerance: f64,
        /// Read for scenes of earlier builds, and without effect.
        #[serde(default, skip_serializing)]
        max_passes: u32,
    },
}

impl FrictionLaw {
    /// Coulomb's law with the defaults.
    pub const COULOMB: Self =
        Self::Coulomb { factorisations: FACTORISATIONS, tolerance: 0.0, max_passes: 0 };
}

/// Default of [`FrictionLaw::Coulomb`].
const FACTORISATIONS: u32 = clastic_components::increment::Coulomb::FACTORISATIONS;

fn coulomb_factorisations() -> u32 {
    FACTORISATIONS
}

/// Rules of rupture.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rupture {
    /// What a bond does at its rolling limit.
    pub rolling: RollingLimit,
    /// The order in which bonds break.
    pub order: RuptureOrder,
    /// With `Events`: a bond breaks at an overload between 1 - tolerance and 1.
    pub tolerance: f64,
    /// With `Events`: bonds break together if the forces change by at most this fraction between
    /// their limits.
    pub group: f64,
    /// With `AllAtOnce`: maximum number of rounds.
    pub rounds: u32,
    /// With `Events`: what happens after the first bond of an avalanche.
    #[serde(skip_serializing_if = "Avalanche::is_default")]
    pub avalanche: Avalanche,
}

impl Default for Rupture {
    fn default() -> Self {
        Self {
            rolling: RollingLimit::Breaks,
            order: RuptureOrder::default(),
            tolerance: 5e-4,
            group: 0.0,
            rounds: 200,
            avalanche: Avalanche::default(),
        }
    }
}

/// How the specimen comes to rest at constant load after a bond has broken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Avalanche {
    /// The most overloaded bond breaks, then equilibrium is sought, and so on.
    #[default]
    MostOverloaded,
    /// All bonds above their limits break, then equilibrium is sought, and so on.
    Together,
    /// The motion is followed, and bonds break in it as they reach their limits.
    Dynamic,
}

impl Avalanche {
    /// Whether this is the default, which records of scenes leave out.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The order in which bonds break.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum RuptureOrder {
    /// Bonds break one after the other, each at the load at which it reaches its limit.
    #[default]
    Events,
    /// All bonds at a limit at the end of an increment break, in one round.
    OneRound,
    /// All bonds at a limit break, and those that follow, within the increment.
    AllAtOnce,
}

/// Behaviour of a bond at its rolling limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum RollingLimit {
    /// The bond breaks.
    #[default]
    Breaks,
    /// The moment stays at the limit.
    Yields,
}
