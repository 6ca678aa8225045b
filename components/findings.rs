//! What the judges of an increment have found so far: judges write these tables, assembly reads them. All are dropped
//! when the next increment begins.

use bevy_ecs::prelude::*;
use glam::DVec2;

use crate::bond::Rupture;
use clastic_cone::program::Residuals;

/// Pairs that the pruning of detection left out and that a solution closed, sorted.
#[derive(Resource, Clone, Debug, Default)]
pub struct AddedPairs(pub Vec<(u32, u32)>);

/// Bonds that the increment breaks.
#[derive(Resource, Clone, Debug, Default)]
pub struct Ruptures {
    /// In the order found; broken in the world when the increment is committed.
    pub list: Vec<Rupture>,
    /// How many of these, the first ones, a motion left behind: an attempt that fails does not undo them.
    pub on_the_way: usize,
    /// Rounds of the cascade so far.
    pub rounds: u32,
    /// Whether the cap on these rounds was hit.
    pub capped: bool,
}

impl Ruptures {
    /// Drops what the last attempt found.
    pub fn forget_attempt(&mut self) {
        self.list.truncate(self.on_the_way);
        (self.rounds, self.capped) = (0, false);
    }
}

/// A trial of the search for the next event.
#[derive(Clone, Debug, PartialEq)]
pub struct EventTrial {
    /// Fraction of a whole increment.
    pub fraction: f64,
    /// Overload R of every bond, in the order of [`Bodies::bonds`](crate::contact::Bodies::bonds); at most 1 where it
    /// is within its limits.
    pub overloads: Vec<f64>,
    /// Change of the contact forces since the start of the increment, `sum|f - f_0| / sum|f|`.
    pub change: f64,
    /// Whether they are of a solution; those of the start of an increment follow from the forces that it begins with.
    pub is_solved: bool,
}

/// The search for the fraction of an increment at which the next bond reaches its limit.
#[derive(Resource, Clone, Debug, Default)]
pub struct EventSearch {
    /// Whether bonds break from event to event in this increment: then the trials are solved with bonds of
    /// unlimited strength.
    pub active: bool,
    /// The last trial whose maximum overload is below 1 - tolerance; at first the start of the increment.
    pub below: Option<EventTrial>,
    /// The last trial beyond the state that is sought.
    pub above: Option<EventTrial>,
    /// The fraction to try next.
    pub target: f64,
    /// Trials so far.
    pub trials: u32,
    /// Of these, how many have replaced `below` in a row, and how many `above`; one of the two is 0.
    pub in_a_row: [u32; 2],
    /// Bonds at their limit in the last trial: they break once it is committed.
    pub broken: Vec<Rupture>,
    /// Whether bodies have moved in this increment before the trial: its motion was followed.
    pub moved: bool,
    /// Maximum overload of the last trial.
    pub overload: f64,
    /// Whether the last trial is a state within an avalanche: bonds are above their limits in it.
    pub in_avalanche: bool,
}

/// How Coulomb's law is fulfilled by the last solution.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct Sliding {
    /// Maximum of the natural map of the contacts, without dimension; 0 with the associated law.
    pub natural_map: f64,
    /// Whether the residual of the solution is above the tolerance and at most [`BOUND`](Self::BOUND).
    pub capped: bool,
    /// Whether the residual of the solution is above the bound: the solution is rejected.
    pub lost: bool,
    /// Solves of this increment that did not converge.
    pub failures: u32,
}

impl Sliding {
    /// Maximum residual of a solution under Coulomb's law that is committed.
    pub const BOUND: f64 = 1e-4;
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

/// Normals, gaps and slips at the place that the last pass of the corrector led to.
#[derive(Resource, Clone, Debug, Default)]
pub struct Corrections {
    /// Sorted by pair.
    pub list: Vec<Correction>,
    /// Passes so far.
    pub passes: u32,
    /// What gaps and slips were off by in the last pass over the maximum displacement, or normals.
    pub residual: f64,
    /// Whether the cap on passes was hit.
    pub capped: bool,
}

impl Corrections {
    /// The correction of a pair, if it has one.
    #[must_use]
    pub fn of(&self, pair: (u32, u32)) -> Option<&Correction> {
        self.list.binary_search_by_key(&pair, |c| c.pair).ok().map(|k| &self.list[k])
    }

    /// What the corrector adds to the shear force that an interaction of the given tangential
    /// compliance (that of the program, m/N) starts from, N.
    #[must_use]
    pub fn shear_shift(&self, pair: (u32, u32), compliance: f64) -> f64 {
        match self.of(pair) {
            Some(c) if compliance > 0.0 => c.slip / compliance,
            _ => 0.0,
        }
    }
}

/// Displacements that push rigid overlaps apart, by body in its own axes. They move the bodies and give no
/// velocity. None until overlaps were found.
#[derive(Resource, Clone, Debug, Default)]
pub struct Pushed(pub Option<Vec<[f64; 3]>>);

/// An impact of two bodies that touch nothing else, where contacts have restitution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Index of the interaction in the program.
    pub interaction: usize,
    /// Time from the start of the trial to the impact, s.
    pub time: f64,
}

/// The impacts of the program that was assembled last.
#[derive(Resource, Clone, Debug, Default)]
pub struct Impacts {
    /// Of bodies that touch nothing else, in ascending order of the interactions.
    pub single: Vec<Impact>,
    /// Share of the velocity at the end in the displacement of bodies that carry contact forces: `1/(1 + e)`
    /// where bodies are hit that touch others, with the minimum e of these contacts, else 1.
    pub end_share: f64,
}

/// Whether a body that a rejected solution moved far carried load there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Bearing {
    /// It was not moved far.
    #[default]
    Unknown,
    /// It carried nothing: of all its motions its motion is to be the minimum.
    Nothing,
    /// It carried nothing at first, but once its motion was the minimum it was pushed: the load must
    /// find its support without that help.
    Load,
}

/// What keeps grains from being thrown.
#[derive(Resource, Clone, Debug, Default)]
pub struct Restraints {
    /// What rejected solutions say of the load of bodies; empty before one was rejected.
    pub bearing: Vec<Bearing>,
    /// Bodies that went far in a rejected solution: their taut bonds pull them back; empty before one was
    /// rejected.
    pub swinging: Vec<bool>,
    /// Attempts in a row that were made because of what was found here.
    pub replies: u32,
}

/// Centre of the regularisation where it follows the solution.
#[derive(Resource, Clone, Debug, Default)]
pub struct Centre {
    /// Displacements that the regularisation pulls to, by body in its own axes; empty: none.
    pub place: Vec<[f64; 3]>,
    /// Moves of the centre in this attempt.
    pub moves: u32,
}

/// A solution that did not converge.
#[derive(Clone, Debug, PartialEq)]
pub struct Unconverged {
    /// Its residuals.
    pub residuals: Residuals,
    /// Where the maximum residual is: which bodies, at which place.
    pub place: String,
    /// What the solver said of it.
    pub message: String,
}

/// Of all solutions of the increment that did not converge, the one that came closest.
#[derive(Resource, Clone, Debug, Default)]
pub struct Closest(pub Option<Unconverged>);
