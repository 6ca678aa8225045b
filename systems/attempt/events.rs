//! Judge: finds the next event. Between two ruptures the response is piecewise linear, so a few
//! trials with bonds of unlimited strength give the fraction at which the next bonds reach their
//! limits ([`event_search`](crate::event_search)).
//!
//! That state is committed before its ruptures. Bonds that hold are judged by their own limits. The
//! next increment has the fraction 0: its equilibrium at constant load shows whether other bonds
//! break as a consequence (an avalanche). The scene chooses what breaks then ([`Avalanche`]).
//! Either the most overloaded bond or all bonds above their limits break, repeatedly until all
//! bonds hold. Or the force of the broken bond is released gradually, and the same search finds the
//! part of the release at which the next bond reaches its limit
//! ([`gradual_release`](crate::gradual_release)). Or the motion to the next state at rest is
//! followed, from the equilibrium before the rupture.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::bond::Rupture;
use clastic_components::contact::{Bodies, BondRow, Contacts};
use clastic_components::findings::{Corrections, EventSearch, EventTrial};
use clastic_components::increment::{
    Analysis, AnalysisKind, Avalanche, Progress, RollingLimit, RuptureOrder, RuptureRules,
};
use clastic_components::material::Materials;
use clastic_components::release::Release;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::going_back::{self, Next};
use crate::event_search::{Decision, GroupRules, Now, at_constant_load, decide, maximum};
use crate::rupture_bonds::{
    BuiltInRule, Overload, UNLIMITED, overloads, overloads_at_start, restore_strengths, rupture,
};
use crate::rupture_brittleness::{Laws, between, brittleness};
use crate::rupture_density::{density, due};
use clastic_cone::residuals::residuals;

/// Run condition: bonds break from event to event.
pub fn searches(search: Res<EventSearch>) -> bool {
    search.active
}

/// Begins the search of an increment if bonds break from event to event.
pub fn begin(world: &mut World) {
    let bodies = world.resource::<Bodies>();
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
        && world.resource::<Analysis>().kind == AnalysisKind::Static
        && world.contains_resource::<BuiltInRule>()
        && !bodies.bonds.is_empty()
        && bodies.bonds.iter().all(is_elastic);
    let progress = world.resource::<Progress>();
    let dense = active && rules.avalanche != Avalanche::Dynamic && progress.dense;
    // Scenes have no loads with this option, and programs that embed the engine may have some.
    let returns =
        active && rules.snap_back && progress.relaxing && !super::run::carries_loads(world);
    *world.resource_mut::<EventSearch>() =
        EventSearch { active: active && !dense, dense, returns, ..EventSearch::default() };
}

/// Whether the motion that the last ruptures released must still be followed.
#[must_use]
pub fn is_released(rules: &RuptureRules, progress: &Progress, search: &EventSearch) -> bool {
    let follows = rules.order == RuptureOrder::Events && rules.avalanche == Avalanche::Dynamic;
    follows && search.active && progress.relaxing && !search.moved
}

/// What the judge reads.
#[derive(SystemParam)]
pub struct Tables<'w> {
    rules: Res<'w, RuptureRules>,
    bodies: Res<'w, Bodies>,
    contacts: Res<'w, Contacts>,
    materials: Res<'w, Materials>,
    analysis: Res<'w, Analysis>,
    corrections: Res<'w, Corrections>,
    release: Res<'w, Release>,
}

/// Accepts the trial, with the bonds that break in it, or requests another fraction.
pub fn judge(
    tables: Tables,
    mut progress: ResMut<Progress>,
    mut program: ResMut<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
    mut search: ResMut<EventSearch>,
    mut attempt: ResMut<Attempt>,
) {
    let rules = &*tables.rules;
    if rules.order != RuptureOrder::Events {
        return;
    }
    if is_released(rules, &progress, &search) {
        attempt.verdict = Verdict::Released;
        return;
    }
    let found = overloads(&tables.contacts.0, &program, &solution, UNLIMITED);
    let fraction = part_tried(&tables.release, &progress, &search);
    let trial = EventTrial {
        change: change(&program, &solution),
        is_solved: true,
        ..tables.trial(&found, fraction)
    };
    search.overload = maximum(&trial);
    // The corrector continues from the chosen state with its bonds.
    if tables.corrections.passes > 0 {
        judge_by_true_limits(&found, &mut program, &mut solution);
        return;
    }
    // A followed motion has left the path on which the imposed motion could go back.
    if search.returns && !search.moved {
        let broken = match going_back::next(rules, trial, &progress, &mut search) {
            Next::Stands(broken) => broken,
            Next::Try(fraction) => return try_next(fraction, &mut search, &mut attempt),
        };
        tables.commit(&found, &broken, &mut progress, &mut program, &mut solution, &mut search);
        return;
    }
    let shares = tables.shares(&found, &solution);
    let now = Now { trial: &trial, shares: &shares };
    let group = group_rules(rules);
    let below = search.below.clone().unwrap_or_else(|| tables.start(&program));
    // After a motion under the loads of this trial the fraction can no longer change.
    let decision = if search.moved {
        Decision::Stands(at_constant_load(now, group))
    } else if tables.may_break_together(&progress, &search)
        && tables.break_together(&below, &trial, &found, &program, &solution)
    {
        // The same fraction again, with the strengths of the bonds.
        (search.active, search.dense, progress.dense) = (false, true, true);
        search.target = progress.fraction;
        attempt.verdict = Verdict::Overloaded;
        return;
    } else {
        decide(&below, search.above.as_ref(), now, search.trials, search.in_a_row, group)
    };
    match decision {
        Decision::Stands(broken) => {
            tables.commit(&found, &broken, &mut progress, &mut program, &mut solution, &mut search);
        }
        Decision::Later(fraction) => {
            search.below = Some(trial);
            search.in_a_row = [search.in_a_row[0] + 1, 0];
            try_next(fraction, &mut search, &mut attempt);
        }
        Decision::Earlier(fraction) => {
            search.above = Some(trial);
            search.in_a_row = [0, search.in_a_row[1] + 1];
            try_next(fraction, &mut search, &mut attempt);
        }
    }
}

