//! Membranes at the start of a loading stage: removed, made and given a pressure.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_systems::control_walls::loaded_length;
use clastic_systems::gather_bodies::gather_bodies;
use clastic_systems::membranes::{find_shape, renew_shapes};

use super::wall_controls::reaction;
use super::walls::{find_pair, find_walls, length_between};
use crate::scene::format as scene;

/// The membrane with the given name, if it exists.
pub(crate) fn find_membrane(world: &mut World, name: &str) -> Option<Entity> {
    let mut membranes = world.query::<(Entity, &Membrane)>();
    membranes.iter(world).find(|(_, membrane)| membrane.name == name).map(|(entity, _)| entity)
}

/// Removes, makes and controls the membranes of a stage. A new one starts from its pressure
/// `before`, Pa.
pub(crate) fn control_membranes(
    world: &mut World,
    stage: &scene::Load,
    before: &BTreeMap<String, f64>,
) {
    for name in &stage.remove_membranes {
        if let Some(membrane) = find_membrane(world, name) {
            world.despawn(membrane);
        }
    }
    let mut there = world.query::<&mut Membrane>();
    for mut membrane in there.iter_mut(world) {
        membrane.pressure.0 = membrane.pressure.1;
    }
    for (name, control) in &stage.membranes {
        if let Some(membrane) = find_membrane(world, name) {
            if let Some(mut membrane) = world.get_mut::<Membrane>(membrane) {
                membrane.pressure.1 = control.pressure;
            }
        } else if let Some(membrane) = made(world, name, control, before[name]) {
            world.spawn(membrane);
        }
    }
}

/// The membrane that an entry makes; `None` if one of its walls is not there.
fn made(
    world: &mut World,
    name: &str,
    control: &scene::MembraneControl,
    before: f64,
) -> Option<Membrane> {
    let course = match &control.between {
        None => Course::Closed,
        Some((a, b)) => {
            let [first, second] = find_pair(world, a, b)?;
            Course::Between {
                first: *world.get::<BodyId>(first)?,
                second: *world.get::<BodyId>(second)?,
                sides: control.sides.unwrap_or_default(),
            }
        }
    };
    let pressure = (before, control.pressure);
    Some(Membrane { name: name.to_owned(), pressure, course, ball: control.ball })
}

/// Pressures from which the membranes of a stage start in the place of the walls that it removes, by
/// name, Pa.
pub(crate) fn pressures_before(world: &mut World, stage: &scene::Load) -> BTreeMap<String, f64> {
    let before = |(name, control): (&String, &scene::MembraneControl)| {
        (name.clone(), stress_of(world, &stage.remove_walls, control.between.as_ref()))
    };
    stage.membranes.iter().map(before).collect()
}

/// Mean normal stress of walls, Pa: the stress that they impose, or their reaction over the distance of
/// the two walls `between` which the membrane lies, or over the drawn length. 0 without walls.
fn stress_of(world: &mut World, names: &[String], between: Option<&(String, String)>) -> f64 {
    let walls: Vec<Entity> = names.iter().flat_map(|name| find_walls(world, name)).collect();
    if walls.is_empty() {
        return 0.0;
    }
    let length = length_between(world, between);
    let mut geometry = world.query::<(&Wall, &BodyPosition)>();
    let (world, geometry) = (&*world, geometry.query(world));
    let thickness = world.resource::<ClasticAnalysis>().thickness;
    let stress = |wall: &Entity| match world.get::<WallControl>(*wall) {
        Some(WallControl::Stress { to, .. }) => *to,
        _ => reaction(world, *wall) / (loaded_length(*wall, length, &geometry) * thickness),
    };
    (walls.iter().map(stress).sum::<f64>() / walls.len() as f64).max(0.0)
}

/// Leaves the membranes at the pressures that they have reached.
pub fn end(world: &mut World, progress: &ClasticProgress) {
    let mut membranes = world.query::<&mut Membrane>();
    for mut membrane in membranes.iter_mut(world) {
        membrane.pressure.1 = membrane.ramp(progress).from;
    }
}

/// Finds the chains of all membranes where the bodies are. Gathering the tables does not change the
/// run.
pub(crate) fn renew(world: &mut World) {
    if world.query::<&Membrane>().iter(world).next().is_some() {
        let _ = world.run_system_cached(gather_bodies);
        let _ = world.run_system_cached(renew_shapes);
    }
}

/// A membrane that would find no chain of grains. The stage is refused.
pub fn refusal(world: &mut World, stage: &scene::Load) -> Option<String> {
    if stage.membranes.is_empty() {
        return None;
    }
    let _ = world.run_system_cached(gather_bodies);
    for (name, control) in &stage.membranes {
        if find_membrane(world, name).is_some() {
            continue;
        }
        // A wall that the stage brings in is not there yet.
        let Some(membrane) = made(world, name, control, 0.0) else { continue };
        if find_shape(&membrane, 0.0, world.resource::<BodyTable>()).chains.is_empty() {
            return Some(format!(
                "membrane `{name}` finds no chain of grains from one of its walls to the other; bring the walls closer \
                 than two radii of the ball to the grains, or give a larger `ball`"
            ));
        }
    }
    None
}
