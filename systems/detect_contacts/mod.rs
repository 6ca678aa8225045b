//! Contact detection: which pairs may carry force in this increment.
//!
//! Candidates come from an exact search by a [`grid`] of cells, whose result is kept while the
//! disks move little ([`candidates`]). Of the candidates, those that cannot close within the
//! increment are pruned by an estimate of the motion; the estimate may be wrong, so
//! [`closed_pairs`](crate::attempt::closed_pairs) checks the solution against all pairs and asks
//! for another attempt with those that it missed. No number here therefore decides which contacts
//! close.

pub mod candidates;
pub mod gaps;
pub mod grid;
pub mod periodic;
#[cfg(test)]
mod tests;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use crate::detect_contacts::candidates::CandidatePairs;
use crate::detect_contacts::gaps::{pair_contact, wall_contact, wall_gap};
use crate::motion_settings::MotionSettings;
use crate::schedule::{AttemptIncrement, AttemptSystems, lap};

mod expected_motion;

/// Distance to a wall, in radii of the particle or mean radii, beyond which the expected motion is
/// not evaluated.
///
/// Twice the maximum gap of a pair.
const WALL_REACH: f64 = 2.0 * expected_motion::MAX;

/// Adds [`detect_contacts`].
pub struct DetectContactsPlugin;

impl Plugin for DetectContactsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ContactTable>()
            .init_resource::<CandidatePairs>()
            .init_resource::<MotionSettings>()
            .add_systems(
                AttemptIncrement,
                (detect_contacts, lap(|t| &mut t.detect)).chain().in_set(AttemptSystems::Detect),
            );
    }
}

/// Fills [`ContactTable`], sorted by (a, b): every intact bond, and every pair that may close.
pub fn detect_contacts(
    bodies: Res<BodyTable>,
    analysis: Res<ClasticAnalysis>,
    progress: Res<ClasticProgress>,
    attempt: Res<Attempt>,
    added: Res<AddedPairs>,
    settings: Res<MotionSettings>,
    mut candidates: ResMut<CandidatePairs>,
    mut contacts: ResMut<ContactTable>,
) {
    // A step of a motion may change direction: nearby pairs take part whatever the last motion was.
    let minimum = attempt.motion().map_or(0.0, |_| settings.reach * bodies.mean_radius);
    let expected = expected_motion::expected_motion(&bodies, &analysis, &progress, minimum);
    let n = bodies.particles;
    let (positions, radii) = (&bodies.positions[..n], &bodies.radii[..]);
    // The list of candidates does not handle images: in a cell the pairs are found anew.
    let in_cell = bodies
        .cell
        .map(|cell| periodic::pairs_within(&cell, positions, radii, expected.max_reach(n)));
    if in_cell.is_none() {
        candidates.ensure(positions, radii, expected.max_reach(n));
    }
    let near = in_cell.as_deref().unwrap_or(candidates.pairs());

    let list = &mut contacts.0;
    list.clear();
    let mut bonds = bodies.bonds.iter().enumerate().peekable();
    let mut missed = added.0.iter().peekable();
    let has_joined = !bodies.groups.is_empty() || !bodies.links.is_empty();
    // Candidates, bonds and added pairs are each sorted by (a, b): one merge keeps all sorted.
    for (a, b) in merged_pairs(&bodies, &added.0, near) {
        if has_joined && bodies.are_joined(a, b) {
            continue;
        }
        let bond = bonds.next_if(|(_, bond)| (bond.a, bond.b) == (a, b)).map(|(k, _)| k as u32);
        let is_added = missed.next_if(|pair| **pair == (a, b)).is_some();
        let (contact, gap) = if (b as usize) < n {
            let contact = pair_contact(&bodies, a, b);
            (contact, contact.gap)
        } else {
            let Some(wall) = bodies.wall(b) else { continue };
            let (x, r) = (bodies.positions[a as usize], radii[a as usize]);
            let gap = wall_gap(&bodies.walls, &bodies.positions, wall, x, r);
            (wall_contact(&bodies, a, wall), gap)
        };
        if is_added || bond.is_some() || gap <= expected.pair_reach(a, b) {
            list.push(Contact { bond, ..contact });
        }
    }
}

/// Candidates, wall pairs, bonds and added pairs, sorted by (a, b) and without repeats.
fn merged_pairs(
    bodies: &BodyTable,
    added: &[(u32, u32)],
    candidates: &[(u32, u32)],
) -> Vec<(u32, u32)> {
    let mut all = Vec::with_capacity(
        candidates.len() + bodies.bonds.len() + bodies.particles * bodies.walls.len(),
    );
    all.extend_from_slice(candidates);
    all.extend(bodies.bonds.iter().map(|bond| (bond.a, bond.b)));
    all.extend_from_slice(added);
    for a in 0..bodies.particles as u32 {
        let x: DVec2 = bodies.positions[a as usize];
        let r = bodies.radii[a as usize];
        for wall in &bodies.walls {
            // A wall that is many radii away needs no estimate of the motion.
            let gap = wall.nearest(bodies.positions[wall.body as usize], x).distance - r;
            if gap <= WALL_REACH * bodies.mean_radius.max(r) {
                all.push((a, wall.body));
            }
        }
    }
    // Four runs that are sorted already: a stable sort merges them.
    all.sort();
    all.dedup();
    all
}