impl Tables<'_> {
    /// Index of the bond of an overload.
    fn bond(&self, o: &Overload) -> usize {
        bond(&self.contacts, o)
    }

    /// The overloads of all bonds at a fraction.
    fn trial(&self, found: &[Overload], fraction: f64) -> EventTrial {
        trial(&self.contacts, found, self.bodies.bonds.len(), fraction)
    }

    /// The start of the increment, by the forces after the last one.
    fn start(&self, program: &ConeProgram) -> EventTrial {
        self.trial(&overloads_at_start(&self.contacts.0, program, UNLIMITED), 0.0)
    }

    /// Force of each bond over the sum of all contact forces.
    fn shares(&self, found: &[Overload], solution: &ConeSolution) -> Vec<f64> {
        let sum = sum(&solution.forces).max(f64::MIN_POSITIVE);
        let mut shares = vec![0.0; self.bodies.bonds.len()];
        for o in found {
            let f = &solution.forces[o.contact];
            shares[self.bond(o)] = f[0].hypot(f[1]) / sum;
        }
        shares
    }

    /// Whether this is the first trial of a loading with which bonds may break together.
    fn may_break_together(&self, progress: &Progress, search: &EventSearch) -> bool {
        search.trials == 0
            && search.overload >= 1.0
            && progress.fraction > 0.0
            && self.rules.avalanche != Avalanche::Dynamic
            && !self.rules.snap_back
    }

    /// Whether the bonds that reach their limits are so dense, or release so little force, that
    /// they break together.
    fn break_together(
        &self,
        below: &EventTrial,
        trial: &EventTrial,
        found: &[Overload],
        program: &ConeProgram,
        solution: &ConeSolution,
    ) -> bool {
        if density(below, trial) >= self.rules.density {
            return true;
        }
        // The forces at the first crossing.
        let (first, due) = due(below, trial);
        let due = found.iter().filter(|o| due.contains(&self.bond(o)));
        let due: Vec<usize> = due.map(|o| o.contact).collect();
        let part = (first / trial.fraction).min(1.0);
        let forces = between(&program.last_forces, &solution.forces, part);
        let Self { bodies, materials, analysis, .. } = self;
        let laws = Laws { bodies, materials, analysis };
        brittleness(&due, &self.contacts.0, &forces, laws) <= self.rules.brittleness
    }

    /// Commits the trial, in which these bonds break.
    fn commit(
        &self,
        found: &[Overload],
        broken: &[usize],
        progress: &mut Progress,
        program: &mut ConeProgram,
        solution: &mut ConeSolution,
        search: &mut EventSearch,
    ) {
        search.broken = self.ruptures(found, broken, progress.increment, solution);
        // All bonds of a group break at one state, some of them a little late.
        let is_late = |o: &Overload| o.value > 1.0 && !broken.contains(&self.bond(o));
        search.in_avalanche = search.kept > 0.0
            || !broken.is_empty()
                && (progress.fraction == 0.0 || search.moved || found.iter().any(is_late));
        if !search.broken.is_empty() && progress.fraction > 0.0 {
            // The distance to the next event is estimated from the last distances.
            progress.tried = 0.5 * (REACH * progress.fraction).max(FORGET * progress.tried);
        }
        judge_by_true_limits(found, program, solution);
    }

    /// The ruptures of these bonds.
    fn ruptures(
        &self,
        found: &[Overload],
        broken: &[usize],
        increment: u64,
        solution: &ConeSolution,
    ) -> Vec<Rupture> {
        let breaking = found.iter().filter(|o| broken.contains(&self.bond(o)));
        let rupture = |o: &Overload| {
            let (contact, forces) = (&self.contacts.0[o.contact], &solution.forces[o.contact]);
            rupture(increment, &self.bodies, contact, forces, o.mode)
        };
        breaking.filter_map(rupture).collect()
    }
}

