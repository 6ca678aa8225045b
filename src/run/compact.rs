//! Compaction (4.4.1 of the paper): rigid, frictionless and static, by the smallest feasible
//! motion.
//!
//! The linearised non-penetration condition is safe (`|x| >= n.x`): potential contacts do not
//! overlap after an increment of any size.

use bevy_ecs::prelude::*;

use clastic_components::body::{AngularVelocity, BodyId, ExternalForce, LastMotion, Velocity};
use clastic_components::cell::PeriodicCell;
use clastic_components::contact_history::ContactHistory;
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::particle::Particle;
use clastic_components::wall::{Wall, WallControl};

use super::enclosure::extent;
use super::walls::find_wall;
use super::{cell, grow};
use crate::scene::format::{Compact, CompactBy, CompactRest, CompactTarget};

/// Moves the wall, or grows the radii, towards the target in equal steps.
pub fn begin(world: &mut World, stage: &Compact) {
    let Disks { area, mean_radius, largest } = disks(world);
    world.resource_mut::<Analysis>().kind = AnalysisKind::Compaction {
        affine: stage.rest == CompactRest::Affine,
        agitation: stage.agitation * mean_radius,
        seed: stage.seed,
    };
    if stage.by == CompactBy::Radii {
        hold_walls(world);
        cell::hold(world);
        let factor = grow::factor(world, stage, area).unwrap_or(1.0);
        if factor > 1.0 {
            let steps = ((factor - 1.0) * largest / stage.step).ceil().max(1.0);
            world.resource_mut::<Progress>().total = steps;
        }
        return;
    }
    if let CompactTarget::Porosity(porosity) = stage.target
        && world.contains_resource::<PeriodicCell>()
    {
        if let Some(steps) = cell::compact(world, area, porosity, stage.step) {
            world.resource_mut::<Progress>().total = steps;
        }
        return;
    }
    let (Some(wall), Some(base)) = (find_wall(world, &stage.wall), find_wall(world, &stage.base))
    else {
        return;
    };
    let (height, length) = extent(world, wall, base);
    hold_walls(world);
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

/// Height (m) and porosity of the packing between the walls of the stage, as its target defines
/// them.
pub fn reached(world: &mut World, stage: &Compact) -> Option<(f64, f64)> {
    if let Some(cell) = world.get_resource::<PeriodicCell>().copied() {
        return Some((cell.height, 1.0 - disks(world).area / cell.area()));
    }
    let (wall, base) = (find_wall(world, &stage.wall)?, find_wall(world, &stage.base)?);
    let (height, length) = extent(world, wall, base);
    Some((height, 1.0 - disks(world).area / (height * length)))
}

/// The particles together.
struct Disks {
    /// Total area, m^2.
    area: f64,
    /// Mean radius, m.
    mean_radius: f64,
    /// Maximum radius, m.
    largest: f64,
}

/// Sums are in the order of identities.
fn disks(world: &mut World) -> Disks {
    let mut particles = world.query::<(&BodyId, &Particle)>();
    let mut radii: Vec<_> = particles.iter(world).map(|(id, p)| (*id, p.radius)).collect();
    radii.sort_unstable_by_key(|(id, _)| *id);
    Disks {
        area: radii.iter().map(|(_, r)| std::f64::consts::PI * r * r).sum(),
        mean_radius: radii.iter().map(|(_, r)| r).sum::<f64>() / radii.len().max(1) as f64,
        largest: radii.iter().map(|(_, r)| *r).fold(0.0, f64::max),
    }
}

/// Sets the packing to rest without stress. The forces of the compaction come from its
/// regularisation and have no physical meaning.
pub fn end(world: &mut World) {
    cell::hold(world);
    world.resource_mut::<ContactHistory>().0.clear();
    let mut bodies = world.query::<(
        &mut LastMotion,
        &mut ExternalForce,
        Option<&mut Velocity>,
        Option<&mut AngularVelocity>,
    )>();
    for (mut motion, mut force, velocity, spin) in bodies.iter_mut(world) {
        *motion = LastMotion::default();
        // A later load on a wall starts from the force that the wall carries, which is zero.
        *force = ExternalForce::default();
        if let Some(mut velocity) = velocity {
            *velocity = Velocity::default();
        }
        if let Some(mut spin) = spin {
            *spin = AngularVelocity::default();
        }
    }
    hold_walls(world);
}

fn hold_walls(world: &mut World) {
    let mut walls = world.query::<&mut WallControl>();
    for mut control in walls.iter_mut(world) {
        *control = WallControl::Fixed;
    }
}
