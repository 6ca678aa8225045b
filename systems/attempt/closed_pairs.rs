//! Judge: has a pair outside the program closed? The program is then solved again with this pair,
//! so that no contact is missed although detection prunes pairs.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::cell::PeriodicCell;
use clastic_components::contact::{Bodies, Contacts, WallRow};
use clastic_components::findings::AddedPairs;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind};
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::too_far::is_unsupported;
use crate::detect_contacts::Candidates;
use crate::detect_contacts::gaps::wall_gap;
use crate::detect_contacts::grid::pairs_within;
use crate::detect_contacts::periodic;

/// Pairs that are about to close are added together with those that close. Their gap is at most
/// this many mean radii plus this fraction of their relative motion.
const NEAR: f64 = 0.01;
const NEAR_OF_MOTION: f64 = 0.5;
/// Maximum gap of pairs that are added in this way, in mean radii.
const MAX_NEAR: f64 = 0.5;

/// Checks all pairs, not only those of the program, at the positions after the solution. A static
/// solution that moves a grain without support shows none: the grain crosses thousands of others.
pub fn judge(
    settings: (Res<Acceptance>, Res<Analysis>),
    bodies: Res<Bodies>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    candidates: Res<Candidates>,
    contacts: Res<Contacts>,
    mut added: ResMut<AddedPairs>,
    mut attempt: ResMut<Attempt>,
) {
    let (acceptance, analysis) = settings;
    let is_static = analysis.kind == AnalysisKind::Static;
    if is_static && is_unsupported(&bodies, &program, &solution) {
        return;
    }
    let tolerance = acceptance.overlap * bodies.mean_radius;
    let positions = moved_positions(&bodies, &program, &solution);
    let cell = moved_cell(&bodies, &program, &solution);
    let after = (&positions[..], cell.as_ref());
    let rotation = |body: u32| solution.displacements.get(body as usize).map_or(0.0, |u| u[2]);
    let walls: Vec<WallRow> =
        bodies.walls.iter().map(|wall| wall.turned(rotation(wall.body))).collect();
    let missed = |reach: f64| unlisted_pairs(&bodies, &walls, &candidates, &contacts, after, reach);
    if missed(-tolerance).is_empty() {
        return;
    }
    let motion = |i: u32| positions[i as usize] - bodies.positions[i as usize];
    let near = |(a, b): &(u32, u32)| {
        let approach = (motion(*a) - motion(*b)).length();
        let reach = NEAR * bodies.mean_radius + NEAR_OF_MOTION * approach;
        gap(&bodies, &walls, after, *a, *b) <= reach
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

/// Positions of all bodies, m, and the periodic cell.
pub(super) type Places<'a> = (&'a [DVec2], Option<&'a PeriodicCell>);

/// Gap between a particle and a particle or wall at the given places, m. `walls` are the walls of
/// `bodies` after their rotation.
pub(super) fn gap(
    bodies: &Bodies,
    walls: &[WallRow],
    (positions, cell): Places,
    a: u32,
    b: u32,
) -> f64 {
    let (x, r) = (positions[a as usize], bodies.radii[a as usize]);
    match walls.iter().find(|w| w.body == b) {
        Some(wall) => {
            let from = |places: &[DVec2]| places[a as usize] - places[b as usize];
            let mut way = [from(&bodies.positions), from(positions)];
            // The path of the centre is taken in the axes of the wall at the end.
            if let Some(before) = bodies.walls.iter().find(|w| w.body == b)
                && before.inward != wall.inward
            {
                let by =
                    DVec2::new(before.inward.dot(wall.inward), before.inward.perp_dot(wall.inward));
                way[0] = by.rotate(way[0]);
            }
            if wall.shape.is_crossed(wall.inward, wall.half_length, way) {
                // The centre has passed through the wall: this is an overlap and not a gap.
                -r - way[0].distance(way[1])
            } else {
                wall_gap(wall, positions[b as usize], x, r)
            }
        }
        None => {
            let apart = positions[b as usize] - x;
            let way = cell.map_or(apart, |cell| apart + cell.shift(apart));
            way.length() - r - bodies.radii[b as usize]
        }
    }
}

/// All pairs outside the program whose gap at the given positions is at most `reach`. The search
/// for new candidates runs only if bodies have left the neighbourhood of the present ones.
pub(super) fn unlisted_pairs(
    bodies: &Bodies,
    walls: &[WallRow],
    Candidates(candidates): &Candidates,
    contacts: &Contacts,
    (positions, cell): Places,
    reach: f64,
) -> Vec<(u32, u32)> {
    let (disks, radii) = (&positions[..bodies.particles], &bodies.radii);
    let mut pairs = if let Some(cell) = cell {
        periodic::pairs_within(cell, disks, radii, reach)
    } else if candidates.is_complete(disks, radii, reach) {
        candidates.within(disks, radii, reach).collect()
    } else {
        let mut found = Vec::new();
        pairs_within(disks, radii, reach, &mut found);
        found
    };
    // Both lists are sorted.
    let mut listed = contacts.0.iter().map(|c| (c.a, c.b)).peekable();
    pairs.retain(|pair| {
        while listed.next_if(|listed| listed < pair).is_some() {}
        listed.peek() != Some(pair)
    });
    if !bodies.groups.is_empty() {
        pairs.retain(|(a, b)| !bodies.are_joined(*a, *b));
    }
    for wall in &bodies.walls {
        for pair in (0..bodies.particles as u32).map(|a| (a, wall.body)) {
            let near = gap(bodies, walls, (positions, cell), pair.0, pair.1) <= reach;
            if near && !is_listed(contacts, pair) {
                pairs.push(pair);
            }
        }
    }
    pairs
}

/// Whether a pair is in the program.
pub(super) fn is_listed(contacts: &Contacts, pair: (u32, u32)) -> bool {
    contacts.0.binary_search_by_key(&pair, |c| (c.a, c.b)).is_ok()
}

/// The periodic cell after the displacements of the solution.
pub fn moved_cell(
    bodies: &Bodies,
    program: &ConeProgram,
    solution: &ConeSolution,
) -> Option<PeriodicCell> {
    let row = program.cell?.body as usize;
    let u = program.bodies[row].to_global(solution.displacements[row]);
    bodies.cell.map(|cell| cell.deformed(u, bodies.mean_radius))
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
