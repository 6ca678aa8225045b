//! The attempts at one increment: what is sought, what came of it, how the increment ended.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::motion::Motion;

/// How hard an attempt at an equilibrium tries, in the order in which efforts follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Effort {
    /// Expected magnitudes are the scales; what nothing holds is regularised.
    #[default]
    Usual,
    /// Magnitudes of the last solution are the scales.
    Rescaled,
    /// Every body is regularised, about a centre that follows the solution.
    Regularised,
}

/// What the attempts of an increment seek. The transitions are in `systems/attempt/next.rs`.
#[derive(Clone, Debug, PartialEq)]
pub enum Mode {
    /// The forces and displacements at the end of the increment.
    Equilibrium(Effort),
    /// The next step of a motion under constant loads, where equilibrium was lost.
    Motion(Motion),
    /// A mechanism that proves that no equilibrium exists.
    Proof,
}

impl Default for Mode {
    fn default() -> Self {
        Self::Equilibrium(Effort::Usual)
    }
}

/// What the judges say of an attempt. The first judge that objects decides.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Verdict {
    /// The solution stands.
    #[default]
    Sound,
    /// A mechanism proves that no forces within the limits balance the loads.
    Impossible,
    /// A judge has added something to the program: solve it again.
    Again,
    /// A bond is above its limit: the event before it is sought at another fraction.
    Overloaded,
    /// Bonds have just broken, and the scene wants the motion followed by which the specimen comes to rest after them.
    Released,
    /// The solution did not converge.
    Unconverged {
        /// The residuals, and what the solver said.
        reason: String,
        /// Whether bodies went so far that a hold is missing, and not other scales.
        flung: bool,
    },
    /// Rigid bodies have no feasible motion.
    Locked,
    /// The solution lies too far away for normals that stay as they are.
    TooFar(
        /// Which grain goes how far, or how much the specimen strains.
        String,
    ),
    /// A step of a motion stands, and the motion goes on.
    Moving,
    /// A step of a motion stands, and after it nothing moves any more.
    AtRest {
        /// Whether the motion has gone anywhere.
        moved: bool,
    },
    /// A step of a motion stands, and with it the specimen has strained further than one that finds rest.
    GivesWay(
        /// How far it has strained.
        String,
    ),
}

/// How an increment ended. The names are those of the history file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum IncrementStatus {
    /// Converged.
    #[default]
    Solved,
    /// No equilibrium exists, or the motion found no rest.
    Collapsed,
    /// Neither an equilibrium nor a collapse was found; nothing was committed.
    Undecided,
    /// Committed under Coulomb's law with a residual above the tolerance and within the bound of `Sliding`.
    Capped,
}

impl IncrementStatus {
    /// The word that the history file uses.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Collapsed => "collapsed",
            Self::Undecided => "undecided",
            Self::Capped => "capped",
        }
    }
}

/// State of the attempts at the increment under way: tentative, made anew when an increment begins.
#[derive(Resource, Clone, Debug, Default)]
pub struct Attempt {
    /// What is sought.
    pub mode: Mode,
    /// What the judges said of the last attempt.
    pub verdict: Verdict,
    /// Solves so far in this increment.
    pub solves: u32,
    /// Solver iterations so far in this increment.
    pub iterations: u32,
    /// Motions that were followed so far in this increment.
    pub motions: u32,
    /// Steps of these motions, rejected ones included.
    pub motion_steps: u32,
    /// Of these, the steps of motions that ruptures released.
    pub released_steps: u32,
    /// Strain of the mean field that these motions add up to; what was put back does not count.
    pub motion_strain: f64,
    /// Whether loads act on a specimen that carried something before the increment: then it may not
    /// strain without bound.
    pub bounded: bool,
    /// Maximum displacement (m) and force (N) of the last solution that was not accepted: the scales of
    /// the next attempt.
    pub magnitudes: Option<(f64, f64)>,
    /// Status under which the increment ended.
    pub status: IncrementStatus,
    /// Why it ended so, if it was not solved.
    pub complaint: String,
}

impl Attempt {
    /// The motion that is followed, if one is.
    #[must_use]
    pub fn motion(&self) -> Option<&Motion> {
        match &self.mode {
            Mode::Motion(motion) => Some(motion),
            Mode::Equilibrium(_) | Mode::Proof => None,
        }
    }

    /// How hard an attempt at an equilibrium tries; none where something else is sought.
    #[must_use]
    pub fn effort(&self) -> Option<Effort> {
        match self.mode {
            Mode::Equilibrium(effort) => Some(effort),
            Mode::Motion(_) | Mode::Proof => None,
        }
    }
}
