//! Where bodies are after a motion that is not committed.

use glam::DVec2;

use clastic_components::cell::PeriodicCell;
use clastic_components::contact::{BodyTable, ContactTable, WallRow};

use crate::detect_contacts::gaps::{JOINT, wall_gap};
use crate::solved::Solved;

/// Where the bodies are after a motion.
pub(crate) struct Moved {
    pub positions: Vec<DVec2>,
    pub cell: Option<PeriodicCell>,
    walls: Vec<WallRow>,
}

impl Moved {
    /// Before any motion.
    pub fn not(bodies: &BodyTable) -> Self {
        let BodyTable { positions, cell, walls, .. } = bodies;
        Self { positions: positions.clone(), cell: *cell, walls: walls.clone() }
    }

    /// After displacements (m, m, rad; by body in its own axes), multiplied by `scale`.
    pub fn by(solved: Solved, displacements: &[[f64; 3]], scale: f64) -> Self {
        let Solved { bodies, program, .. } = solved;
        let global = |i: usize| program.bodies[i].to_global(displacements[i]);
        let moved = |(i, x): (usize, &DVec2)| {
            let u = global(i);
            *x + scale * DVec2::new(u[0], u[1])
        };
        let cell = program.cell.map(|cell| global(cell.body as usize).map(|u| scale * u));
        let turned = |wall: &WallRow| wall.turned(scale * displacements[wall.body as usize][2]);
        Self {
            positions: bodies.positions.iter().enumerate().map(moved).collect(),
            cell: bodies.deformed_cell(cell),
            walls: bodies.walls.iter().map(turned).collect(),
        }
    }

    /// Gap between a particle and a particle or wall, m.
    pub fn gap(&self, bodies: &BodyTable, a: u32, b: u32) -> f64 {
        let (x, r) = (self.positions[a as usize], bodies.radii[a as usize]);
        match bodies.walls.iter().zip(&self.walls).find(|(before, _)| before.body == b) {
            Some((before, wall)) => match self.passed(bodies, a, (before, wall)) {
                // The centre has passed through the wall: this is an overlap and not a gap.
                Some(way) => -r - way,
                None => wall_gap(&self.walls, &self.positions, wall, x, r),
            },
            None => {
                let apart = self.positions[b as usize] - x;
                let way = self.cell.map_or(apart, |cell| apart + cell.shift(apart));
                way.length() - r - bodies.radii[b as usize]
            }
        }
    }

    /// Length of the way of a particle whose centre has passed through a wall, m. The wall is that before
    /// and after the motion.
    fn passed(
        &self,
        bodies: &BodyTable,
        a: u32,
        (before, wall): (&WallRow, &WallRow),
    ) -> Option<f64> {
        let from = |places: &[DVec2]| places[a as usize] - places[wall.body as usize];
        let mut way = [from(&bodies.positions), from(&self.positions)];
        // The path of the centre is taken in the axes of the wall at the end.
        if before.inward != wall.inward {
            let (along, across) =
                (before.inward.dot(wall.inward), before.inward.perp_dot(wall.inward));
            way[0] = DVec2::new(along, across).rotate(way[0]);
        }
        let is_crossed = wall.shape.is_crossed(wall.inward, wall.half_length, way);
        is_crossed.then(|| way[0].distance(way[1]))
    }

    /// The first particle that has passed through a thin wall, and the wall.
    pub(crate) fn first_through(&self, bodies: &BodyTable) -> Option<[usize; 2]> {
        let walls = bodies.walls.iter().zip(&self.walls).filter(|(wall, _)| !wall.is_line());
        let mut pairs = walls.flat_map(|wall| (0..bodies.particles as u32).map(move |a| (a, wall)));
        let found = pairs.find(|(a, wall)| {
            !bodies.are_joined(*a, wall.0.body) && self.passed(bodies, *a, *wall).is_some()
        })?;
        Some([found.0 as usize, found.1.0.body as usize])
    }

    /// Whether the program has the contact of a disk with a wall already, as that with another
    /// piece from which the disk has come: pieces in one line, or a convex corner. A second contact
    /// would halve the force of each.
    pub fn is_held(
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
