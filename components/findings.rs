//! What the judges have found in the current increment. Judges write these tables, and assembly
//! reads them. All are cleared when the next increment begins.

use bevy_ecs::prelude::*;
use glam::DVec2;

use crate::bond::Rupture;
use crate::contact::Contact;
use crate::increment::Acceptance;
use clastic_cone::program::Residuals;

/// Sorted pairs that pruned detection left out and that a solution closed.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct AddedPairs(pub Vec<(u32, u32)>);

/// Bonds that the increment breaks.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Ruptures {
    /// Ruptures in the order found. The world breaks these bonds when the increment is committed.
    pub list: Vec<Rupture>,
    /// Number of ruptures, from the first on, that followed motions caused. A failed attempt does
    /// not undo them.
    pub on_the_way: usize,
}

/// A trial of the search for the next event.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct EventTrial {
    /// Fraction of a whole increment.
    pub fraction: f64,
    /// Overload R of every bond, in the order of
    /// [`BodyTable::bonds`](crate::contact::BodyTable::bonds). R is at most 1 for a bond within its
    /// limits.
    pub overloads: Vec<f64>,
    /// Change of the contact forces since the start of the increment, `sum|f - f_0| / sum|f|`.
    pub change: f64,
    /// Whether the overloads come from a solution. Those at the start of an increment come from the
    /// initial forces.
    pub is_solved: bool,
}

/// The search for the fraction of an increment at which the next bond reaches its limit.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct EventSearch {
    /// Whether bonds break from event to event in this increment. Trials are then solved with bonds
    /// of unlimited strength.
    pub active: bool,
    /// Whether many bonds reach their limits soon after each other, so that the increment breaks
    /// them together at its end. Trials are then solved with the strengths of the bonds.
    pub dense: bool,
    /// With `dense`: share of the ruptures of bonds that were on a limit, which the increment
    /// before did not expect.
    pub late: f64,
    /// With `dense`: whether the next increment seeks the equilibrium at constant load.
    pub settles: bool,
    /// The last trial whose maximum overload is below 1 - tolerance. Initially it is the start of
    /// the increment.
    pub below: Option<EventTrial>,
    /// The last trial beyond the event.
    pub above: Option<EventTrial>,
    /// The fraction to try next.
    pub target: f64,
    /// Number of trials so far.
    pub trials: u32,
    /// Number of consecutive last trials that replaced `below`, and that replaced `above`. One of
    /// the two is 0.
    pub in_a_row: [u32; 2],
    /// The bond at its limit in the last trial. It breaks when the trial is committed.
    pub broken: Option<Rupture>,
    /// Whether a followed motion has moved bodies in this increment before the trial.
    pub moved: bool,
    /// Maximum overload of the last trial.
    pub overload: f64,
    /// Whether the last trial is a state within an avalanche, in which bonds are above their
    /// limits.
    pub in_avalanche: bool,
}

/// How well the last solution satisfies Coulomb's law.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Sliding {
    /// Maximum of the natural map of the contacts, without dimension; 0 with the associated law.
    pub natural_map: f64,
    /// Whether the residual of the solution is above the tolerance and at most
    /// [`BOUND`](Self::BOUND).
    pub capped: bool,
    /// Whether the residual of the solution is above the bound, so that the solution is rejected.
    pub lost: bool,
    /// Number of solves in this increment that did not converge.
    pub failures: u32,
    /// Minimum residual of the equilibria of this increment that Coulomb's law has rejected, if it has
    /// rejected any.
    pub rejected: Option<f64>,
}

impl Sliding {
    /// Maximum residual at which a solution under Coulomb's law is committed, unless the scene accepts
    /// a greater one.
    pub const BOUND: f64 = 1e-4;

    /// The bound of a scene: [`BOUND`](Self::BOUND), or the residual that it accepts if that is greater.
    pub fn bound(acceptance: &Acceptance) -> f64 {
        acceptance.residual.max(Self::BOUND)
    }
}

/// Geometry of a pair of bodies about a guess of the end of the increment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Correction {
    /// The pair.
    pub pair: (u32, u32),
    /// Normal from a to b.
    pub normal: DVec2,
    /// Gap in the geometry of the normal, m. The arms end in the middle of this gap.
    pub gap: f64,
    /// Offset that replaces the initial gap, m. The offset minus the closing is the gap at the end.
    pub offset: f64,
    /// Slip minus its linear expression, m.
    pub slip: f64,
    /// Motion across the normal at the guess, m, at which a tie of the pair has no force.
    pub tie: f64,
    /// Tension of the pair in the solution that led to the guess, N; negative in compression.
    pub tension: f64,
    /// Gap, m, by which an elastic contact is further apart in a time step than on the line from its gap
    /// at the start to that at the end, measured by the mean force: it closes, opens or turns.
    pub lag: f64,
}

/// The geometry about a guess of the end of the increment, for [passes](Self::passes), and how far
/// from that end the last solution is.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Corrections {
    /// Geometry of the program, sorted by pair; empty before the first pass.
    pub list: Vec<Correction>,
    /// Number of passes so far.
    pub passes: u32,
    /// Maximum out-of-balance force where the increment ends, over the maximum force.
    pub imbalance: f64,
    /// Motion that solving the increment again about its own end would add, over the motion of the
    /// increment. `None` where contacts slide.
    pub idle_motion: Option<f64>,
    /// Whether the increment needs passes: with the geometry of its start it ends elsewhere, or loses
    /// or gains energy.
    pub needed: bool,
    /// Whether the passes ended without agreement.
    pub capped: bool,
    /// The guesses of the end so far.
    pub guesses: Guesses,
}

