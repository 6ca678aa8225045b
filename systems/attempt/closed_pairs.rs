//! Judge: has a pair outside the program closed? The program is then solved again with this pair,
//! so that no contact is missed although detection prunes pairs.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::AddedPairs;
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis};

use crate::detect_contacts::candidates::CandidatePairs;
use crate::detect_contacts::grid::pairs_within;
use crate::detect_contacts::periodic;
use crate::moved::Moved;
use crate::solved::SolvedTables;
use crate::turns::is_unsupported;

/// Pairs that are about to close are added together with those that close. Their gap is at most
/// this many mean radii plus this fraction of their relative motion.
const NEAR: f64 = 0.01;
const NEAR_OF_MOTION: f64 = 0.5;
/// Maximum gap of pairs that are added in this way, in mean radii.
const MAX_NEAR: f64 = 0.5;

/// Checks all pairs, not only those of the program, at the positions after the solution. A static
/// solution that moves a grain without support shows none: the grain crosses thousands of others.
pub fn judge(
    settings: (Res<Acceptance>, Res<ClasticAnalysis>),
    tables: SolvedTables,
    candidates: Res<CandidatePairs>,
    mut added: ResMut<AddedPairs>,
    mut attempt: ResMut<Attempt>,
) {
    let (acceptance, analysis) = settings;
    let solved = tables.get();
    let bodies = solved.bodies;
    if analysis.kind == AnalysisKind::Static && is_unsupported(solved) {
        return;
    }
    let after = Moved::by(solved, &solved.solution.displacements, 1.0);
    let missed = |reach: f64| unlisted_pairs(bodies, &candidates, solved.contacts, &after, reach);
    if missed(-acceptance.overlap * bodies.mean_radius).is_empty() {
        return;
    }
    let motion = |i: u32| after.positions[i as usize] - bodies.positions[i as usize];
    let near = |(a, b): &(u32, u32)| {
        let approach = (motion(*a) - motion(*b)).length();
        let reach = NEAR * bodies.mean_radius + NEAR_OF_MOTION * approach;
        after.gap(bodies, *a, *b) <= reach
    };
    add(&mut added, missed(MAX_NEAR * bodies.mean_radius).into_iter().filter(near));
    attempt.verdict = Verdict::Again;
}

/// Adds pairs to the next program.
pub(super) fn add(pairs: &mut AddedPairs, new: impl Iterator<Item = (u32, u32)>) {
    pairs.0.extend(new);
    pairs.0.sort_unstable();
    pairs.0.dedup();
}

/// All pairs outside the program whose gap after a motion is at most `reach`. The search
/// for new candidates runs only if bodies have left the neighbourhood of the present ones.
pub(super) fn unlisted_pairs(
    bodies: &BodyTable,
    candidates: &CandidatePairs,
    contacts: &ContactTable,
    after: &Moved,
    reach: f64,
) -> Vec<(u32, u32)> {
    let (disks, radii) = (&after.positions[..bodies.particles], &bodies.radii);
    let mut pairs = if let Some(cell) = &after.cell {
        periodic::pairs_within(cell, disks, radii, reach)
    } else if candidates.is_complete(disks, radii, reach) {
        candidates.within(disks, radii, reach).collect()
    } else {
        pairs_within(disks, radii, reach)
    };
    // Both lists are sorted.
    let mut listed = contacts.0.iter().map(|c| (c.a, c.b)).peekable();
    pairs.retain(|pair| {
        while listed.next_if(|listed| listed < pair).is_some() {}
        listed.peek() != Some(pair)
    });
    if !bodies.groups.is_empty() || !bodies.links.is_empty() {
        pairs.retain(|(a, b)| !bodies.are_joined(*a, *b));
    }
    for wall in &bodies.walls {
        for pair in (0..bodies.particles as u32).map(|a| (a, wall.body)) {
            let gap = after.gap(bodies, pair.0, pair.1);
            if gap <= reach
                && !is_listed(contacts, pair)
                && !bodies.are_joined(pair.0, pair.1)
                && !after.is_held(bodies, contacts, pair.0, wall, gap)
            {
                pairs.push(pair);
            }
        }
    }
    pairs
}

/// Whether a pair is in the program.
pub(super) fn is_listed(contacts: &ContactTable, pair: (u32, u32)) -> bool {
    contacts.0.binary_search_by_key(&pair, |c| (c.a, c.b)).is_ok()
}
