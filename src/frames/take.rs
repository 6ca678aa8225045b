//! A frame of a world.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;

use clastic_components::prelude::*;

use super::pairs::Pair;
use super::{Frame, FrameBodies, FrameMembranes, FrameWalls, NONE, pairs};

/// The parts of a world that a [`Frame`] shows.
#[derive(SystemParam)]
pub struct FrameTables<'w, 's> {
    bodies: Res<'w, BodyTable>,
    history: Res<'w, ContactHistory>,
    kept: Res<'w, KeptRows>,
    analysis: Res<'w, ClasticAnalysis>,
    materials: Res<'w, Materials>,
    observation: Res<'w, Observation>,
    progress: Res<'w, ClasticProgress>,
    cell: Option<Res<'w, PeriodicCell>>,
    bonds: Query<'w, 's, (&'static BondId, &'static Bond, &'static BondState)>,
    origins: Query<'w, 's, (&'static BodyOrigin, Option<&'static Group>)>,
    walls: Query<'w, 's, (Option<&'static WallName>, &'static BodyExternalForce)>,
    membranes: Query<'w, 's, (&'static Membrane, &'static MembraneShape)>,
}

impl Frame {
    /// Takes a frame of a world whose [`BodyTable`] is up to date, as it is after an increment.
    ///
    /// # Panics
    /// If the world lacks [`ClasticPlugins`](crate::ClasticPlugins).
    pub fn take(world: &mut World) -> Self {
        world
            .run_system_cached(|tables: FrameTables| tables.frame())
            .unwrap_or_else(|error| panic!("{error}"))
    }
}

impl FrameTables<'_, '_> {
    /// Takes a frame. The [`BodyTable`] must be up to date, as it is after an increment.
    pub fn frame(&self) -> Frame {
        let bodies = &*self.bodies;
        let bonds = self.bonds.iter();
        let bonds = bonds.map(|(id, bond, state)| ((bond.a, bond.b), id.0, pairs::code(*state)));
        let all = pairs::pairs(bodies, &self.kept, &self.history, bonds);
        let observation = &*self.observation;
        let origin = middle(bodies);
        let (group, groups) = self.groups();
        Frame {
            // An increment that was not committed counts in the record alone, and a run that goes
            // on from a saved state has no record yet.
            increment: observation.increment.max(self.progress.increment),
            stage: observation.stage.clone(),
            time_s: self.progress.time,
            thickness_m: self.analysis.thickness,
            axial_strain: observation.axial_strain,
            axial_stress_pa: observation.axial_stress,
            origin_m: origin.to_array(),
            cell_m: self.cell.as_ref().map(|cell| [cell.width, cell.height, cell.tilt]),
            materials: self.materials.0.iter().map(|material| material.name.clone()).collect(),
            groups,
            bodies: self.particles(origin, group, &all),
            pairs: pairs::columns(&all),
            walls: self.walls(),
            membranes: self.chains(),
        }
    }

    fn particles(&self, origin: DVec2, group: Vec<u32>, all: &[Pair]) -> FrameBodies {
        let bodies = &*self.bodies;
        let n = bodies.particles;
        let vector = |v: DVec2| v.as_vec2().to_array();
        let displacement = |i: usize| {
            let from = self.origins.get(bodies.entities[i]);
            from.map_or(DVec2::ZERO, |(from, _)| bodies.positions[i] - from.0)
        };
        let numbers = |values: &[f64]| values[..n].iter().map(|v| *v as f32).collect();
        FrameBodies {
            id: bodies.ids[..n].iter().map(|id| id.0).collect(),
            offset_m: bodies.positions[..n].iter().map(|x| vector(*x - origin)).collect(),
            radius_m: numbers(&bodies.radii),
            displacement_m: (0..n).map(|i| vector(displacement(i))).collect(),
            rotation_rad: numbers(&bodies.rotations),
            velocity_m_s: bodies.velocities[..n].iter().map(|v| vector(*v)).collect(),
            angular_velocity_rad_s: numbers(&bodies.angular_velocities),
            material: bodies.materials[..n].to_vec(),
            group,
            stress_pa: pairs::stresses(bodies, all, self.analysis.thickness),
            fragment: pairs::fragments(bodies, all),
        }
    }

    /// Index of the group of every particle, and the names in the order of the alphabet.
    fn groups(&self) -> (Vec<u32>, Vec<String>) {
        let group = |entity: &Entity| Some(self.origins.get(*entity).ok()?.1?.0.as_str());
        let entities = &self.bodies.entities[..self.bodies.particles];
        let mut names: Vec<&str> = entities.iter().filter_map(group).collect();
        names.sort_unstable();
        names.dedup();
        let index = |entity| names.binary_search(&group(entity)?).ok();
        let indices = entities.iter().map(|entity| index(entity).map_or(NONE, |k| k as u32));
        (indices.collect(), names.iter().map(|name| (*name).to_owned()).collect())
    }

    fn chains(&self) -> FrameMembranes {
        let list = self.membranes.iter().sort_unstable_by::<&Membrane>(|a, b| a.name.cmp(&b.name));
        let mut columns = FrameMembranes { first_point: vec![0], ..FrameMembranes::default() };
        for (membrane, shape) in list {
            for chain in &shape.chains {
                columns.name.push(membrane.name.clone());
                columns.is_closed.push(chain.closed);
                columns.body.extend(chain.bodies.iter().map(|id| id.0));
                columns.point_m.extend(chain.points.iter().map(DVec2::to_array));
                columns.first_point.push(columns.body.len() as u32);
            }
        }
        columns
    }

    fn walls(&self) -> FrameWalls {
        let bodies = &*self.bodies;
        let mut walls = FrameWalls { first_point: vec![0], ..FrameWalls::default() };
        for row in &bodies.walls {
            let body = row.body as usize;
            let (name, force) = self.walls.get(bodies.entities[body]).ok().unzip();
            walls.id.push(bodies.ids[body].0);
            walls.name.push(name.flatten().map(|name| name.0.clone()).unwrap_or_default());
            walls.is_thin.push(!row.is_line());
            walls.force.push(force.map_or([0.0; 3], |force| force.0));
            let wall = Wall { tangent: row.tangent(), half_length: row.half_length };
            let points = row.shape.outline(&wall).into_iter();
            walls.point_m.extend(points.map(|x| (bodies.positions[body] + x).to_array()));
            walls.first_point.push(walls.point_m.len() as u32);
        }
        walls
    }
}

/// Middle of the box around the centres of the particles, m: from there offsets are shortest.
fn middle(bodies: &BodyTable) -> DVec2 {
    let centres = bodies.positions[..bodies.particles].iter().map(|x| (*x, *x));
    let around = centres.reduce(|(low, high), (x, _)| (low.min(x), high.max(x)));
    around.map_or(DVec2::ZERO, |(low, high)| 0.5 * (low + high))
}
