//! Start of a loading stage: removed and added walls, controls of walls and particles.

use bevy_ecs::prelude::*;

use clastic_components::increment::{ClasticAnalysis, ClasticProgress};
use clastic_components::step_control::StepControl;

use super::script::Script;
use super::settings::analysis;
use super::walls::{find_wall, find_walls, spawn_wall};
use super::{membranes, particle_controls, rigid, wall_controls};
use crate::scene::format as scene;

/// Sets up a loading stage.
pub fn begin(world: &mut World, stage: &scene::Load) {
    let analysis = set_up(world, stage.analysis, stage.gravity, stage.increments);
    let in_increments =
        |s: f64| analysis.kind.dt().map_or_else(|| s * f64::from(stage.increments), |dt| s / dt);
    let course = stage.scale.loads.iter().flatten().map(|(s, share)| [in_increments(*s), *share]);
    world.resource_mut::<ClasticProgress>().course = course.collect();
    if let Some(accuracy) = stage.accuracy {
        world.insert_resource(StepControl::new(accuracy));
    }

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
    super::cell::control(world, stage);
    particle_controls::set(world, stage, &analysis);
    rigid::control_groups(world, stage, &analysis);
    membranes::control_membranes(world, stage, &confining);
}

/// Sets up the part of a plugin's stage that the scene defines. The systems of the plugin do the
/// rest.
pub fn begin_custom(world: &mut World, stage: &scene::CustomStage) {
    set_up(world, stage.analysis, stage.gravity, stage.increments);
}

fn set_up(
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
