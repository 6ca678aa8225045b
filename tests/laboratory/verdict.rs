//! The verdict on a scene, from the way in which its run ended.

use clastic::components::increment::Acceptance;
use clastic::cone::program::{ConeProgram, ConeSolution};
use clastic::run::{Outcome, Simulation};

use crate::certificate;
use crate::scenes::Kind;

/// The verdict on a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Every stage reached its target, its stop condition or its last increment.
    Complete,
    /// All stages ended, and the specimen collapsed in one of them.
    Collapsed {
        /// Whether a mechanism proves every collapse. Otherwise the motion of the specimen showed
        /// it.
        proved: bool,
    },
    /// The engine reported a collapse in a stage in which walls hold the specimen on all sides. The
    /// text is the engine's reason.
    Confined(String),
    /// An increment could not be solved, or the scene needs too many solves. The text says why.
    Undecided(String),
    /// The mechanism of a collapse does not prove it, or the engine panicked.
    Wrong(String),
}

impl Verdict {
    /// The verdict on a run. `proofs` says of every collapse whether a mechanism proves it.
    pub fn of(kind: Kind, outcome: &Outcome, proofs: &[bool]) -> Self {
        match outcome {
            Outcome::Completed => Self::Complete,
            Outcome::Collapsed(first) if !kind.may_collapse_in(&first.stage) => {
                Self::Confined(format!(
                    "collapse in increment {} of `{}`: {}",
                    first.increment, first.stage, first.reason
                ))
            }
            Outcome::Collapsed(_) => Self::Collapsed { proved: proofs.iter().all(|proof| *proof) },
            Outcome::Undecided { message, .. } => Self::Undecided(message.clone()),
            Outcome::Refused { message, .. } | Outcome::Halted(message) => {
                Self::Wrong(message.clone())
            }
        }
    }

    /// Name in the table. Failures are in capital letters.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Collapsed { proved: true } => "collapsed",
            Self::Collapsed { proved: false } => "gave way",
            Self::Confined(_) => "CONFINED",
            Self::Undecided(_) => "UNDECIDED",
            Self::Wrong(_) => "WRONG",
        }
    }

    /// Reason of a failure; empty otherwise.
    pub fn reason(&self) -> &str {
        match self {
            Self::Confined(reason) | Self::Undecided(reason) | Self::Wrong(reason) => reason,
            _ => "",
        }
    }

    pub fn is_failure(&self) -> bool {
        !self.reason().is_empty()
    }
}

/// Checks the collapse in which the last increment ended. Returns whether the collapse has a
/// mechanism, or what is wrong with that mechanism.
pub fn check_collapse(simulation: &mut Simulation) -> Result<bool, String> {
    let world = simulation.world();
    let Some(proof) = world.resource::<ConeSolution>().certificate.clone() else {
        return Ok(false);
    };
    let program = world.resource::<ConeProgram>();
    certificate::check(program, &proof.mechanism)?;
    // Pairs that close within this motion must be in the program (section 9).
    let reach = 2.0 * Acceptance::MAX_TRAVEL * program.scales.length;
    certificate::check_absent_pairs(simulation, &proof.mechanism, reach)?;
    Ok(true)
}
