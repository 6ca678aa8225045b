//! Judge: is a collapse that of loose grains? A grain that has lost its hold falls or rolls
//! down. No equilibrium exists before it lies on others, but the specimen stands.
//!
//! Grains that no motion brings to rest, and that carry nothing but themselves, fall out of the specimen
//! or roll without end. Such a grain has no equilibrium, but the specimen stands without it. In
//! statics it is therefore set aside: it stays where it is, without weight.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::body::BodyDrive;
use clastic_components::contact::BodyTable;
use clastic_components::contact_history::DraftHistory;
use clastic_components::increment::Acceptance;
use clastic_components::wall_shape::WallShape;
use clastic_cone::program::ConeSolution;
use glam::DVec2;

use super::motion::may_begin;
use crate::assemble_program::regularise::loaded_pairs;
use crate::measures::fragments::fragments;
use crate::mechanism::{takes_part, translations};
use crate::motion_settings::MotionSettings;
use crate::solved::Solved;

/// Finds mechanisms of loose grains, whose motion is followed. Where no further motion may begin,
/// those that carry nothing but themselves are set aside where they are.
pub fn judge(
    mut bodies: ResMut<BodyTable>,
    solution: Res<ConeSolution>,
    draft: Res<DraftHistory>,
    acceptance: Res<Acceptance>,
    settings: Res<MotionSettings>,
    mut attempt: ResMut<Attempt>,
) {
    // A motion that has found no rest ends with the proof, whatever bodies move in the mechanism.
    let Some(certificate) = solution.certificate.as_ref().filter(|_| attempt.effort().is_some())
    else {
        return;
    };
    let mut far = translations(certificate);
    // A group may turn about its centre, so that its position does not change.
    for group in &bodies.groups {
        let row = group.body as usize;
        far[row] += certificate.mechanism[row][2].abs() * group.extent;
    }
    let Some(grains) = loose(&bodies, &far) else { return };
    attempt.verdict = Verdict::Loose;
    if !may_begin(&attempt, &acceptance, &settings) {
        let sizes = draft.0.sizes(bodies.mean_radius);
        let grains = carry_themselves(&bodies, &grains, sizes).unwrap_or_default();
        if grains.iter().any(|i| !bodies.set_aside[*i]) {
            grains.iter().for_each(|i| bodies.set_aside[*i] = true);
            attempt.verdict = Verdict::Again;
        }
    }
}

/// The particles among the bodies that move this `far`, if they are a minority of the particles, and
/// neither a wall, nor a rigid group, nor a particle with a load of its own moves. Where most
/// particles move, the specimen itself gives way, and its motion would be followed in vain.
fn loose(bodies: &BodyTable, far: &[f64]) -> Option<Vec<usize>> {
    let moves = takes_part(far);
    let is_loose =
        |i: usize| i < bodies.particles && !bodies.has_load(i) && bodies.group(i).is_none();
    let moving: Vec<usize> = (0..far.len()).filter(|i| moves(*i)).collect();
    // Without translations no grain falls.
    let few = !moving.is_empty() && 2 * moving.len() <= bodies.particles;
    (few && moving.iter().all(|i| is_loose(*i))).then_some(moving)
}

/// Part of [`MotionSettings::max_travel`] through which loose grains are followed. The rest is left
/// for other motions of the increment.
const FOLLOWED: f64 = 0.5;

/// Sine of the slope below which a wall catches nothing.
const LEVEL: f64 = 1e-9;

/// What follows where a motion has travelled too far to come to rest.
pub(super) enum Lost {
    /// The specimen gives way.
    Specimen,
    /// Only loose grains move, and may land.
    Falling,
    /// Only these loose grains move, and they are followed no further.
    Grains(Vec<usize>),
}

/// Whether loose grains are followed further in a motion that has `travelled` this many radii.
pub(super) fn may_fall(travelled: f64, settings: &MotionSettings) -> bool {
    travelled <= FOLLOWED * settings.max_travel
}

