//! State of the attempts at one increment: tentative, dropped when the next increment begins.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use glam::DVec2;

use crate::bond::Rupture;
use crate::program::Residuals;

/// What to do after an attempt.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Verdict {
    /// Commit the solution.
    #[default]
    Accept,
    /// Assemble and solve again: something was added to the program.
    Again,
    /// The attempt did not converge, for this reason: try harder.
    Reject(String),
    /// It converged, but threw a grain, for this reason: let loose grains settle first.
    Thrown(String),
}

/// Whether a body that a rejected solution moved far carried load there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Bearing {
    /// It was not moved far.
    #[default]
    Unknown,
    /// It carried nothing: of all its motions it is to make the least.
    Nothing,
    /// It carried nothing at first, but once it made the least motion it was pushed: the load must
    /// find its support without that help.
    Load,
}

/// How an increment ended. The names are those of the history file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum IncrementStatus {
    /// Converged.
    #[default]
    Solved,
    /// No equilibrium exists.
    Collapsed,
    /// No motion exists.
    Locked,
    /// Not converged; nothing was committed.
    Stalled,
    /// Converged, but a cap (cascade, Coulomb's fixed point) was hit on the way.
    Capped,
}

impl IncrementStatus {
    /// The word that the history file uses.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Collapsed => "collapsed",
            Self::Locked => "locked",
            Self::Stalled => "stalled",
            Self::Capped => "capped",
        }
    }
}

/// What [`Corrector`](crate::increment::Corrector) makes of a pair of particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// The pair.
    pub pair: (u32, u32),
    /// Normal from a to b.
    pub normal: DVec2,
    /// Gap where the normal is taken, m: the arms end in its middle.
    pub gap: f64,
    /// Takes the place of the gap at the start, m: less the closing it is the gap at the end.
    pub offset: f64,
    /// What slip is more than its linear expression, m.
    pub slip: f64,
}

/// State of the attempts at the increment under way.
#[derive(Resource, Clone, Debug, Default)]
pub struct Attempt {
    /// Solves so far in this increment.
    pub solves: u32,
    /// Solver iterations so far in this increment.
    pub iterations: u32,
    /// Pairs that the pruning left out and that a solution closed, sorted.
    pub added_pairs: Vec<(u32, u32)>,
    /// Gap up to which detection keeps pairs whatever it expects of their motion, m.
    pub reach: f64,
    /// Bonds that this increment breaks, in the order found; broken when it is committed.
    pub ruptures: Vec<Rupture>,
    /// Rounds of the cascade so far.
    pub cascade_rounds: u32,
    /// Opening that Coulomb's fixed point takes out, m, by contact (a, b), sorted.
    pub openings: Vec<((u32, u32), f64)>,
    /// Passes of the fixed point so far.
    pub coulomb_passes: u32,
    /// What the last pass would change of the openings, m, by contact (a, b), sorted.
    pub coulomb_changes: Vec<((u32, u32), f64)>,
    /// How much of it was made.
    pub coulomb_weight: f64,
    /// Change of the openings in the last pass over the greatest displacement.
    pub coulomb_residual: f64,
    /// Normals, gaps and slips at the place that the last pass led to, sorted by pair.
    pub corrections: Vec<Correction>,
    /// Passes of the corrector so far.
    pub corrector_passes: u32,
    /// What gaps and slips were off by in the last pass over the greatest displacement, or normals.
    pub corrector_residual: f64,
    /// Displacements that push rigid overlaps apart, by body in its own axes; they move the bodies,
    /// and give no velocity.
    pub pushed: Option<Vec<[f64; 3]>>,
    /// 0 at first; every rejection raises it: other scales, regularisation, halving.
    pub effort: u32,
    /// Weight of the proximal term while loose grains settle, in units of force scale over
    /// displacement scale; `None` outside of settling.
    pub settling: Option<f64>,
    /// What rejected solutions say of the load of bodies; empty before there was one.
    pub bearing: Vec<Bearing>,
    /// Bodies that went far in a rejected solution: their taut bonds pull them back; empty before
    /// there was one.
    pub swinging: Vec<bool>,
    /// Whether a mechanism is sought by which the specimen collapses, instead of a solution.
    pub proving: bool,
    /// Bodies that are held where they are while others settle; empty where none is.
    pub held: Vec<bool>,
    /// Whether the last throw has shown anything (pairs, restraints) that was not in the program.
    pub learnt: bool,
    /// Attempts that were made with that since grains last settled.
    pub replies: u32,
    /// How far, in radii, the grain was thrown that was to settle with others held, the last time that
    /// grains settled; `None` where none was to be held.
    pub patched: Option<f64>,
    /// Solves that settled loose grains in this increment.
    pub settled: u32,
    /// Whether loads act on a specimen that carried something before the increment: then it may not
    /// strain without bound.
    pub bounded: bool,
    /// Whether the last solution strained the specimen as a whole by too much.
    pub snaps: bool,
    /// Proximal centre of the regularised re-solves, by body.
    pub centre: Vec<[f64; 3]>,
    /// Moves of that centre in this attempt.
    pub centres: u32,
    /// Of all solutions of this increment that did not converge, the residuals of the one that came
    /// closest, and what the solver said of it.
    pub best: Option<(Residuals, String)>,
    /// Magnitudes of the last rejected solution: greatest displacement (m) and force (N).
    pub magnitudes: Option<(f64, f64)>,
    /// Whether a cap was hit.
    pub capped: bool,
    /// What to do next.
    pub verdict: Verdict,
    /// Status under which the increment ended.
    pub status: IncrementStatus,
    /// Why it stalled, if it did.
    pub complaint: String,
}

impl Attempt {
    /// The correction of a pair, if it has one.
    #[must_use]
    pub fn correction(&self, pair: (u32, u32)) -> Option<&Correction> {
        self.corrections.binary_search_by_key(&pair, |c| c.pair).ok().map(|k| &self.corrections[k])
    }

    /// What the corrector adds to the shear force that an interaction of the given tangential
    /// compliance (that of the program, m/N) starts from, N.
    #[must_use]
    pub fn shear_shift(&self, pair: (u32, u32), compliance: f64) -> f64 {
        match self.correction(pair) {
            Some(c) if compliance > 0.0 => c.slip / compliance,
            _ => 0.0,
        }
    }
}
