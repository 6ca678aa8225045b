//! Judge: has a pair outside the program closed? The program is then solved again with this pair,
//! so that no contact is missed although detection prunes pairs.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::cell::PeriodicCell;
use clastic_components::contact::{BodyTable, ContactTable, WallRow};
use clastic_components::findings::AddedPairs;
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis};
use clastic_cone::program::{ConeProgram, ConeSolution};

use crate::detect_contacts::Candidates;
use crate::detect_contacts::gaps::{JOINT, wall_gap};
use crate::detect_contacts::grid::pairs_within;
use crate::detect_contacts::periodic;
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
    bodies: Res<BodyTable>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    candidates: Res<Candidates>,
    contacts: Res<ContactTable>,
    mut added: ResMut<AddedPairs>,
    mut attempt: ResMut<Attempt>,
) {
    let (acceptance, analysis) = settings;
    let is_static = analysis.kind == AnalysisKind::Static;
    if is_static && is_unsupported(&bodies, &contacts, &program, &solution) {
        return;
    }
    let after = Moved::by(&bodies, &program, &solution.displacements, 1.0);
    let missed = |reach: f64| unlisted_pairs(&bodies, &candidates, &contacts, &after, reach);
    if missed(-acceptance.overlap * bodies.mean_radius).is_empty() {
        return;
    }
    let motion = |i: u32| after.positions[i as usize] - bodies.positions[i as usize];
    let near = |(a, b): &(u32, u32)| {
        let approach = (motion(*a) - motion(*b)).length();
        let reach = NEAR * bodies.mean_radius + NEAR_OF_MOTION * approach;
        after.gap(&bodies, *a, *b) <= reach
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

/// Where the bodies are after a motion.
pub(super) struct Moved {
    pub positions: Vec<DVec2>,
    cell: Option<PeriodicCell>,
    walls: Vec<WallRow>,
}

impl Moved {
    /// Before any motion.
    pub fn not(bodies: &BodyTable) -> Self {
        let BodyTable { positions, cell, walls, .. } = bodies;
        Self { positions: positions.clone(), cell: *cell, walls: walls.clone() }
    }

    /// After displacements (m, m, rad; by body in its own axes), multiplied by `scale`.
    pub fn by(
        bodies: &BodyTable,
        program: &ConeProgram,
        displacements: &[[f64; 3]],
        scale: f64,
    ) -> Self {
        let global = |i: usize| program.bodies[i].to_global(displacements[i]);
        let moved = |(i, x): (usize, &DVec2)| {
            let u = global(i);
            *x + scale * DVec2::new(u[0], u[1])
        };
        let cell = program.cell.map(|cell| global(cell.body as usize).map(|u| scale * u));
        let turned = |wall: &WallRow| wall.turned(scale * displacements[wall.body as usize][2]);
        Self {
            positions: bodies.positions.iter().enumerate().map(moved).collect(),
            cell: bodies.cell.zip(cell).map(|(cell, u)| cell.deformed(u, bodies.mean_radius)),
            walls: bodies.walls.iter().map(turned).collect(),
        }
    }

    /// Gap between a particle and a particle or wall, m.
    pub fn gap(&self, bodies: &BodyTable, a: u32, b: u32) -> f64 {
        let (x, r) = (self.positions[a as usize], bodies.radii[a as usize]);
        match bodies.walls.iter().zip(&self.walls).find(|(before, _)| before.body == b) {
            Some((before, wall)) => {
                let from = |places: &[DVec2]| places[a as usize] - places[b as usize];
                let mut way = [from(&bodies.positions), from(&self.positions)];
                // The path of the centre is taken in the axes of the wall at the end.
                if before.inward != wall.inward {
                    let (along, across) =
                        (before.inward.dot(wall.inward), before.inward.perp_dot(wall.inward));
                    way[0] = DVec2::new(along, across).rotate(way[0]);
                }
                if wall.shape.is_crossed(wall.inward, wall.half_length, way) {
                    // The centre has passed through the wall: this is an overlap and not a gap.
                    -r - way[0].distance(way[1])
                } else {
                    wall_gap(&self.walls, &self.positions, wall, x, r)
                }
            }
            None => {
                let apart = self.positions[b as usize] - x;
                let way = self.cell.map_or(apart, |cell| apart + cell.shift(apart));
                way.length() - r - bodies.radii[b as usize]
            }
        }
    }

    /// Whether the program has the contact of a disk with a wall already, as that with another
    /// piece from which the disk has come: pieces in one line, or a convex corner. A second contact
    /// would halve the force of each.
    fn is_held(
        &self,
        bodies: &BodyTable,
        contacts: &ContactTable,
        a: u32,
        wall: &WallRow,
        gap: f64,
    ) -> bool {
        let (i, b) = (a as usize, wall.body as usize);
        let near = wall.nearest(self.positions[b], self.positions[i]);
        let point = self.positions[i] - near.distance * near.outward;
        let motion = |i: usize| self.positions[i] - bodies.positions[i];
        let joint = JOINT * bodies.radii[i];
        let first = contacts.0.partition_point(|c| (c.a, c.b) < (a, bodies.particles as u32));
        contacts.0[first..].iter().take_while(|c| c.a == a).any(|c| {
            let other = c.b as usize;
            let row = self.walls.iter().find(|row| row.body == c.b);
            let moved = motion(i) - motion(other);
            c.normal.dot(-near.outward) >= TURN
                && c.gap - c.normal.dot(moved) <= gap + joint
                && row.is_some_and(|row| {
                    row.nearest(self.positions[other], point).distance <= moved.length() + joint
                })
        })
    }
}

/// Cosine of the angle by which the normal of a contact may turn in an increment, 0.2 rad.
const TURN: f64 = 0.98;

/// All pairs outside the program whose gap after a motion is at most `reach`. The search
/// for new candidates runs only if bodies have left the neighbourhood of the present ones.
pub(super) fn unlisted_pairs(
    bodies: &BodyTable,
    Candidates(candidates): &Candidates,
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
