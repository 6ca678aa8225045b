//! Judge: finds the next event. Between two ruptures the response is piecewise linear, so a few
//! trials with bonds of unlimited strength give the fraction at which the next bonds reach their
//! limits ([`event_search`](crate::event_search)).
//!
//! That state is committed before its ruptures. Bonds that hold are judged by their own limits. The
//! next increment has the fraction 0: its equilibrium at constant load shows whether other bonds
//! break as a consequence (an avalanche). The scene chooses what breaks then ([`Avalanche`]).
//! Either the most overloaded bond or all bonds above their limits break, repeatedly until all
//! bonds hold. Or the motion to the next state at rest is followed, from the equilibrium before the
//! rupture.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, BondRow, Contacts};
use clastic_components::findings::{Corrections, EventSearch, EventTrial};
use clastic_components::increment::{
    Analysis, AnalysisKind, Avalanche, Progress, RollingLimit, RuptureOrder, RuptureRules,
};
use clastic_components::material::Materials;
use clastic_cone::program::{ConeProgram, ConeSolution};

use crate::event_search::{Decision, GroupRules, Now, at_constant_load, decide, maximum};
use crate::rupture_bonds::{
    BuiltInRule, Overload, UNLIMITED, overloads, restore_strengths, rupture,
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
    let dense =
        active && rules.avalanche != Avalanche::Dynamic && world.resource::<Progress>().dense;
    *world.resource_mut::<EventSearch>() =
        EventSearch { active: active && !dense, dense, ..EventSearch::default() };
}

/// Whether the motion that the last ruptures released must still be followed.
#[must_use]
pub fn is_released(rules: &RuptureRules, progress: &Progress, search: &EventSearch) -> bool {
    let follows = rules.order == RuptureOrder::Events && rules.avalanche == Avalanche::Dynamic;
    follows && search.active && progress.relaxing && !search.moved
}

/// Accepts the trial, with the bonds that break in it, or requests another fraction.
pub fn judge(
    rules: Res<RuptureRules>,
    mut progress: ResMut<Progress>,
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    mut program: ResMut<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
    mut search: ResMut<EventSearch>,
    corrections: Res<Corrections>,
    laws: (Res<Materials>, Res<Analysis>),
    mut attempt: ResMut<Attempt>,
) {
    let RuptureRules { order, tolerance, group, avalanche, .. } = *rules;
    if order != RuptureOrder::Events {
        return;
    }
    if is_released(&rules, &progress, &search) {
        attempt.verdict = Verdict::Released;
        return;
    }
    let share = if avalanche == Avalanche::Together { f64::INFINITY } else { group };
    let group = GroupRules { tolerance, group, share };
    let found = overloads(&contacts.0, &program, &solution, UNLIMITED);
    let bond = |o: &Overload| contacts.0[o.contact].bond.map_or(0, |k| k as usize);
    let sum = sum(&solution.forces).max(f64::MIN_POSITIVE);
    let mut shares = vec![0.0; bodies.bonds.len()];
    for o in &found {
        let f = &solution.forces[o.contact];
        shares[bond(o)] = f[0].hypot(f[1]) / sum;
    }
    let change = change(&program, &solution);
    let of_bonds = |found: &[Overload], fraction| {
        let mut overloads = vec![0.0; bodies.bonds.len()];
        for o in found {
            overloads[bond(o)] = o.value;
        }
        EventTrial { fraction, overloads, change, is_solved: true }
    };
    let trial = of_bonds(&found, progress.fraction);
    search.overload = maximum(&trial);
    // The corrector continues from the chosen state with its bonds.
    if corrections.passes > 0 {
        restore_strengths(&found, &mut program.interactions);
        solution.residuals = residuals(&program, &solution.forces, &solution.displacements);
        return;
    }
    let now = Now { trial: &trial, shares: &shares };
    // After a motion under the loads of this trial the fraction can no longer change.
    let decision = if search.moved {
        Decision::Stands(at_constant_load(now, group))
    } else {
        let start = || {
            let forces = program.interactions.iter().enumerate();
            let last = |k: usize| program.last_forces.get(k).copied().unwrap_or_default();
            let forces = forces.map(|(k, _)| last(k)).collect();
            let start = ConeSolution { forces, ..ConeSolution::default() };
            let found = overloads(&contacts.0, &program, &start, UNLIMITED);
            EventTrial { change: 0.0, is_solved: false, ..of_bonds(&found, 0.0) }
        };
        let below = search.below.clone().unwrap_or_else(start);
        let may_be_dense = search.trials == 0
            && search.overload >= 1.0
            && progress.fraction > 0.0
            && avalanche != Avalanche::Dynamic;
        let is_mild = || {
            // The forces at the first crossing.
            let (first, due) = due(&below, &trial);
            let due: Vec<usize> =
                found.iter().filter(|o| due.contains(&bond(o))).map(|o| o.contact).collect();
            let part = (first / progress.fraction).min(1.0);
            let forces = between(&program.last_forces, &solution.forces, part);
            let (materials, analysis) = (&*laws.0, &*laws.1);
            let laws = Laws { bodies: &bodies, materials, analysis };
            brittleness(&due, &contacts.0, &forces, laws) <= rules.brittleness
        };
        if may_be_dense && (density(&below, &trial) >= rules.density || is_mild()) {
            // The same fraction again, with the strengths of the bonds.
            (search.active, search.dense, progress.dense) = (false, true, true);
            search.target = progress.fraction;
            attempt.verdict = Verdict::Overloaded;
            return;
        }
        decide(&below, search.above.as_ref(), now, search.trials, search.in_a_row, group)
    };
    match decision {
        Decision::Stands(broken) => {
            let at = found.iter().filter(|o| broken.contains(&bond(o)));
            let at = at.filter_map(|o| {
                let (contact, forces) = (&contacts.0[o.contact], &solution.forces[o.contact]);
                rupture(progress.increment, &bodies, contact, forces, o.mode)
            });
            search.broken = at.collect();
            // All bonds of a group break at one state, some of them a little late.
            let is_left = |o: &Overload| o.value > 1.0 && !broken.contains(&bond(o));
            search.in_avalanche = !broken.is_empty()
                && (progress.fraction == 0.0 || search.moved || found.iter().any(is_left));
            if !search.broken.is_empty() && progress.fraction > 0.0 {
                // The distance to the next event is estimated from the last distances.
                progress.tried = 0.5 * (REACH * progress.fraction).max(FORGET * progress.tried);
            }
            restore_strengths(&found, &mut program.interactions);
            solution.residuals = residuals(&program, &solution.forces, &solution.displacements);
        }
        Decision::Later(fraction) | Decision::Earlier(fraction) => {
            if matches!(decision, Decision::Later(_)) {
                search.below = Some(trial);
                search.in_a_row = [search.in_a_row[0] + 1, 0];
            } else {
                search.above = Some(trial);
                search.in_a_row = [0, search.in_a_row[1] + 1];
            }
            search.trials += 1;
            search.target = fraction;
            attempt.verdict = Verdict::Overloaded;
        }
    }
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
