//! Particles, walls and cracks at one moment, for frames and pictures.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::body::{BodyId, Origin, Rotation};
use clastic_components::bond::{Bond, BondId, BondState};
use clastic_components::contact::{Bodies, WallRow};
use clastic_components::wall::Wall;

/// State of a run at one moment. Tables by particle are in the order of identities.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Identities.
    pub ids: Vec<u32>,
    /// Centres, m.
    pub positions: Vec<DVec2>,
    /// Radii, m.
    pub radii: Vec<f64>,
    /// Rotations since the start, rad.
    pub rotations: Vec<f64>,
    /// Displacements since the start of the stage list, m.
    pub displacements: Vec<DVec2>,
    /// Ends of the drawn segments of the walls that are lines, m.
    pub walls: Vec<[DVec2; 2]>,
    /// Straight pieces of the thin walls, m; many for an arc.
    pub plates: Vec<[DVec2; 2]>,
    /// Broken bonds as segments from centre to centre, or to the foot of the perpendicular on the
    /// wall, m.
    pub cracks: Vec<[DVec2; 2]>,
}

impl Snapshot {
    /// Takes a snapshot of a world whose [`Bodies`] are up to date, as they are after an increment.
    pub fn take(world: &mut World) -> Self {
        let mut broken = world.query::<(&BondId, &Bond, &BondState)>();
        let mut broken: Vec<_> = broken
            .iter(world)
            .filter(|(.., state)| **state != BondState::Intact)
            .map(|(id, bond, _)| (*id, bond.a, bond.b))
            .collect();
        broken.sort_unstable_by_key(|(id, ..)| *id);

        let bodies = world.resource::<Bodies>();
        let n = bodies.particles;
        let particles = || bodies.entities[..n].iter();
        let place = |i: usize, from: DVec2| match bodies.walls.iter().find(|w| w.body as usize == i)
        {
            Some(wall) if wall.is_line() => {
                from - wall.inward * (from - bodies.positions[i]).dot(wall.inward)
            }
            Some(wall) => {
                let near = wall.nearest(bodies.positions[i], from);
                from - near.outward * near.distance
            }
            None => bodies.positions[i],
        };
        // A removed body has no position.
        let crack = |a: BodyId, b: BodyId| {
            let from = bodies.positions[bodies.row(a)?];
            Some([from, place(bodies.row(b)?, from)])
        };
        let ends = |entity: Entity, middle: DVec2| {
            let wall = world.get::<Wall>(entity)?;
            let half = wall.tangent * wall.half_length;
            Some([middle - half, middle + half])
        };
        let plate = |row: &WallRow| {
            let middle = bodies.positions[row.body as usize];
            let wall = Wall { tangent: row.tangent(), half_length: row.half_length };
            let points = row.shape.outline(&wall);
            let pieces = points.windows(2).map(|ends| [middle + ends[0], middle + ends[1]]);
            pieces.collect::<Vec<_>>()
        };
        Self {
            ids: bodies.ids[..n].iter().map(|id| id.0).collect(),
            positions: bodies.positions[..n].to_vec(),
            radii: bodies.radii.clone(),
            rotations: particles()
                .map(|e| world.get::<Rotation>(*e).map_or(0.0, |r| r.0))
                .collect(),
            displacements: particles()
                .zip(&bodies.positions)
                .map(|(e, x)| world.get::<Origin>(*e).map_or(DVec2::ZERO, |origin| *x - origin.0))
                .collect(),
            walls: bodies
                .walls
                .iter()
                .filter(|row| row.is_line())
                .map(|row| row.body as usize)
                .filter_map(|i| ends(bodies.entities[i], bodies.positions[i]))
                .collect(),
            plates: bodies.walls.iter().filter(|row| !row.is_line()).flat_map(plate).collect(),
            cracks: broken.into_iter().filter_map(|(_, a, b)| crack(a, b)).collect(),
        }
    }

    /// Lower left and upper right corner of the box around all disks and thin walls, m; none without
    /// disks.
    #[must_use]
    pub fn bounds(&self) -> Option<(DVec2, DVec2)> {
        let boxes = self.positions.iter().zip(&self.radii);
        let disks = boxes
            .map(|(x, r)| (*x - DVec2::splat(*r), *x + DVec2::splat(*r)))
            .reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))?;
        let ends = self.plates.iter().flatten();
        Some(ends.fold(disks, |(low, high), x| (low.min(*x), high.max(*x))))
    }
}
