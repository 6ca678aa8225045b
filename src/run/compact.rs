//! Compaction (4.4.1 of the paper): rigid, frictionless, static, and of all feasible motions the
//! least.
//!
//! The linearised non-penetration condition is on the safe side (`|x| >= n.x`), so that no
//! increment, however large, makes listed disks overlap.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::body::{
    AngularVelocity, BodyId, ExternalForce, LastMotion, Position, Velocity,
};
use clastic_components::contact::ContactHistory;
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::particle::Particle;
use clastic_components::wall::{Wall, WallControl};

use super::spawn::find_wall;
use crate::scene::format::{Compact, CompactRest, CompactTarget};

/// Sets the walls in motion towards the target, in equal steps.
pub fn begin(world: &mut World, stage: &Compact) {
    let (area, mean_radius) = disks(world);
    world.resource_mut::<Analysis>().kind = AnalysisKind::LeastMotion {
        affine: stage.rest == CompactRest::Affine,
        agitation: stage.agitation * mean_radius,
        seed: stage.seed,
    };
    let (Some(wall), Some(base)) = (find_wall(world, &stage.wall), find_wall(world, &stage.base))
    else {
        return;
    };
    let (height, length) = extent(world, wall, base);
    let mut walls = world.query::<&mut WallControl>();
    for mut control in walls.iter_mut(world) {
        *control = WallControl::Fixed;
    }
    let target = match stage.target {
        CompactTarget::Height(height) => height,
        CompactTarget::Porosity(porosity) => area / ((1.0 - porosity) * length),
    };
    let distance = height - target;
    if distance <= 0.0 {
        return;
    }
    let steps = (distance / stage.step).ceil().max(1.0);
    world.resource_mut::<Progress>().total = steps;
    let inward = world.get::<Wall>(base).map(Wall::inward).unwrap_or_default();
    world.entity_mut(wall).insert(WallControl::Displacement(-inward * (distance / steps)));
}

/// Height (m) and porosity of the packing between the walls of the stage, as its target counts them.
pub fn reached(world: &mut World, stage: &Compact) -> Option<(f64, f64)> {
    let (wall, base) = (find_wall(world, &stage.wall)?, find_wall(world, &stage.base)?);
    let (height, length) = extent(world, wall, base);
    let (area, _) = disks(world);
    Some((height, 1.0 - area / (height * length)))
}

/// Distance of the wall from the base, and length of the base, m.
fn extent(world: &World, wall: Entity, base: Entity) -> (f64, f64) {
    let place = |wall| world.get::<Position>(wall).map(|x| x.0).unwrap_or_default();
    let (inward, length) = world
        .get::<Wall>(base)
        .map_or((DVec2::ZERO, 1.0), |base| (base.inward(), 2.0 * base.half_length));
    ((place(wall) - place(base)).dot(inward), length)
}

/// Total area and mean radius of the particles, summed in identity order.
fn disks(world: &mut World) -> (f64, f64) {
    let mut particles = world.query::<(&BodyId, &Particle)>();
    let mut radii: Vec<_> = particles.iter(world).map(|(id, p)| (*id, p.radius)).collect();
    radii.sort_unstable_by_key(|(id, _)| *id);
    let area = radii.iter().map(|(_, r)| std::f64::consts::PI * r * r).sum();
    let mean = radii.iter().map(|(_, r)| r).sum::<f64>() / radii.len().max(1) as f64;
    (area, mean)
}

/// The packing is at rest and free of stress: forces of the compaction are those of its
/// regularisation and mean nothing.
pub fn end(world: &mut World) {
    world.resource_mut::<ContactHistory>().0.clear();
    let mut bodies = world.query::<(
        &mut LastMotion,
        &mut ExternalForce,
        Option<&mut Velocity>,
        Option<&mut AngularVelocity>,
    )>();
    for (mut motion, mut force, velocity, spin) in bodies.iter_mut(world) {
        *motion = LastMotion::default();
        // A wall that is to be loaded next starts from what it carries: from nothing.
        *force = ExternalForce::default();
        if let Some(mut velocity) = velocity {
            *velocity = Velocity::default();
        }
        if let Some(mut spin) = spin {
            *spin = AngularVelocity::default();
        }
    }
    let mut walls = world.query::<&mut WallControl>();
    for mut control in walls.iter_mut(world) {
        *control = WallControl::Fixed;
    }
}
