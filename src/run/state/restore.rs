//! From a state to a world that goes on from it.

use bevy_ecs::prelude::*;

use clastic_components::body::BodyId;
use clastic_components::identity::{Identities, NextIdentities};
use clastic_components::observation::Measures;
use clastic_components::particle::Swinging;
use clastic_components::wall::{LoadedLength, WallControl};
use clastic_systems::gather_bodies::gather_bodies;
use clastic_systems::solve_program::Solver;

use super::{ControlState, LengthState, ParticleState, WallState, WorldState};
use crate::run::load::resolve_measures;
use crate::run::spawn::insert_settings;
use crate::run::stages::Script;
use crate::scene::format::Scene;

impl WorldState {
    /// Fills `world` so that [`advance`](crate::run::stages::advance) goes on from this state under
    /// the settings of `scene`. The world must have the resources of
    /// [`ClasticPlugins`](crate::ClasticPlugins) and no bodies.
    pub fn restore(&self, world: &mut World, scene: &Scene) {
        insert_settings(world, scene, self.particles.len() as u32);
        for particle in &self.particles {
            spawn_particle(world, particle);
        }
        let walls: Vec<_> =
            self.walls.iter().map(|wall| (wall.id, spawn_wall(world, wall))).collect();
        // Only now are there entities for all walls that a control may name.
        for (state, (_, entity)) in self.walls.iter().zip(&walls) {
            world.entity_mut(*entity).insert(control(&walls, &state.control));
        }
        for bond in &self.bonds {
            world.spawn(*bond);
        }

        world.insert_resource(self.progress.clone());
        world.insert_resource(self.analysis);
        world.insert_resource(self.observation.clone());
        world.insert_resource(self.ruptures);
        let next = NextIdentities { bond: self.bonds_created, ..Default::default() };
        world.get_resource_or_init::<Identities>().skip_to(next);
        if let Some(ledger) = &self.ledger {
            world.insert_resource(ledger.clone());
        }
        world.insert_resource(self.contacts.clone());
        if let Some(mut solver) = world.get_resource_mut::<Solver>() {
            solver.0.remember(&self.solver);
        }
        world.insert_resource(Script {
            begun: self.script.begun,
            speed: self.script.speed,
            peak: self.script.peak,
            collapse: self.script.collapse.clone(),
            ends: self.script.ends.clone(),
            ..Script::new(scene)
        });
        world.init_resource::<Measures>();
        if self.script.begun {
            resolve_measures(world);
        }
        world.resource_mut::<Measures>().reference = self.reference;
        // Who looks at the world before the next increment looks here.
        let _ = world.run_system_cached(gather_bodies);
    }
}

fn spawn_particle(world: &mut World, p: &ParticleState) {
    let mut entity = world.spawn((
        (p.id, p.particle, p.material),
        (p.position, p.origin, p.rotation, p.velocity, p.angular_velocity, p.last_motion),
        (p.drives, p.load_control, p.applied_load, p.external_force),
    ));
    if p.swinging {
        entity.insert(Swinging);
    }
    if let Some(group) = &p.group {
        entity.insert(group.clone());
    }
    if let Some(probe) = &p.probe {
        entity.insert(probe.clone());
    }
}

fn spawn_wall(world: &mut World, w: &WallState) -> Entity {
    let mut entity = world.spawn((
        (w.id, w.wall, w.law),
        (w.position, w.origin, w.last_motion, w.drive, w.external_force),
    ));
    if let Some(name) = &w.name {
        entity.insert(name.clone());
    }
    if let Some(probe) = &w.probe {
        entity.insert(probe.clone());
    }
    entity.id()
}

fn control(walls: &[(BodyId, Entity)], state: &ControlState) -> WallControl {
    let wall = |id: Option<BodyId>| {
        let found = walls.iter().find(|(wall, _)| Some(*wall) == id);
        found.map_or(Entity::PLACEHOLDER, |(_, entity)| *entity)
    };
    match *state {
        ControlState::Fixed => WallControl::Fixed,
        ControlState::Displacement(u) => WallControl::Displacement(u),
        ControlState::Velocity(v) => WallControl::Velocity(v),
        ControlState::Force(from, to) => WallControl::Force { from, to },
        ControlState::Stress(from, to, length) => {
            let length = match length {
                LengthState::Segment => LoadedLength::Segment,
                LengthState::Between(a, b) => LoadedLength::Between(wall(a), wall(b)),
            };
            WallControl::Stress { from, to, length }
        }
        ControlState::Custom => WallControl::Custom,
    }
}