/// What still moves in a step of a motion, which may continue for loose grains if it `goes_on`.
pub(super) fn lost(solved: Solved, gravity: DVec2, goes_on: bool) -> Lost {
    let Solved { bodies, solution, .. } = solved;
    let mut far: Vec<f64> = solution.displacements.iter().map(|u| u[0].hypot(u[1])).collect();
    far.truncate(bodies.positions.len());
    let listed = solved.contacts.0.iter().zip(&solution.forces);
    let forces = listed.map(|(c, f)| (c.a, c.b, f[0].abs().max(f[1].abs())));
    let Some(grains) =
        loose(bodies, &far).and_then(|grains| carry_themselves(bodies, &grains, forces))
    else {
        return Lost::Specimen;
    };
    if goes_on && !have_left(bodies, gravity, &grains) {
        Lost::Falling
    } else {
        Lost::Grains(grains)
    }
}

/// The grains that are loose and those that are bonded to them, if they carry nothing but
/// themselves: no two fragments of them bear on each other, a fragment of several grains is in free
/// flight, and they are a minority. `forces` are in N, by pairs of bodies.
fn carry_themselves(
    bodies: &BodyTable,
    grains: &[usize],
    forces: impl Iterator<Item = (u32, u32, f64)> + Clone,
) -> Option<Vec<usize>> {
    let n = bodies.particles;
    let fragments = fragments(bodies);
    let mut sizes = vec![0_usize; n];
    fragments.iter().for_each(|root| sizes[*root as usize] += 1);
    let mut moves = vec![false; n];
    grains.iter().for_each(|i| moves[fragments[*i] as usize] = true);
    let moves: Vec<bool> = fragments.iter().map(|root| moves[*root as usize]).collect();
    let all: Vec<usize> = (0..n).filter(|i| moves[*i]).collect();
    let held = |i: usize| bodies.drives[i] != [BodyDrive::Free; 3] || bodies.group(i).is_some();
    let on_wall = bodies.bonds.iter().any(|bond| bond.b as usize >= n && moves[bond.a as usize]);
    // Those that were set aside before count too: the specimen must not go grain by grain.
    let gone = (0..n).filter(|i| moves[*i] || bodies.set_aside[*i]).count();
    if 2 * gone > n || on_wall || all.iter().any(|i| held(*i) || bodies.has_load(*i)) {
        return None;
    }
    let of = |body: u32| fragments.get(body as usize).filter(|_| moves[body as usize]);
    let bears = loaded_pairs(forces).any(|(a, b)| match (of(a), of(b)) {
        (Some(a), Some(b)) => a != b,
        (Some(root), None) | (None, Some(root)) => sizes[*root as usize] > 1,
        (None, None) => false,
    });
    (!bears).then_some(all)
}

/// Whether the grains have left the specimen: along their weight, everything else lies behind them.
fn have_left(bodies: &BodyTable, gravity: DVec2, grains: &[usize]) -> bool {
    let down = gravity.normalize_or_zero();
    if down == DVec2::ZERO || bodies.cell.is_some() {
        return false;
    }
    let others = (0..bodies.particles).filter(|i| grains.binary_search(i).is_err());
    let others = others.map(|i| bodies.positions[i].dot(down) + bodies.radii[i]);
    let walls = bodies.walls.iter().map(|wall| match wall.shape {
        // An infinite line catches what falls on its inner side.
        WallShape::Line if wall.inward.dot(down) < -LEVEL => f64::INFINITY,
        WallShape::Line => f64::NEG_INFINITY,
        _ => bodies.positions[wall.body as usize].dot(down) + wall.extent(),
    });
    let lowest = others.chain(walls).fold(f64::NEG_INFINITY, f64::max);
    grains.iter().all(|i| bodies.positions[*i].dot(down) - bodies.radii[*i] > lowest)
}
