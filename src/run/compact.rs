//! Compaction (4.4.1 of the paper): rigid, frictionless and static, by the smallest feasible
//! motion.
//!
//! The linearised non-penetration condition is safe (`|x| >= n.x`): potential contacts do not
//! overlap after an increment of any size.

use bevy_ecs::prelude::*;

use clastic_components::body::{
    BodyAngularVelocity, BodyExternalForce, BodyId, BodyVelocity, LastMotion,
};
use clastic_components::cell::PeriodicCell;
use clastic_components::contact_history::ContactHistory;
use clastic_components::increment::{AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_components::particle::Particle;
use clastic_components::wall::{Wall, WallControl};

use super::densest::lowest_porosity;
use super::enclosure::{extent, room};
use super::walls::find_wall;
use super::{cell, grow};
use crate::scene::format::{Compact, CompactBy, CompactRest, CompactTarget};

/// Moves the wall, or grows the radii, towards the target in equal steps.
pub fn begin(world: &mut World, stage: &Compact) {
    let Disks { area, mean_radius, largest, .. } = disks(world);
    world.resource_mut::<ClasticAnalysis>().kind = AnalysisKind::Compaction {
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
            world.resource_mut::<ClasticProgress>().total = steps;
        }
        return;
    }
    if world.contains_resource::<PeriodicCell>()
        && let Some(porosity) = target_porosity(world, stage)
    {
        if let Some(steps) = cell::compact(world, area, porosity, stage.step) {
            world.resource_mut::<ClasticProgress>().total = steps;
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
        CompactTarget::Porosity(_) | CompactTarget::Jammed => {
            let porosity = target_porosity(world, stage).unwrap_or_default();
            area / ((1.0 - porosity) * length)
        }
    };
    let distance = height - target;
    if distance <= 0.0 {
        return;
    }
    let steps = (distance / stage.step).ceil().max(1.0);
    world.resource_mut::<ClasticProgress>().total = steps;
    let inward = world.get::<Wall>(base).map(Wall::inward).unwrap_or_default();
    world.entity_mut(wall).insert(WallControl::Displacement(-inward * (distance / steps)));
}

/// Porosity at which the motion of a compaction would end: of a packing that is to jam one that it
/// cannot have.
pub(super) fn target_porosity(world: &mut World, stage: &Compact) -> Option<f64> {
    match stage.target {
        CompactTarget::Height(_) => None,
        CompactTarget::Porosity(porosity) => Some(porosity),
        CompactTarget::Jammed => {
            let Disks { smallest, largest, .. } = disks(world);
            Some(lowest_porosity(smallest / largest))
        }
    }
}

/// What a packing has reached.
pub struct Reached {
    /// Height between the walls of the stage or of the cell, m.
    pub height: f64,
    /// Mean radius, m.
    pub mean_radius: f64,
    /// Porosity there.
    pub porosity: f64,
}

/// The same quantity after the last committed increment.
pub fn reached(world: &mut World, stage: &Compact) -> Option<Reached> {
    let room = room(world, stage)?;
    let height = match world.get_resource::<PeriodicCell>() {
        Some(cell) => cell.height,
        None => {
            let (wall, base) = (find_wall(world, &stage.wall)?, find_wall(world, &stage.base)?);
            extent(world, wall, base).0
        }
    };
    let Disks { area, mean_radius, .. } = disks(world);
    Some(Reached { height, mean_radius, porosity: 1.0 - area / room })
}

/// Why a compaction to a porosity cannot begin: no disks of these radii are as dense.
pub(super) fn refusal(world: &mut World, stage: &Compact) -> Option<String> {
    let CompactTarget::Porosity(target) = stage.target else { return None };
    let Disks { smallest, largest, .. } = disks(world);
    let lowest = lowest_porosity(smallest / largest);
    (target < lowest).then(|| {
        format!(
            "a porosity of {target:?} is below {lowest:.4}, the minimum of disks between \
             {smallest:.3e} and {largest:.3e} m in radius in the plane (Florian 1960); random \
             packings jam near 0.16"
        )
    })
}

/// The particles together.
struct Disks {
    /// Total area, m^2.
    area: f64,
    /// Mean radius, m.
    mean_radius: f64,
    /// Minimum radius, m.
    smallest: f64,
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
        smallest: radii.iter().map(|(_, r)| *r).fold(f64::INFINITY, f64::min),
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
        &mut BodyExternalForce,
        Option<&mut BodyVelocity>,
        Option<&mut BodyAngularVelocity>,
    )>();
    for (mut motion, mut force, velocity, spin) in bodies.iter_mut(world) {
        *motion = LastMotion::default();
        // A later load on a wall starts from the force that the wall carries, which is zero.
        *force = BodyExternalForce::default();
        if let Some(mut velocity) = velocity {
            *velocity = BodyVelocity::default();
        }
        if let Some(mut spin) = spin {
            *spin = BodyAngularVelocity::default();
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
