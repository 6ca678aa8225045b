//! Gathers bodies, intact bonds, controls and the memory of contacts from the world into tables by identity.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::body::{
    AngularVelocity, AppliedLoad, BodyId, Drives, LastMotion, Position, Rotation, Velocity,
};
use clastic_components::bond::{Bond, BondId, BondState};
use clastic_components::contact::{Bodies, BondRow, ContactHistory, DraftHistory, WallRow};
use clastic_components::material::ContactLaw;
use clastic_components::particle::{MaterialIndex, Particle, Swinging};
use clastic_components::wall::{Wall, WallControl, WallDrive};

use crate::schedule::{Increment, IncrementSystems};

/// Adds [`gather_bodies`] and [`draft_history`].
pub struct GatherBodiesPlugin;

impl Plugin for GatherBodiesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Bodies>()
            .init_resource::<ContactHistory>()
            .init_resource::<DraftHistory>()
            .add_systems(
                Increment,
                (gather_bodies, draft_history).chain().in_set(IncrementSystems::Gather),
            );
    }
}

type ParticleQuery<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static BodyId,
        &'static Particle,
        &'static Position,
        &'static Rotation,
        &'static Velocity,
        &'static AngularVelocity,
        &'static LastMotion,
        &'static MaterialIndex,
        &'static Drives,
        &'static AppliedLoad,
        Has<Swinging>,
    ),
>;

type WallQuery<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static BodyId,
        &'static Wall,
        &'static Position,
        &'static LastMotion,
        &'static ContactLaw,
        &'static WallControl,
        &'static WallDrive,
    ),
>;

/// Fills [`Bodies`]. Ids of particles are dense from 0; walls follow, and a wall that has been
/// taken away leaves an unused entry.
pub fn gather_bodies(
    mut bodies: ResMut<Bodies>,
    particles: ParticleQuery,
    walls: WallQuery,
    bonds: Query<(Entity, &BondId, &Bond, &BondState)>,
) {
    let bodies = &mut *bodies;
    let n = particles.iter().len();
    let all = walls.iter().map(|w| w.1.index() + 1).max().unwrap_or(n).max(n);
    bodies.particles = n;
    bodies.entities.clear();
    bodies.entities.resize(all, Entity::PLACEHOLDER);
    // A wall that was taken away must leave nothing behind: its last motion would go on setting the
    // scale of displacements.
    bodies.positions.clear();
    bodies.positions.resize(all, DVec2::ZERO);
    bodies.rotations.resize(n, 0.0);
    bodies.velocities.resize(all, DVec2::ZERO);
    bodies.angular_velocities.resize(all, 0.0);
    bodies.last_motion.clear();
    bodies.last_motion.resize(all, [0.0; 3]);
    bodies.radii.resize(n, 0.0);
    bodies.masses.resize(n, 0.0);
    bodies.inertias.resize(n, 0.0);
    bodies.materials.resize(n, 0);
    bodies.drives.resize(n, Default::default());
    bodies.loads.resize(n, Default::default());
    bodies.swinging.resize(n, false);
    for (
        entity,
        id,
        particle,
        position,
        rotation,
        velocity,
        spin,
        motion,
        material,
        drives,
        load,
        swinging,
    ) in &particles
    {
        let i = id.index();
        bodies.entities[i] = entity;
        bodies.positions[i] = position.0;
        bodies.rotations[i] = rotation.0;
        bodies.velocities[i] = velocity.0;
        bodies.angular_velocities[i] = spin.0;
        bodies.last_motion[i] = motion.0;
        bodies.radii[i] = particle.radius;
        bodies.masses[i] = particle.mass;
        bodies.inertias[i] = particle.inertia;
        bodies.materials[i] = material.0;
        bodies.drives[i] = drives.0;
        bodies.loads[i] = load.0;
        bodies.swinging[i] = swinging;
    }
    bodies.mean_radius = if n == 0 { 1.0 } else { bodies.radii.iter().sum::<f64>() / n as f64 };

    bodies.walls.clear();
    for (entity, id, wall, position, motion, law, control, drive) in &walls {
        let i = id.index();
        bodies.entities[i] = entity;
        bodies.positions[i] = position.0;
        bodies.last_motion[i] = motion.0;
        bodies.walls.push(WallRow {
            body: id.0,
            inward: wall.inward(),
            half_length: wall.half_length,
            law: *law,
            control: *control,
            drive: *drive,
        });
    }
    bodies.walls.sort_unstable_by_key(|w| w.body);

    bodies.broken.clear();
    bodies.resting = false;
    bodies.bonds.clear();
    bodies.bonds.extend(bonds.iter().filter(|(.., state)| **state == BondState::Intact).map(
        |(entity, id, bond, _)| BondRow {
            id: *id,
            entity,
            a: bond.a.0,
            b: bond.b.0,
            initial_gap: bond.initial_gap,
            law: bond.law,
        },
    ));
    bodies.bonds.sort_unstable_by_key(|b| (b.a, b.b));
}

/// Starts the draft of the contact memory from what the last increment left.
pub fn draft_history(history: Res<ContactHistory>, mut draft: ResMut<DraftHistory>) {
    draft.0.clone_from(&history);
}
