//! End of a loading stage: controls of walls that end with it, and loads where they are.

use bevy_ecs::prelude::*;

use clastic_components::body::LoadControl;
use clastic_components::increment::{ClasticAnalysis, ClasticProgress};
use clastic_components::wall::{TableOf, WallControl, WallSlide, WallTable};

use super::membranes;

/// Ends the stage that is under way after the last increment: the next one begins with the next
/// increment.
pub fn end_stage(world: &mut World) {
    end(world);
    let mut progress = world.resource_mut::<ClasticProgress>();
    progress.done = progress.total;
    progress.relaxing = false;
}

/// Ends a loading stage. Loads keep the values that they have reached, which are not their targets
/// where the stage ends early or on another course; lids stop. A second end changes nothing.
pub fn end(world: &mut World) {
    let progress = world.resource::<ClasticProgress>().clone();
    let reached = |from: f64, to: f64| progress.ramp(from, to).from;
    super::cell::end(world);
    let mut walls = world.query::<&mut WallControl>();
    for mut control in walls.iter_mut(world) {
        if let WallControl::Force { from, to } | WallControl::Stress { from, to, .. } =
            &mut *control
        {
            *to = reached(*from, *to);
        }
    }
    membranes::end(world, &progress);
    let mut particles = world.query::<&mut LoadControl>();
    for mut control in particles.iter_mut(world) {
        for (from, to) in &mut control.0 {
            *to = reached(*from, *to);
        }
    }
    let dt = world.resource::<ClasticAnalysis>().kind.dt();
    let mut walls = world.query::<(&mut WallControl, &WallTable)>();
    for (mut control, table) in walls.iter_mut(world) {
        let value = table.next(&progress, dt)[0].from;
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
    world.resource_mut::<ClasticProgress>().course.clear();
}
