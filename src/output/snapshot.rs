//! Particles, walls and cracks at one moment, for frames and pictures.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::body::{BodyId, BodyOrigin, BodyRotation};
use clastic_components::bond::{Bond, BondId, BondState};
use clastic_components::contact::{BodyTable, WallRow};
use clastic_components::membrane::{Membrane, MembraneShape};
use clastic_components::wall::Wall;

use super::crack::Crack;
use super::view;

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
    /// Broken bonds, in the order of creation.
    pub cracks: Vec<Crack>,
    /// Links of the chains of membranes, m.
    pub membranes: Vec<[DVec2; 2]>,
}

impl Snapshot {
    /// Total area of the disks, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.radii.iter().map(|r| std::f64::consts::PI * r * r).sum()
    }

    /// Takes a snapshot of a world whose [`BodyTable`] are up to date, as they are after an
    /// increment.
    ///
    /// # Panics
    /// If the world lacks [`ClasticPlugins`](crate::ClasticPlugins).
    pub fn take(world: &mut World) -> Self {
        world
            .run_system_cached(|scenery: Scenery| scenery.snapshot())
            .unwrap_or_else(|error| panic!("{error}"))
    }

    /// Lower left and upper right corner of the box around the disks, without strays, and the
    /// walls, m; none without disks. Walls that are lines count up to a quarter of the extent of
    /// the disks beyond these.
    #[must_use]
    pub fn bounds(&self) -> Option<(DVec2, DVec2)> {
        let range = |axis: usize| {
            let ends = |sign: f64| {
                let disks = self.positions.iter().zip(&self.radii);
                disks.map(|(x, r)| x[axis] + sign * r).collect()
            };
            view::range(ends(-1.0), ends(1.0))
        };
        let (x, y) = (range(0)?, range(1)?);
        let disks = (DVec2::new(x[0], y[0]), DVec2::new(x[1], y[1]));
        let lines = view::near(disks, &self.walls);
        let ends = self.plates.iter().flatten().copied().chain(lines);
        Some(ends.fold(disks, |(low, high), x| (low.min(x), high.max(x))))
    }
}

/// Snapshots of a run that its pictures need.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// Whether pictures are drawn.
    pub are_drawn: bool,
    /// State at the start of the reference stage; before it, at the start of the run.
    pub start: Snapshot,
    /// State at the peak so far, with its caption.
    pub peak: Option<(Snapshot, String)>,
}

/// The parts of a world that a [`Snapshot`] shows.
#[derive(SystemParam)]
pub struct Scenery<'w, 's> {
    bodies: Res<'w, BodyTable>,
    bonds: Query<'w, 's, (&'static BondId, &'static Bond, &'static BondState)>,
    walls: Query<'w, 's, &'static Wall>,
    particles: Query<'w, 's, (&'static BodyRotation, &'static BodyOrigin)>,
    membranes: Query<'w, 's, (&'static Membrane, &'static MembraneShape)>,
}

impl Scenery<'_, '_> {
    /// Takes a snapshot. The [`BodyTable`] must be up to date, as they are after an increment.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let bodies = &*self.bodies;
        let n = bodies.particles;
        let motion = |i: usize| self.particles.get(bodies.entities[i]).ok();
        Snapshot {
            ids: bodies.ids[..n].iter().map(|id| id.0).collect(),
            positions: bodies.positions[..n].to_vec(),
            radii: bodies.radii.clone(),
            rotations: (0..n).map(|i| motion(i).map_or(0.0, |(turn, _)| turn.0)).collect(),
            displacements: (0..n)
                .map(|i| {
                    motion(i).map_or(DVec2::ZERO, |(_, origin)| bodies.positions[i] - origin.0)
                })
                .collect(),
            walls: self.wall_ends(),
            plates: self.plates(),
            cracks: self.cracks(),
            membranes: self.links(),
        }
    }

    fn links(&self) -> Vec<[DVec2; 2]> {
        let mut membranes: Vec<_> = self.membranes.iter().collect();
        membranes.sort_unstable_by(|(a, _), (b, _)| a.name.cmp(&b.name));
        membranes.iter().flat_map(|(_, shape)| shape.links()).collect()
    }

    fn wall_ends(&self) -> Vec<[DVec2; 2]> {
        let bodies = &*self.bodies;
        let ends = |i: usize| {
            let wall = self.walls.get(bodies.entities[i]).ok()?;
            let (middle, half) = (bodies.positions[i], wall.tangent * wall.half_length);
            Some([middle - half, middle + half])
        };
        let lines = bodies.walls.iter().filter(|row| row.is_line());
        lines.filter_map(|row| ends(row.body as usize)).collect()
    }

    fn plates(&self) -> Vec<[DVec2; 2]> {
        let bodies = &*self.bodies;
        let pieces = |row: &WallRow| {
            let middle = bodies.positions[row.body as usize];
            let wall = Wall { tangent: row.tangent(), half_length: row.half_length };
            let points = row.shape.outline(&wall);
            let pieces = points.windows(2).map(|ends| [middle + ends[0], middle + ends[1]]);
            pieces.collect::<Vec<_>>()
        };
        bodies.walls.iter().filter(|row| !row.is_line()).flat_map(pieces).collect()
    }

    fn cracks(&self) -> Vec<Crack> {
        let mode = |state: &BondState| match state {
            BondState::Intact => None,
            BondState::Broken(mode) => Some(*mode),
        };
        let broken =
            self.bonds.iter().filter_map(|(id, bond, state)| Some((*id, bond, mode(state)?)));
        let mut broken: Vec<_> = broken.collect();
        broken.sort_unstable_by_key(|(id, ..)| *id);

        let bodies = &*self.bodies;
        // A removed body has no position.
        let crack = |a: BodyId, b: BodyId, mode| {
            let (a, b) = (bodies.row(a)?, bodies.row(b)?);
            let disk = (bodies.positions[a], *bodies.radii.get(a)?);
            let Some(wall) = bodies.walls.iter().find(|wall| wall.body as usize == b) else {
                let other = (bodies.positions[b], *bodies.radii.get(b)?);
                return Some(Crack::between_disks(disk, other, mode));
            };
            let near = wall.nearest(bodies.positions[b], disk.0);
            Some(Crack::at_wall(disk, disk.0 - near.outward * near.distance, mode))
        };
        broken.into_iter().filter_map(|(_, bond, mode)| crack(bond.a, bond.b, mode)).collect()
    }
}