/// The last guesses of the displacements of an increment, and what the solutions about them missed.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Guesses {
    /// The last guess, m and rad, by body in its own axes; empty before the first pass.
    pub last: Vec<[f64; 3]>,
    /// Solution less guess of the last pass; empty before the second pass.
    pub missed: Vec<[f64; 3]>,
    /// Changes of guess and miss from pass to pass, the latest last.
    pub changes: Vec<[Vec<[f64; 3]>; 2]>,
    /// Smallest error of a pass; `None` before the first one.
    pub best: Option<f64>,
    /// Number of passes since the error has fallen.
    pub stalled: u32,
}

impl Guesses {
    /// Records the error of a pass. Returns whether passes still reduce it: at most `max` in a row
    /// have left more than the part `progress` of the smallest.
    pub fn makes_way(&mut self, error: f64, progress: f64, max: u32) -> bool {
        let best = self.best.unwrap_or(f64::INFINITY);
        self.stalled = if error < progress * best { 0 } else { self.stalled + 1 };
        self.best = Some(best.min(error));
        self.stalled <= max
    }

    /// Forgets the errors so far, because the passes that follow start from other positions.
    pub fn begin_anew(&mut self) {
        (self.best, self.stalled) = (None, 0);
    }
}

impl Corrections {
    /// The correction of a pair, if it has one.
    pub fn of(&self, pair: (u32, u32)) -> Option<&Correction> {
        self.list.binary_search_by_key(&pair, |c| c.pair).ok().map(|k| &self.list[k])
    }

    /// What the corrections add to the offset of a contact, m: by the geometry about the end, and the
    /// [lag](Correction::lag).
    pub fn shift(&self, contact: &Contact) -> [f64; 2] {
        let of = self.of((contact.a, contact.b));
        of.map_or([0.0; 2], |c| [c.offset - contact.gap, c.lag])
    }

    /// Force that the geometry about the end adds to the initial shear force of an interaction, N. `compliance`
    /// is the tangential compliance in the program, m/N.
    pub fn shear_shift(&self, pair: (u32, u32), compliance: f64) -> f64 {
        match self.of(pair) {
            Some(c) if compliance > 0.0 => c.slip / compliance,
            _ => 0.0,
        }
    }
}

/// Displacements that separate rigid overlaps, by body in the axes of the body. They move the
/// bodies and give no velocity. `None` before overlaps are found.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Pushed(pub Option<Vec<[f64; 3]>>);

/// An impact of two bodies that touch no other body, for contacts with restitution.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Impact {
    /// Index of the interaction in the program.
    pub interaction: usize,
    /// Time from the start of the trial to the impact, s.
    pub time: f64,
}

/// Impacts of the last assembled program.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Impacts {
    /// Impacts of bodies that touch no other body, in ascending order of the interactions.
    pub single: Vec<Impact>,
    /// Interactions with an impact, `single` ones included, in ascending order.
    pub hit: Vec<usize>,
    /// Weight of the end velocity in the displacement of bodies that carry contact forces. It is
    /// `1/(1 + e)`, with e the minimum of the contacts in question, if a body is hit that touches
    /// others, otherwise 1.
    pub end_share: f64,
}

/// What impacts of the trial cause beyond themselves.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Reached {
    /// Pairs that another impact sends against each other, sorted, and the speed, m/s, with which
    /// they close.
    pub pairs: Vec<((u32, u32), f64)>,
    /// Factor of the restitution by body; empty: 1.
    pub factors: Vec<f64>,
}

impl Reached {
    /// The closing speed of a pair, m/s, if it is reached.
    pub fn speed(&self, pair: (u32, u32)) -> Option<f64> {
        self.pairs.binary_search_by_key(&pair, |(pair, _)| *pair).ok().map(|k| self.pairs[k].1)
    }

    /// Factor of the restitution of a pair.
    pub fn factor(&self, (a, b): (u32, u32)) -> f64 {
        let of = |body: u32| self.factors.get(body as usize).copied().unwrap_or(1.0);
        of(a).min(of(b))
    }
}

/// Whether a body that a rejected solution moved far carried load.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Bearing {
    /// No rejected solution moved the body far.
    #[default]
    Unknown,
    /// The body carried nothing. The regularisation gives it the smallest possible motion.
    Nothing,
    /// The body carried nothing at first, but was pushed once it was regularised. The load must
    /// find its support without regularisation.
    Load,
}

/// Centre of the regularisation if it follows the solution.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Centre {
    /// Displacements towards which the regularisation pulls, by body in the axes of the body. Empty
    /// means zero.
    pub place: Vec<[f64; 3]>,
    /// Number of moves of the centre in this attempt.
    pub moves: u32,
}

/// A solution that did not converge.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Unconverged {
    /// Residuals of the solution.
    pub residuals: Residuals,
    /// Bodies and place of the maximum residual.
    pub place: String,
    /// Message of the solver.
    pub message: String,
}
