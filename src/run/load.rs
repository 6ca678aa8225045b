//! Loading stages: at the start walls go and come, and walls and particles get their controls; at the
//! end controls of walls end, and loads stay where they are.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use super::script::Script;
use super::settings::analysis;
use super::walls::{find_wall, find_walls, spawn_wall};
use super::{cell, membranes, particle_controls, rigid, wall_controls};
use crate::scene::format as scene;

/// Sets up a loading stage.
pub fn begin(world: &mut World, stage: &scene::Load) {
    let analysis = set_up(world, stage.analysis, stage.gravity, stage.increments);
    let in_increments =
        |s: f64| analysis.kind.dt().map_or_else(|| s * f64::from(stage.increments), |dt| s / dt);
    let course = stage.scale.loads.iter().flatten().map(|(s, share)| [in_increments(*s), *share]);
    world.resource_mut::<ClasticProgress>().course = course.collect();

    let confining = membranes::pressures_before(world, stage);
    for name in &stage.remove_walls {
        for wall in find_walls(world, name) {
            world.despawn(wall);
        }
    }
    for name in &stage.add_walls {
        if find_wall(world, name).is_none() {
            spawn_wall(world, name);
        }
    }
    wall_controls::set(world, stage);
    cell::control(world, stage);
    particle_controls::set(world, stage, &analysis);
    rigid::control_groups(world, stage, &analysis);
    membranes::control_membranes(world, stage, &confining);
}

/// Sets up what a scene defines of every stage that loads, also of those of plugins.
pub(super) fn set_up(
    world: &mut World,
    kind: Option<scene::Analysis>,
    gravity: Option<(f64, f64)>,
    increments: u32,
) -> ClasticAnalysis {
    let scene = &world.resource::<Script>().scene;
    let analysis =
        analysis(scene, kind.unwrap_or(scene.analysis), gravity.unwrap_or(scene.gravity));
    world.insert_resource(analysis);
    world.resource_mut::<ClasticProgress>().total = f64::from(increments);
    analysis
}

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
    cell::end(world);
    membranes::end(world, &progress);
    let mut particles = world.query::<&mut LoadControl>();
    for mut control in particles.iter_mut(world) {
        for (from, to) in &mut control.0 {
            *to = reached(*from, *to);
        }
    }
    let dt = world.resource::<ClasticAnalysis>().kind.dt();
    let mut walls = world.query::<(&mut WallControl, Option<&WallTable>)>();
    for (mut control, table) in walls.iter_mut(world) {
        let value = table.map(|table| table.next(&progress, dt)[0].from);
        *control = match (*control, value) {
            (WallControl::Force { from, to }, _) => {
                WallControl::Force { from, to: reached(from, to) }
            }
            (WallControl::Stress { from, to, length }, _) => {
                WallControl::Stress { from, to: reached(from, to), length }
            }
            (WallControl::Table(of), Some(value)) => match of {
                TableOf::Force => WallControl::Force { from: value, to: value },
                TableOf::Stress(length) => WallControl::Stress { from: value, to: value, length },
                TableOf::Displacement | TableOf::Rotation(_) => WallControl::Fixed,
            },
            (other, _) => other,
        };
    }
    let mut walls = world.query_filtered::<Entity, Or<(With<WallTable>, With<WallSlide>)>>();
    let walls: Vec<_> = walls.iter(world).collect();
    for wall in walls {
        world.entity_mut(wall).remove::<(WallSlide, WallTable)>();
    }
    world.resource_mut::<ClasticProgress>().course.clear();
}
