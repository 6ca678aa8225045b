//! Kind of analysis and friction law.
//!
//! The rules of rupture are those of the engine
//! ([`RuptureRules`](clastic_components::increment::RuptureRules)).

use clastic_components::increment::{self, Coulomb};
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
        /// 1/2 to 1: 1/2 keeps energy, 1 is plastic impact; rebound is (1 - theta)/theta.
        #[serde(default = "super::one")]
        theta: f64,
    },
}

/// Friction law of unbonded contacts.
// Not the engine's type: a scene names which analyses have which law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum FrictionLaw {
    /// Coulomb's law in dynamic stages, the associated law in static stages.
    #[default]
    ByAnalysis,
    /// The paper's associated law: sliding opens a contact by mu |slip|.
    Associated,
    /// Coulomb's law: sliding does not open a contact.
    // No unit variant, so that scenes may write `Coulomb()`.
    Coulomb {},
}

impl FrictionLaw {
    /// Coulomb's law.
    pub const COULOMB: Self = Self::Coulomb {};

    /// The law by kind of analysis.
    pub(crate) fn by_analysis(self) -> increment::FrictionLaw {
        let coulomb = Some(Coulomb::default());
        let (in_statics, in_dynamics) = match self {
            Self::Associated => (None, None),
            Self::ByAnalysis => (None, coulomb),
            Self::Coulomb {} => (coulomb, coulomb),
        };
        increment::FrictionLaw { in_statics, in_dynamics }
    }
}

/// The solver.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Solver {
    /// The engine's own solver.
    #[default]
    Condensed,
    /// The interior-point solver Clarabel.
    // No unit variant, so that scenes may write `Clarabel()`.
    Clarabel {},
}
