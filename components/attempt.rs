//! The attempts at one increment: what they seek, their verdicts, and the status of the increment.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::findings::{Bearing, Unconverged};
use crate::motion::Motion;

/// Method of an attempt at an equilibrium, in the order in which the methods are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Effort {
    /// Loose bodies are regularised.
    #[default]
    Usual,
    /// All bodies are regularised, and the centre of the regularisation follows the solution.
    Regularised,
}

/// Aim of the attempts at an increment. The transitions are in `systems/attempt/next.rs`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
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

/// Verdict of the judges on an attempt. The first judge that objects decides.
#[derive(Clone, Debug, PartialEq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Verdict {
    /// The solution is accepted.
    #[default]
    Sound,
    /// A mechanism proves that no forces within the limits balance the loads.
    Impossible,
    /// A mechanism proves that no equilibrium exists, but at most half of the grains move in it.
    Loose,
    /// A judge has added something to the program, which must be solved again.
    Again,
    /// A bond is above its limit. The preceding event is sought at another fraction.
    Overloaded,
    /// Bonds have just broken, and the scene asks for the motion that follows.
    Released,
    /// The solution did not converge: its residuals and the message of the solver.
    Unconverged(String),
    /// Rigid bodies have no feasible motion.
    Locked,
    /// The solution moves so far that its constant normals are no longer valid: the grain and the
    /// turn of its contacts, or its travel in a step of a motion.
    TooFar(String),
    /// A step of a motion is accepted, and the motion goes on.
    Moving,
    /// A step of a motion is accepted, and the motion has come to rest.
    AtRest,
    /// A step of a motion is accepted, and its grains have travelled too far to come to rest: their
    /// travel.
    GivesWay(String),
}

/// Status at the end of an increment. The history file uses these names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum IncrementStatus {
    /// Converged.
    #[default]
    Solved,
    /// No equilibrium exists, or the motion did not come to rest.
    Collapsed,
    /// Neither an equilibrium nor a collapse was found; nothing was committed.
    Undecided,
    /// Committed under Coulomb's law with a residual above the tolerance and within the bound of
    /// `Sliding`.
    Capped,
}

impl IncrementStatus {
    /// Whether the increment was committed.
    pub fn is_committed(self) -> bool {
        matches!(self, Self::Solved | Self::Capped)
    }

    /// The word that the history file uses.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Collapsed => "collapsed",
            Self::Undecided => "undecided",
            Self::Capped => "capped",
        }
    }
}

/// State of the attempts at the current increment, reset when an increment begins.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Attempt {
    /// Aim of the current attempt.
    pub mode: Mode,
    /// Verdict on the last attempt.
    pub verdict: Verdict,
    /// Number of solves so far in this increment.
    pub solves: u32,
    /// Number of solver iterations so far in this increment.
    pub iterations: u32,
    /// Number of motions followed so far at this fraction of the increment.
    pub motions: u32,
    /// Number of steps of all motions of the increment, rejected ones included.
    pub motion_steps: u32,
    /// Number of these steps that belong to motions released by ruptures.
    pub released_steps: u32,
    /// Whether a step of a followed motion has made the imposed motions of the trial.
    pub is_driven: bool,
    /// Maximum turn, rad, in the last solution, if it is too far and that of a bonded grain.
    pub turn: Option<f64>,
    /// That turn in the solution for which the increment was halved last.
    pub halved_turn: Option<f64>,
    /// Whether the motion of a mechanism that proves a collapse is followed.
    pub is_proved: bool,
    /// Maximum displacement (m) and force (N) of the last rejected solution, which are the scales
    /// of the next attempt.
    pub magnitudes: Option<(f64, f64)>,
    /// Whether each body that a rejected solution threw carried load, for restraints.
    pub bearing: Vec<Bearing>,
    /// The solution with the smallest residual of all that did not converge.
    pub best: Option<Unconverged>,
    /// Rows of the particles that have found no rest where the others of a motion have.
    pub left: Vec<usize>,
    /// The share of the specimen that a motion without rest has moved, in words.
    pub moved: Option<String>,
    /// Status under which the increment ended.
    pub status: IncrementStatus,
    /// Complaint about the last rejected attempt, which may be empty. For the status `Undecided` it
    /// is the reason, and for `Collapsed` too unless a mechanism proves the collapse: then
    /// `ConeSolution::certificate` is the reason.
    pub complaint: String,
}

impl Attempt {
    /// The motion that is being followed, if any.
    pub fn motion(&self) -> Option<&Motion> {
        match &self.mode {
            Mode::Motion(motion) => Some(motion),
            Mode::Equilibrium(_) | Mode::Proof => None,
        }
    }

    /// Effort of an attempt at an equilibrium; `None` in a motion or a proof.
    pub fn effort(&self) -> Option<Effort> {
        match self.mode {
            Mode::Equilibrium(effort) => Some(effort),
            Mode::Motion(_) | Mode::Proof => None,
        }
    }
}
