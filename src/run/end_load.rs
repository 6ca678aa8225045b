//! End of a loading stage: controls of walls that end with it, and loads before their targets.

use bevy_ecs::prelude::*;

use clastic_components::body::LoadControl;
use clastic_components::increment::{AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_components::wall::{TableOf, WallControl, WallSlide, WallTable};

use super::membranes;

/// Ends controls of walls that last for one stage: loads from tables keep the values that they have
/// reached, and lids stop.
pub fn end(world: &mut World) {
    let progress = world.resource::<ClasticProgress>().clone();
    let dt = match world.resource::<ClasticAnalysis>().kind {
        AnalysisKind::Dynamic { dt, .. } => Some(dt),
        AnalysisKind::Static | AnalysisKind::Compaction { .. } => None,
    };
    let mut walls = world.query::<(&mut WallControl, &WallTable)>();
    for (mut control, table) in walls.iter_mut(world) {
        let value = table.next(&progress, dt)[0].x;
        *control = match *control {
            WallControl::Table(TableOf::Force) => WallControl::Force { from: value, to: value },
            WallControl::Table(TableOf::Stress(length)) => {
                WallControl::Stress { from: value, to: value, length }
            }
            WallControl::Table(TableOf::Displacement | TableOf::Rotation(_)) => WallControl::Fixed,
            other => other,
        };
    }
    let mut walls = world.query_filtered::<Entity, Or<(With<WallTable>, With<WallSlide>)>>();
    let walls: Vec<_> = walls.iter(world).collect();
    for wall in walls {
        world.entity_mut(wall).remove::<(WallSlide, WallTable)>();
    }
}

/// Ends the current stage before its loads reach their targets. The next stage starts from the
/// current loads, and keeps those that it does not change.
pub fn end_early(world: &mut World) {
    let progress = world.resource::<ClasticProgress>().clone();
    let reached = |from: f64, to: f64| progress.ramp(from, to).from;
    end(world);
    super::cell::end_early(world);
    let mut walls = world.query::<&mut WallControl>();
    for mut control in walls.iter_mut(world) {
        match &mut *control {
            WallControl::Force { from, to } | WallControl::Stress { from, to, .. } => {
                *to = reached(*from, *to);
            }
            _ => {}
        }
    }
    membranes::end_early(world, &progress);
    let mut particles = world.query::<&mut LoadControl>();
    for mut control in particles.iter_mut(world) {
        for (from, to) in &mut control.0 {
            *to = reached(*from, *to);
        }
    }
}
