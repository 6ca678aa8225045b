//! Controls of walls in a loading stage.

use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce;
use glam::DVec2;

use clastic_components::body::{BodyExternalForce, BodyId, BodyPosition, LastMotion};
use clastic_components::increment::ClasticAnalysis;
use clastic_components::wall::{
    LoadedLength, TableOf, Wall, WallControl, WallName, WallRotation, WallTable,
};
use clastic_systems::control_walls::loaded_length;
use clastic_systems::measures::stress::as_it_carried;

use super::walls::find_wall;
use crate::scene::format as scene;

/// Sets the controls of all walls for a loading stage. A load starts from the last load of the
/// wall, or from the reaction of a wall that was held or driven.
pub(super) fn set(world: &mut World, stage: &scene::Load) {
    let mut query = world.query_filtered::<(Entity, &BodyId, &WallName), With<Wall>>();
    let mut walls: Vec<_> =
        query.iter(world).map(|(e, id, name)| (*id, e, name.0.clone())).collect();
    walls.sort_unstable_by_key(|(id, ..)| *id);
    let lengths: Vec<_> = walls
        .iter()
        .map(|(_, wall, name)| stress_length(world, *wall, stage.walls.get(name)))
        .collect();
    for ((_, wall, name), (length, metres)) in walls.into_iter().zip(lengths) {
        let before = world.get::<WallControl>(wall).copied().unwrap_or_default();
        let force = |to: f64| {
            let from = match before {
                WallControl::Force { to, .. } => to,
                _ => reaction(world, wall),
            };
            WallControl::Force { from, to }
        };
        let stress = |to: f64| {
            let from = match before {
                WallControl::Stress { to, .. } => to,
                _ => reaction(world, wall) / metres,
            };
            WallControl::Stress { from, to, length }
        };
        let control = match stage.walls.get(&name) {
            None => match before {
                WallControl::Force { to, .. } => WallControl::Force { from: to, to },
                WallControl::Stress { to, length, .. } => {
                    WallControl::Stress { from: to, to, length }
                }
                WallControl::Custom => WallControl::Custom,
                _ => WallControl::Fixed,
            },
            Some(scene::WallControl::Fixed) => WallControl::Fixed,
            Some(scene::WallControl::Displacement(x, y)) => {
                WallControl::Displacement(DVec2::new(*x, *y))
            }
            Some(scene::WallControl::Velocity(x, y)) => WallControl::Velocity(DVec2::new(*x, *y)),
            Some(scene::WallControl::Rotation { about, angle }) => {
                WallControl::Rotation { about: (*about).into(), angle: *angle }
            }
            Some(scene::WallControl::Spin { about, angular_velocity }) => {
                WallControl::Spin { about: (*about).into(), rate: *angular_velocity }
            }
            Some(scene::WallControl::Force(to)) => force(*to),
            Some(scene::WallControl::Stress { stress: to, .. }) => stress(*to),
            Some(scene::WallControl::Lid { load: scene::LidLoad::Force(to), .. }) => force(*to),
            Some(scene::WallControl::Lid {
                load: scene::LidLoad::Stress { stress: to, .. },
                ..
            }) => stress(*to),
            Some(scene::WallControl::Follow(table)) => WallControl::Table(match table {
                scene::Table::Displacement(_) => TableOf::Displacement,
                scene::Table::Force(_) => TableOf::Force,
                scene::Table::Rotation { about, .. } => TableOf::Rotation((*about).into()),
                scene::Table::Stress { .. } => TableOf::Stress(length),
            }),
            Some(scene::WallControl::Custom) => WallControl::Custom,
        };
        let mut entity = world.entity_mut(wall);
        entity.insert(control);
        match stage.walls.get(&name) {
            Some(scene::WallControl::Lid { slide, .. }) => {
                entity.insert(*slide);
            }
            Some(scene::WallControl::Follow(table)) => {
                entity.insert(points(table));
                if let scene::Table::Rotation { .. } = table {
                    entity.entry::<WallRotation>().or_default();
                }
            }
            Some(scene::WallControl::Rotation { .. } | scene::WallControl::Spin { .. }) => {
                entity.entry::<WallRotation>().or_default();
            }
            _ => {}
        }
    }
}

fn points(table: &scene::Table) -> WallTable {
    WallTable(match table {
        scene::Table::Displacement(list) => list.iter().map(|(s, x, y)| [*s, *x, *y]).collect(),
        scene::Table::Force(list)
        | scene::Table::Stress { stress: list, .. }
        | scene::Table::Rotation { angle: list, .. } => {
            list.iter().map(|(s, value)| [*s, *value, 0.0]).collect()
        }
    })
}

/// Length that a stress control acts on, in m, times the thickness.
fn stress_length(
    world: &mut World,
    wall: Entity,
    control: Option<&scene::WallControl>,
) -> (LoadedLength, f64) {
    let Some(between) = control.and_then(scene::WallControl::loaded_between) else {
        return (LoadedLength::Segment, 1.0);
    };
    let between = between.and_then(|(a, b)| Some((find_wall(world, a)?, find_wall(world, b)?)));
    let length = between.map_or(LoadedLength::Segment, |(a, b)| LoadedLength::Between(a, b));
    let measure =
        move |geometry: Query<(&Wall, &BodyPosition)>| loaded_length(wall, length, &geometry);
    let metres = world.run_system_once(measure).unwrap_or(1.0);
    (length, metres * world.resource::<ClasticAnalysis>().thickness)
}

/// Force of the wall on the specimen along its inward normal, N. The load of a wall that was held
/// starts from this value. A wall that turned has forces along the normals at the start of its last
/// increment, along which its contacts carried; along its present normal the friction would have a
/// part in proportion to the angle.
fn reaction(world: &World, wall: Entity) -> f64 {
    let (Some(wall), Some(force), Some(motion)) = (
        world.get::<Wall>(wall),
        world.get::<BodyExternalForce>(wall),
        world.get::<LastMotion>(wall),
    ) else {
        return 0.0;
    };
    DVec2::new(force.0[0], force.0[1]).dot(as_it_carried(wall, motion).inward())
}
