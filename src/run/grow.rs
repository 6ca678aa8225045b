//! Growth of the grains in a compaction [by radii](CompactBy::Radii): radius expansion.
//!
//! In an increment all radii grow by the same factor before contacts are detected, and the overlaps
//! that this makes are offsets of the non-penetration conditions: the smallest motion that obeys
//! them pushes the grains apart. The factor follows from the current radii and from what is left of
//! the stage, so that radii grow linearly and nothing has to be remembered between increments.

use bevy_ecs::prelude::*;

use clastic_components::body::BodyId;
use clastic_components::contact::BodyTable;
use clastic_components::increment::ClasticProgress;
use clastic_components::particle::Particle;

use super::compact::{enclosure, target_porosity};
use super::disks::{Disks, radii};
use super::script::Script;
use crate::scene::format::{Compact, CompactBy, Stage};

/// Run condition: the stage compacts by radii.
pub(super) fn are_growing(script: Option<Res<Script>>, progress: Res<ClasticProgress>) -> bool {
    script.is_some_and(|script| growing(&script, &progress).is_some())
}

fn growing<'a>(script: &'a Script, progress: &ClasticProgress) -> Option<&'a Compact> {
    match script.stage(progress.stage) {
        Some(Stage::Compact(stage)) if stage.by == CompactBy::Radii => Some(stage),
        _ => None,
    }
}

/// Factor that brings the disks to the porosity of the stage.
pub(super) fn factor(world: &mut World, stage: &Compact, disks: &Disks) -> Option<f64> {
    let (height, length) = enclosure(world, stage)?;
    let porosity = target_porosity(stage, disks)?;
    Some(((1.0 - porosity) * (height * length) / disks.area).sqrt())
}

/// Sets the radii of the tables to those at the end of the attempt. Exclusive, because it looks for
/// walls by name.
pub(super) fn grow(world: &mut World) {
    let progress = world.resource::<ClasticProgress>();
    let Some(stage) = growing(world.resource::<Script>(), progress).cloned() else { return };
    let share = (progress.fraction / (progress.total - progress.done)).min(1.0);
    let radii = radii(world);
    let Some(to_target) = factor(world, &stage, &Disks::of(radii.iter().copied())) else { return };
    let now = 1.0 + (to_target - 1.0) * share;
    let mut bodies = world.resource_mut::<BodyTable>();
    for (row, radius) in radii.iter().enumerate() {
        bodies.radii[row] = radius * now;
    }
    bodies.mean_radius = bodies.radii.iter().sum::<f64>() / radii.len().max(1) as f64;
}

/// Gives the particles the radii of a committed attempt. Their density stays.
pub(super) fn keep_radii(
    bodies: Res<BodyTable>,
    particles: Query<(Entity, &BodyId, &Particle)>,
    mut commands: Commands,
) {
    for (entity, id, disk) in &particles {
        let Some(row) = bodies.row(*id) else { continue };
        let radius = bodies.radii[row];
        let grown = (radius / disk.radius).powi(2);
        let (mass, inertia) = (disk.mass * grown, disk.inertia * grown * grown);
        commands.entity(entity).insert(Particle { radius, mass, inertia, ..*disk });
    }
}
