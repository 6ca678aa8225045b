//! Judge: does the mechanism of a collapse close pairs outside the program? The program is then
//! solved again with these pairs. Otherwise a specimen that is loaded before its grains touch, or
//! that finds new support, would count as collapsed because detection had pruned its contacts.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, Contacts, WallRow};
use clastic_components::contact_history::DraftHistory;
use clastic_components::findings::AddedPairs;
use clastic_components::increment::Acceptance;
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::closed_pairs::{Places, add, gap, is_listed, unlisted_pairs};
use crate::detect_contacts::Candidates;

/// Step of the difference quotients of gaps, mean radii: gaps change in proportion to so small a
/// motion. It is also their truncation error, which a pair that closes exceeds.
const STEP: f64 = 1e-6;

/// Checks the mechanism against the pairs within reach: those that two grains can close with the
/// maximum accepted motion. Constant normals are not valid beyond that, and a crushed specimen
/// would find new support endlessly. A loaded wall without contact may come from any distance.
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
    // A wall of a rigid group may turn about its middle, so that its position does not change.
    let turns: Vec<f64> = certificate.mechanism.iter().map(|u| u[2]).collect();
    let travel = |wall: &WallRow| {
        let row = wall.body as usize;
        motion[row].length() + turns[row].abs() * wall.extent()
    };
    let travels = bodies.walls.iter().map(travel);
    let maximum = motion.iter().map(|u| u.length()).chain(travels).fold(0.0, f64::max);
    if !(maximum > 0.0) {
        return;
    }
    let scale = STEP * bodies.mean_radius / maximum;
    let moved: Vec<DVec2> =
        bodies.positions.iter().zip(&motion).map(|(x, u)| *x + scale * *u).collect();
    let start = (&bodies.positions[..], bodies.cell.as_ref());
    let row = bodies.positions.len();
    let deformed = bodies.cell.map(|cell| {
        let u = program.bodies[row].to_global(certificate.mechanism[row]);
        cell.deformed(u.map(|u| scale * u), bodies.mean_radius)
    });
    let after = (&moved[..], deformed.as_ref());
    let turned: Vec<WallRow> =
        bodies.walls.iter().map(|wall| wall.turned(scale * turns[wall.body as usize])).collect();
    let closes = |(a, b): &(u32, u32)| {
        let at = |walls: &[WallRow], places: Places| gap(&bodies, walls, places, *a, *b);
        let closing = at(&bodies.walls, start) - at(&turned, after);
        closing > STEP * scale * maximum
    };
    let reach = 2.0 * acceptance.throw * bodies.mean_radius;
    let near = unlisted_pairs(&bodies, &bodies.walls, &candidates, &contacts, start, reach);
    let touched = |wall: u32| history.0.0.iter().any(|m| m.b == wall && m.p > 0.0);
    let coming = bodies.walls.iter().filter(|w| travel(w) > 0.0);
    let coming = coming.filter(|w| !touched(w.body));
    let walls = coming.flat_map(|w| (0..bodies.particles as u32).map(|a| (a, w.body)));
    let walls = walls.filter(|pair| !is_listed(&contacts, *pair));
    let closing: Vec<(u32, u32)> = near.into_iter().chain(walls).filter(closes).collect();
    if !closing.is_empty() {
        // The next solution moves by about the smallest of these gaps, and not as far as the last
        // one.
        let gaps = closing.iter().map(|(a, b)| gap(&bodies, &bodies.walls, start, *a, *b));
        let nearest = gaps.fold(f64::INFINITY, f64::min);
        attempt.magnitudes = Some((nearest.max(program.scales.displacement), program.scales.force));
        add(&mut pairs, closing.into_iter());
        attempt.verdict = Verdict::Again;
    }
}
