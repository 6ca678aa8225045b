//! Grains that no motion brings to rest, and that carry nothing but themselves: they fall out of the
//! specimen or roll without end. In statics such a grain has no equilibrium, and none is missed: the
//! specimen stands without it. It is set aside: it stays where it is without weight.

use glam::DVec2;

use clastic_components::body::BodyDrive;
use clastic_components::contact::BodyTable;
use clastic_components::wall_shape::WallShape;

use super::loose_grains::loose;
use crate::assemble_program::regularise::loaded_pairs;
use crate::measures::fragments::fragments;
use crate::motion_settings::MotionSettings;
use crate::solved::Solved;

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

/// Tells what still moves in a step of a motion, which may go on where nothing but loose grains does.
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
pub(super) fn carry_themselves(
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
    let n = bodies.particles;
    let others = (0..n).filter(|i| grains.binary_search(i).is_err());
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
