//! Judge: did a pair that was not in the program close? Then solve again with it, so that no
//! contact is ever missed and none is carried for nothing.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::increment::Acceptance;
use clastic_components::program::{ConeProgram, ConeSolution};

use crate::detect_contacts::grid::pairs_within;

/// When pairs are added at all, those within this many mean radii of closing come along: they
/// would be next.
const COMPANY: f64 = 0.01;

/// Checks all pairs, not just candidates, at the positions after the solution.
pub fn judge(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    acceptance: Res<Acceptance>,
    mut attempt: ResMut<Attempt>,
) {
    let tolerance = acceptance.overlap * bodies.mean_radius;
    let positions = moved_positions(&bodies, &program, &solution);
    let listed = |a: u32, b: u32| contacts.0.binary_search_by_key(&(a, b), |c| (c.a, c.b)).is_ok();
    let missed = |reach: f64| {
        let mut pairs = Vec::new();
        pairs_within(&positions[..bodies.particles], &bodies.radii, reach, &mut pairs);
        for wall in &bodies.walls {
            let w = positions[wall.body as usize];
            for (a, (x, r)) in positions.iter().zip(&bodies.radii).enumerate() {
                if (*x - w).dot(wall.inward) - r <= reach {
                    pairs.push((a as u32, wall.body));
                }
            }
        }
        pairs.retain(|(a, b)| !listed(*a, *b));
        pairs
    };
    if missed(-tolerance).is_empty() {
        return;
    }
    attempt.added_pairs.extend(missed(COMPANY * bodies.mean_radius));
    attempt.added_pairs.sort_unstable();
    attempt.added_pairs.dedup();
    attempt.verdict = Verdict::Again;
}

/// Positions of all bodies after the displacements of the solution, m.
pub fn moved_positions(
    bodies: &Bodies,
    program: &ConeProgram,
    solution: &ConeSolution,
) -> Vec<DVec2> {
    bodies
        .positions
        .iter()
        .zip(&program.bodies)
        .zip(&solution.displacements)
        .map(|((x, body), u)| {
            let u = body.to_global(*u);
            *x + DVec2::new(u[0], u[1])
        })
        .collect()
}
