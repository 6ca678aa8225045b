//! Judge: would the mechanism of a collapse close pairs that were not in the program? Then it is
//! no collapse yet: solve again with them. A specimen that is loaded before its grains touch, or one
//! that finds new support, must not count as collapsed because its contacts were pruned.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, Contacts, DraftHistory};
use clastic_components::findings::AddedPairs;
use clastic_components::increment::Acceptance;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::closed_pairs::{add, gap, is_listed, unlisted_pairs};
use crate::detect_contacts::Candidates;

/// A pair closes if it does so faster than this fraction of the greatest motion.
const CLOSES: f64 = 1e-6;

/// Checks the pairs that an acceptable motion can close against the mechanism: those that two grains
/// thrown at each other would. Beyond that frozen normals say nothing, and a specimen that is crushed
/// would find support without end. A loaded wall that nothing touches yet comes from any distance.
pub fn judge(
    bodies: Res<Bodies>,
    candidates: Res<Candidates>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    history: Res<DraftHistory>,
    acceptance: Res<Acceptance>,
    mut pairs: ResMut<AddedPairs>,
    mut attempt: ResMut<Attempt>,
) {
    let Some(certificate) = &solution.certificate else { return };
    let motion: Vec<DVec2> = program
        .bodies
        .iter()
        .zip(&certificate.mechanism)
        .map(|(body, u)| {
            let u = body.to_global(*u);
            DVec2::new(u[0], u[1])
        })
        .collect();
    let greatest = motion.iter().map(|u| u.length()).fold(0.0, f64::max);
    if !(greatest > 0.0) {
        return;
    }
    // So small a motion that the gaps change in proportion to it.
    let scale = 1e-6 * bodies.mean_radius / greatest;
    let moved: Vec<DVec2> =
        bodies.positions.iter().zip(&motion).map(|(x, u)| *x + scale * *u).collect();
    let closes = |(a, b): &(u32, u32)| {
        let closing = gap(&bodies, &bodies.positions, *a, *b) - gap(&bodies, &moved, *a, *b);
        closing > CLOSES * scale * greatest
    };
    let reach = 2.0 * acceptance.throw * bodies.mean_radius;
    let near = unlisted_pairs(&bodies, &candidates, &contacts, &bodies.positions, reach);
    let touched = |wall: u32| history.0.0.iter().any(|m| m.b == wall && m.p > 0.0);
    let coming = bodies.walls.iter().filter(|w| motion[w.body as usize] != DVec2::ZERO);
    let coming = coming.filter(|w| !touched(w.body));
    let walls = coming.flat_map(|w| (0..bodies.particles as u32).map(|a| (a, w.body)));
    let walls = walls.filter(|pair| !is_listed(&contacts, *pair));
    let closing: Vec<(u32, u32)> = near.into_iter().chain(walls).filter(closes).collect();
    if !closing.is_empty() {
        // The next solution moves as far as the nearest of them, not as the last one did.
        let gaps = closing.iter().map(|(a, b)| gap(&bodies, &bodies.positions, *a, *b));
        let nearest = gaps.fold(f64::INFINITY, f64::min).max(1e-3 * bodies.mean_radius);
        attempt.magnitudes = Some((nearest.max(program.scales.displacement), program.scales.force));
        add(&mut pairs, closing.into_iter());
        attempt.verdict = Verdict::Again;
    }
}
