//! Judge: breaks bonds together where many reach their limits soon after each other, or where their
//! ruptures release little force.
//!
//! One by one, these ruptures would need several solves each. Where the
//! [density](crate::rupture::density::density) of ruptures is above [`RuptureRules::density`], or
//! their [brittleness] is at most [`RuptureRules::brittleness`], an increment is solved with the
//! strengths of its bonds, as with `OneRound`. At its end three sets of bonds break:
//!
//! - bonds on a limit: they carry load in the committed state although they should be broken;
//! - bonds that the next increment would bring to their limits, by the rate of their overloads in
//!   this increment;
//! - of the bonds that come next, as many as were on a limit: they are broken in the next state
//!   although they should carry load.
//!
//! About as many bonds therefore break early as late, and the first-order error cancels. If more
//! than the share `MAX_SHARE` of the bonds would break, the increment is shortened. Bonds break one
//! by one again after an increment that would break at most one, unless that rupture releases
//! little force.
//!
//! The rate does not predict the next stage: at the end of a stage no bond breaks early. Increments
//! of fraction 0 follow there until none of them breaks a bond ([`is_unsettled`]). In the first of
//! them, contacts that have slid close again, and further bonds may reach their limits.

use std::collections::HashSet;

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use super::bonds::{Met, find_ruptures, overloads, overloads_at_start, rupture};
use super::brittleness::brittleness;
use super::density::distance;
use crate::contact_laws::Laws;
use crate::solved::{Solved, SolvedTables};

/// Maximum share of the intact bonds that an increment breaks.
const MAX_SHARE: f64 = 0.04;
/// Factor by which the share may exceed [`MAX_SHARE`], so that few solves are rejected.
const MARGIN: f64 = 1.25;

/// Run condition: bonds break together.
pub(crate) fn is_dense(search: Res<EventSearch>) -> bool {
    search.dense
}

/// Whether the increment has broken bonds together, so that the equilibrium at constant load
/// without these bonds is not yet known. A stage must not end in such a state, because the next
/// stage may load in another way.
pub fn is_unsettled(search: &EventSearch, ruptures: &Ruptures, progress: &ClasticProgress) -> bool {
    search.dense && (progress.fraction > 0.0 || ruptures.list.len() > ruptures.on_the_way)
}

/// Collects the bonds that break, or requests a shorter increment.
pub fn judge(
    rules: Res<RuptureRules>,
    mut progress: ResMut<ClasticProgress>,
    tables: SolvedTables,
    mut ruptures: ResMut<Ruptures>,
    mut search: ResMut<EventSearch>,
    (materials, analysis): (Res<Materials>, Res<ClasticAnalysis>),
    mut attempt: ResMut<Attempt>,
) {
    let solved = tables.get();
    let Solved { bodies, solution, .. } = solved;
    let contacts = &solved.contacts.0;
    let (increment, fraction) = (progress.increment, progress.fraction);
    let mut found = find_ruptures(solved, &rules, Met::Slack, increment);
    let on_limit: HashSet<BondId> = found.iter().map(|r| r.bond).collect();
    let late = found.len();
    let moved = search.moved;
    let soon = |next: f64| -> Vec<Rupture> {
        // The rate of a followed motion does not predict the next increment.
        if fraction == 0.0 || moved {
            return Vec::new();
        }
        let before = overloads_at_start(solved, 1.0);
        let after = overloads(solved, 1.0);
        let mut due: Vec<(f64, Rupture)> = before
            .iter()
            .zip(&after)
            .map(|(from, to)| (distance(to.value, [from.value, to.value], fraction), to))
            .filter(|(distance, _)| *distance <= 2.0 * next)
            .filter_map(|(distance, o)| {
                let forces = &solution.forces[o.contact];
                let rupture = rupture(increment, bodies, &contacts[o.contact], forces, o.mode)?;
                (!on_limit.contains(&rupture.bond)).then_some((distance, rupture))
            })
            .collect();
        due.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.bond.cmp(&b.1.bond)));
        let within = due.iter().filter(|(distance, _)| *distance <= next).count();
        due.truncate(within + late);
        due.into_iter().map(|(_, rupture)| rupture).collect()
    };
    let share = (late + soon(fraction).len()) as f64 / bodies.bonds.len().max(1) as f64;
    let may_shorten = fraction > 0.0 && search.trials < 2 && !moved;
    if share > MARGIN * MAX_SHARE && may_shorten {
        search.trials += 1;
        search.target = fraction * MAX_SHARE / share;
        attempt.verdict = Verdict::Overloaded;
        return;
    }
    // Length of the next increment, and equal parts of what is left of the whole one.
    let growth = (MAX_SHARE / share.max(f64::MIN_POSITIVE)).clamp(0.5, 2.0);
    let wanted = (growth * fraction).min(1.0);
    let end = (progress.done + fraction).fract();
    let rest = if end.min(1.0 - end) < 1e-9 { 1.0 } else { 1.0 - end };
    let next = rest / (rest / wanted.max(1e-3) - 0.3).ceil().max(1.0);
    if fraction > 0.0 {
        progress.tried = 0.5 * next;
    }
    let is_last = progress.total > 0.0 && (progress.done + fraction - progress.total).abs() < 1e-9;
    let soon = if is_last { Vec::new() } else { soon(next) };
    let is_mild = || {
        let due: HashSet<BondId> = found.iter().chain(&soon).map(|r| r.bond).collect();
        let is_due =
            |c: &Contact| c.bond.is_some_and(|k| due.contains(&bodies.bonds[k as usize].id));
        let due: Vec<usize> = (0..contacts.len()).filter(|k| is_due(&contacts[*k])).collect();
        let laws = Laws { bodies, materials: &materials, analysis: &analysis };
        brittleness(&due, contacts, &solution.forces, laws) <= rules.brittleness
    };
    if late + soon.len() <= 1 && !is_mild() {
        // The bonds that have not reached their limits break at their limits, one by one.
        progress.dense = false;
    } else {
        found.extend(soon);
    }
    search.late = late as f64 / found.len().max(1) as f64;
    ruptures.list.extend(found);
    search.settles = if is_last {
        is_unsettled(&search, &ruptures, &progress)
    } else {
        !progress.dense && !ruptures.list.is_empty()
    };
}