/// Index of the bond of an overload.
fn bond(contacts: &Contacts, o: &Overload) -> usize {
    contacts.0[o.contact].bond.map_or(0, |k| k as usize)
}

/// The overloads of `bonds` bonds at a fraction.
fn trial(contacts: &Contacts, found: &[Overload], bonds: usize, fraction: f64) -> EventTrial {
    let mut overloads = vec![0.0; bonds];
    for o in found {
        overloads[bond(contacts, o)] = o.value;
    }
    EventTrial { fraction, overloads, change: 0.0, is_solved: false }
}

/// The trial of the last solution, which [`judge`] has not seen.
pub(super) fn trial_of(world: &World) -> EventTrial {
    let contacts = world.resource::<Contacts>();
    let found = overloads(&contacts.0, world.resource(), world.resource(), UNLIMITED);
    let bonds = world.resource::<Bodies>().bonds.len();
    trial(contacts, &found, bonds, world.resource::<Progress>().fraction)
}

fn group_rules(rules: &RuptureRules) -> GroupRules {
    let &RuptureRules { tolerance, group, avalanche, .. } = rules;
    let share = if avalanche == Avalanche::Together { f64::INFINITY } else { group };
    GroupRules { tolerance, group, share }
}

/// Whether the increment releases forces of broken bonds instead of loading.
#[must_use]
pub fn releases(release: &Release, search: &EventSearch) -> bool {
    search.active && !release.forces.is_empty()
}

/// Fraction of the increment that the trial solves, or the part of the release.
#[must_use]
pub fn part_tried(release: &Release, progress: &Progress, search: &EventSearch) -> f64 {
    if releases(release, search) { 1.0 - search.kept } else { progress.fraction }
}

/// Sets the fraction of the increment, or the part of the release, of the next trial.
pub fn set_part(world: &mut World, part: f64) {
    if releases(world.resource(), world.resource()) {
        world.resource_mut::<EventSearch>().kept = 1.0 - part;
    } else {
        world.resource_mut::<Progress>().fraction = part;
    }
}

/// Halves the fraction of the increment, or the part of the release, and begins its search anew.
pub fn halve(world: &mut World) {
    let (release, progress) = (world.resource::<Release>(), world.resource::<Progress>());
    let search = world.resource::<EventSearch>();
    let half = 0.5 * part_tried(release, progress, search);
    let releases = releases(release, search);
    // An increment that fell back to one round stays in this mode.
    let (active, dense) = (search.active, search.dense);
    *world.resource_mut::<EventSearch>() = EventSearch { active, dense, ..Default::default() };
    set_part(world, half);
    if !releases {
        world.resource_mut::<Progress>().tried = half;
    }
}

/// Fraction of a whole increment that is tried, or the part of a whole release.
#[must_use]
pub fn part_of_whole(world: &World) -> f64 {
    let (release, progress) = (world.resource::<Release>(), world.resource::<Progress>());
    let search = world.resource::<EventSearch>();
    let whole = if releases(release, search) { release.left } else { 1.0 };
    whole * part_tried(release, progress, search)
}

/// Restores the strengths of the bonds, and judges the residuals by them.
fn judge_by_true_limits(
    found: &[Overload],
    program: &mut ConeProgram,
    solution: &mut ConeSolution,
) {
    restore_strengths(found, &mut program.interactions);
    solution.residuals = residuals(program, &solution.forces, &solution.displacements);
}

fn try_next(fraction: f64, search: &mut EventSearch, attempt: &mut Attempt) {
    search.trials += 1;
    search.target = fraction;
    attempt.verdict = Verdict::Overloaded;
}

/// Minimum distance of the first trial after an event, over the distance to that event. Fractions
/// double from one increment to the next, so half of it is stored.
const REACH: f64 = 4.0;
/// Minimum distance of the first trial after an event, over the first trial before that event.
const FORGET: f64 = 0.5;

/// Sum of normal and shear forces.
fn sum(forces: &[[f64; 3]]) -> f64 {
    forces.iter().map(|f| f[0].hypot(f[1])).sum()
}

/// Relative change of the normal and shear forces since the start of the increment,
/// `sum|f - f_0| / sum|f|`.
#[must_use]
pub fn change(program: &ConeProgram, solution: &ConeSolution) -> f64 {
    let changes = solution.forces.iter().zip(&program.last_forces);
    let changed: f64 = changes.map(|(f, last)| (f[0] - last[0]).hypot(f[1] - last[1])).sum();
    changed / sum(&solution.forces).max(f64::MIN_POSITIVE)
}
