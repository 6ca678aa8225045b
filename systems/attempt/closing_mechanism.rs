//! Judge: would the mechanism of a collapse close pairs that were not in the program? Then it is
//! no collapse yet: solve again with them. A specimen that is loaded before its grains touch, or one
//! that finds new support, must not count as collapsed because its contacts were pruned.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::Attempt;
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::program::{ConeProgram, ConeSolution};

use super::closed_pairs::{add, gap, is_listed, unlisted_pairs};

/// Particles with a greater gap, in mean radii, do not come into question: frozen normals say
/// nothing about them. A wall that moves has the same normal however far it is.
const FURTHEST: f64 = 1.0;
/// A pair closes if it does so faster than this fraction of the greatest motion.
const CLOSES: f64 = 1e-6;

/// Checks all pairs near each other against the mechanism.
pub fn judge(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
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
    let near = unlisted_pairs(&bodies, &contacts, &bodies.positions, FURTHEST * bodies.mean_radius);
    let moving = bodies.walls.iter().filter(|w| motion[w.body as usize] != DVec2::ZERO);
    let walls = moving.flat_map(|w| (0..bodies.particles as u32).map(|a| (a, w.body)));
    let walls = walls.filter(|pair| !is_listed(&contacts, *pair));
    let mut closing = near.into_iter().chain(walls).filter(closes).peekable();
    if closing.peek().is_some() {
        add(&mut attempt, closing);
    }
}
