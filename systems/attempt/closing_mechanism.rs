//! Judge: does the mechanism of a collapse close pairs outside the program? The program is then
//! solved again with these pairs. Otherwise a specimen that is loaded before its grains touch, or
//! that finds new support, would count as collapsed because detection had pruned its contacts.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::WallRow;
use clastic_components::contact_history::DraftHistory;
use clastic_components::findings::{AddedPairs, Centre};
use clastic_components::increment::Acceptance;

use super::closed_pairs::{add, is_listed, unlisted_pairs};
use crate::detect_contacts::candidates::CandidatePairs;
use crate::moved::Moved;
use crate::solved::{Solved, SolvedTables};

/// Step of the difference quotients of gaps, mean radii: gaps change in proportion to so small a
/// motion. It is also their truncation error, which a pair that closes exceeds.
const STEP: f64 = 1e-6;

/// Checks the mechanism against the pairs within reach: those that two grains can close with the
/// maximum accepted motion. Constant normals are not valid beyond that, and a crushed specimen
/// would find new support endlessly. A loaded wall without contact may come from any distance.
pub fn judge(
    tables: SolvedTables,
    candidates: Res<CandidatePairs>,
    history: Res<DraftHistory>,
    mut pairs: ResMut<AddedPairs>,
    mut centre: ResMut<Centre>,
    mut attempt: ResMut<Attempt>,
) {
    let solved = tables.get();
    let Solved { bodies, contacts, program, solution } = solved;
    let Some(certificate) = &solution.certificate else { return };
    let mechanism = &certificate.mechanism;
    let length = |u: &[f64; 3]| u[0].hypot(u[1]);
    // A wall of a rigid group may turn about its middle, so that its position does not change.
    let travel = |wall: &WallRow| {
        let u = &mechanism[wall.body as usize];
        length(u) + u[2].abs() * wall.extent()
    };
    let travels = bodies.walls.iter().map(travel);
    let maximum = mechanism.iter().map(length).chain(travels).fold(0.0, f64::max);
    if !(maximum > 0.0) {
        return;
    }
    let scale = STEP * bodies.mean_radius / maximum;
    let (start, after) = (Moved::not(bodies), Moved::by(solved, mechanism, scale));
    let closes = |(a, b): &(u32, u32)| {
        start.gap(bodies, *a, *b) - after.gap(bodies, *a, *b) > STEP * scale * maximum
    };
    let reach = 2.0 * Acceptance::MAX_TRAVEL * bodies.mean_radius;
    let near = unlisted_pairs(bodies, &candidates, contacts, &start, reach);
    let touched = |wall: u32| history.0.0.iter().any(|m| m.b == wall && m.p > 0.0);
    let coming = bodies.walls.iter().filter(|w| travel(w) > 0.0 && !touched(w.body));
    let walls = coming.flat_map(|w| (0..bodies.particles as u32).map(|a| (a, w.body)));
    let walls = walls.filter(|pair| !is_listed(contacts, *pair));
    let closing: Vec<(u32, u32)> = near.into_iter().chain(walls).filter(closes).collect();
    if !closing.is_empty() {
        // The next solution moves by about the smallest of these gaps, and not as far as the last
        // one.
        let gaps = closing.iter().map(|(a, b)| start.gap(bodies, *a, *b));
        let nearest = gaps.fold(f64::INFINITY, f64::min);
        attempt.magnitudes = Some((nearest.max(program.scales.displacement), program.scales.force));
        add(&mut pairs, closing.into_iter());
        // The regularisation has followed the mechanism, perhaps for kilometres.
        *centre = Centre::default();
        attempt.verdict = Verdict::Again;
    }
}
