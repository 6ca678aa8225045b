//! Judge: finds the next event. Between two ruptures the response is piecewise linear, so a few
//! trials with bonds of unlimited strength give the fraction at which the next bonds reach their
//! limits ([`event_search`](crate::rupture::event_search)).
//!
//! That state is committed before its rupture. Bonds that hold are judged by their own limits. The
//! next increment has the fraction 0: its equilibrium at constant load shows whether other bonds
//! break as a consequence (an avalanche). The scene chooses what breaks then ([`Avalanche`]). Either
//! the most overloaded bond breaks, repeatedly until all bonds hold. Or the motion to the next state
//! at rest is followed, from the equilibrium before the rupture.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::bonds::{
    BuiltInRule, Overload, UNLIMITED, overloads, overloads_at_start, restore_strengths, rupture,
};
use super::brittleness::{between, brittleness};
use super::density::{density, due};
use super::event_search::{Decision, at_constant_load, decide, maximum};
use crate::contact_laws::Laws;
use crate::solved::Solved;
use clastic_cone::residuals::residuals;

/// Run condition: bonds break from event to event.
pub fn searches(search: Res<EventSearch>) -> bool {
    search.active
}

/// Begins the search of an increment if bonds break from event to event.
pub fn begin(world: &mut World) {
    let bodies = world.resource::<BodyTable>();
    let rules = world.resource::<RuptureRules>();
    // The overload has no term of the rolling moment: no search finds where one breaks the bond.
    let is_elastic = |bond: &BondRow| {
        let law = &bond.law;
        law.normal_compliance > 0.0
            && law.tangential_compliance > 0.0
            && law.cohesion > 0.0
            && law.tensile_strength > 0.0
            && (rules.rolling == RollingLimit::Yields || law.rolling_friction == 0.0)
    };
    let active = rules.order == RuptureOrder::Events
        && world.resource::<ClasticAnalysis>().kind == AnalysisKind::Static
        && world.contains_resource::<BuiltInRule>()
        && !bodies.bonds.is_empty()
        && bodies.bonds.iter().all(is_elastic);
    let is_dense = world.resource::<ClasticProgress>().dense;
    let dense = active && rules.avalanche != Avalanche::Dynamic && is_dense;
    *world.resource_mut::<EventSearch>() =
        EventSearch { active: active && !dense, dense, ..EventSearch::default() };
}

/// Whether the motion that the last ruptures released must still be followed.
pub fn is_released(rules: &RuptureRules, progress: &ClasticProgress, search: &EventSearch) -> bool {
    let follows = search.active && rules.avalanche == Avalanche::Dynamic;
    follows && progress.relaxing && !search.moved
}

/// What the judge reads, and what it changes besides the verdict.
#[derive(SystemParam)]
pub struct Tables<'w> {
    rules: Res<'w, RuptureRules>,
    bodies: Res<'w, BodyTable>,
    contacts: Res<'w, ContactTable>,
    materials: Res<'w, Materials>,
    analysis: Res<'w, ClasticAnalysis>,
    corrections: Res<'w, Corrections>,
    progress: ResMut<'w, ClasticProgress>,
    program: ResMut<'w, ConeProgram>,
    solution: ResMut<'w, ConeSolution>,
    search: ResMut<'w, EventSearch>,
}

/// Accepts the trial, with the bond that breaks in it, or requests another fraction.
pub fn judge(mut tables: Tables, mut attempt: ResMut<Attempt>) {
    if is_released(&tables.rules, &tables.progress, &tables.search) {
        attempt.verdict = Verdict::Released;
        return;
    }
    let found = overloads(tables.solved(), UNLIMITED);
    let trial = EventTrial {
        change: change(&tables.program, &tables.solution),
        is_solved: true,
        ..tables.trial(&found, tables.progress.fraction)
    };
    tables.search.overload = maximum(&trial);
    // The next pass continues from the chosen state with its bonds.
    if tables.corrections.passes > 0 {
        return tables.judge_by_true_limits(&found);
    }
    // The start of the increment, by the forces after the last one.
    let start = || tables.trial(&overloads_at_start(tables.solved(), UNLIMITED), 0.0);
    let below = tables.search.below.clone().unwrap_or_else(start);
    let tolerance = tables.rules.tolerance;
    // After a motion under the loads of this trial the fraction can no longer change.
    let decision = if tables.search.moved {
        Decision::Stands(at_constant_load(&trial, tolerance))
    } else if tables.may_break_together() && tables.break_together(&below, &trial, &found) {
        // The same fraction again, with the strengths of the bonds.
        let Tables { progress, search, .. } = &mut tables;
        (search.active, search.dense, progress.dense) = (false, true, true);
        search.target = progress.fraction;
        attempt.verdict = Verdict::Overloaded;
        return;
    } else {
        let EventSearch { above, trials, in_a_row, .. } = &*tables.search;
        decide(&below, above.as_ref(), &trial, *trials, *in_a_row, tolerance)
    };
    let search = &mut *tables.search;
    search.target = match decision {
        Decision::Stands(broken) => return tables.commit(&found, broken),
        Decision::Later(fraction) => {
            search.below = Some(trial);
            search.in_a_row = [search.in_a_row[0] + 1, 0];
            fraction
        }
        Decision::Earlier(fraction) => {
            search.above = Some(trial);
            search.in_a_row = [0, search.in_a_row[1] + 1];
            fraction
        }
    };
    search.trials += 1;
    attempt.verdict = Verdict::Overloaded;
}

