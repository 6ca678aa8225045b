//! Particles at one moment to the bit, for tables and porosities.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::body::{BodyOrigin, BodyRotation};
use clastic_components::contact::BodyTable;

/// The particles of a run at one moment, in the order of identities.
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
}

impl Snapshot {
    /// Total area of the disks, m^2.
    pub fn area(&self) -> f64 {
        self.radii.iter().map(|r| std::f64::consts::PI * r * r).sum()
    }

    /// Takes a snapshot of a world whose [`BodyTable`] is up to date, as it is after an increment.
    ///
    /// # Panics
    /// If the world lacks [`ClasticPlugins`](crate::ClasticPlugins).
    pub fn take(world: &mut World) -> Self {
        world
            .run_system_cached(|particles: Particles| particles.snapshot())
            .unwrap_or_else(|error| panic!("{error}"))
    }
}

/// The parts of a world that a [`Snapshot`] shows.
#[derive(SystemParam)]
pub struct Particles<'w, 's> {
    bodies: Res<'w, BodyTable>,
    motions: Query<'w, 's, (&'static BodyRotation, &'static BodyOrigin)>,
}

impl Particles<'_, '_> {
    /// Takes a snapshot. The [`BodyTable`] must be up to date, as it is after an increment.
    pub fn snapshot(&self) -> Snapshot {
        let bodies = &*self.bodies;
        let n = bodies.particles;
        let motion = |i: usize| self.motions.get(bodies.entities[i]).ok();
        let moved =
            |i: usize| motion(i).map_or(DVec2::ZERO, |(_, origin)| bodies.positions[i] - origin.0);
        Snapshot {
            ids: bodies.ids[..n].iter().map(|id| id.0).collect(),
            positions: bodies.positions[..n].to_vec(),
            radii: bodies.radii.clone(),
            rotations: (0..n).map(|i| motion(i).map_or(0.0, |(turn, _)| turn.0)).collect(),
            displacements: (0..n).map(moved).collect(),
        }
    }
}