impl Tables<'_> {
    fn solved(&self) -> Solved<'_> {
        let Self { bodies, contacts, program, solution, .. } = self;
        Solved { bodies, contacts, program, solution }
    }

    /// Index of the bond of an overload.
    fn bond(&self, o: &Overload) -> usize {
        self.contacts.0[o.contact].bond.map_or(0, |k| k as usize)
    }

    /// The overloads of all bonds at a fraction.
    fn trial(&self, found: &[Overload], fraction: f64) -> EventTrial {
        let mut overloads = vec![0.0; self.bodies.bonds.len()];
        for o in found {
            overloads[self.bond(o)] = o.value;
        }
        EventTrial { fraction, overloads, change: 0.0, is_solved: false }
    }

    /// Whether this is the first trial of a loading with which bonds may break together.
    fn may_break_together(&self) -> bool {
        self.search.trials == 0
            && self.search.overload >= 1.0
            && self.progress.fraction > 0.0
            && self.rules.avalanche != Avalanche::Dynamic
    }

    /// Whether the bonds that reach their limits are so dense, or release so little force, that
    /// they break together.
    fn break_together(&self, below: &EventTrial, trial: &EventTrial, found: &[Overload]) -> bool {
        if density(below, trial) >= self.rules.density {
            return true;
        }
        // The forces at the first crossing.
        let (first, due) = due(below, trial);
        let due = found.iter().filter(|o| due.contains(&self.bond(o)));
        let due: Vec<usize> = due.map(|o| o.contact).collect();
        let part = (first / trial.fraction).min(1.0);
        let forces = between(&self.program.last_forces, &self.solution.forces, part);
        let Self { bodies, materials, analysis, .. } = self;
        let laws = Laws { bodies, materials, analysis };
        brittleness(&due, &self.contacts.0, &forces, laws) <= self.rules.brittleness
    }

    /// Commits the trial, in which this bond breaks, if there is one.
    fn commit(&mut self, found: &[Overload], broken: Option<usize>) {
        let breaks = |o: &&Overload| Some(self.bond(o)) == broken;
        let event = found.iter().find(breaks).and_then(|o| {
            let (contact, forces) = (&self.contacts.0[o.contact], &self.solution.forces[o.contact]);
            rupture(self.progress.increment, &self.bodies, contact, forces, o.mode)
        });
        let is_late = found.iter().any(|o| o.value > 1.0 && !breaks(&o));
        let Self { progress, search, .. } = self;
        search.in_avalanche =
            broken.is_some() && (progress.fraction == 0.0 || search.moved || is_late);
        if event.is_some() && progress.fraction > 0.0 {
            // The distance to the next event is estimated from the last distances.
            progress.tried = 0.5 * (REACH * progress.fraction).max(FORGET * progress.tried);
        }
        search.broken = event;
        self.judge_by_true_limits(found);
    }

    /// Restores the strengths of the bonds, and judges the residuals by them.
    fn judge_by_true_limits(&mut self, found: &[Overload]) {
        restore_strengths(found, &mut self.program.interactions);
        self.solution.residuals = residuals(&self.program, &self.solution);
    }
}

/// Halves the fraction of the increment, and begins its search anew.
pub fn halve(world: &mut World) {
    let search = world.resource::<EventSearch>();
    // An increment that fell back to one round stays in this mode.
    let (active, dense) = (search.active, search.dense);
    *world.resource_mut::<EventSearch>() = EventSearch { active, dense, ..Default::default() };
    let mut progress = world.resource_mut::<ClasticProgress>();
    progress.fraction *= 0.5;
    progress.tried = progress.fraction;
}

/// Minimum distance of the first trial after an event, over the distance to that event. Fractions
/// double from one increment to the next, so half of it is stored.
const REACH: f64 = 4.0;
/// Minimum distance of the first trial after an event, over the first trial before that event.
const FORGET: f64 = 0.5;

/// Relative change of the normal and shear forces since the start of the increment,
/// `sum|f - f_0| / sum|f|`.
pub fn change(program: &ConeProgram, solution: &ConeSolution) -> f64 {
    let changes = solution.forces.iter().zip(&program.last_forces);
    let changed: f64 = changes.map(|(f, last)| (f[0] - last[0]).hypot(f[1] - last[1])).sum();
    let sum: f64 = solution.forces.iter().map(|f| f[0].hypot(f[1])).sum();
    changed / sum.max(f64::MIN_POSITIVE)
}
