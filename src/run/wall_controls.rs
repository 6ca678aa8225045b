//! Controls of walls in a loading stage.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::body::{BodyExternalForce, BodyId, BodyPosition, LastMotion};
use clastic_components::increment::ClasticAnalysis;
use clastic_components::wall::{
    LoadedLength, TableOf, Wall, WallControl, WallName, WallRotation, WallTable,
};
use clastic_systems::control_walls::loaded_length;
use clastic_systems::measures::stress::as_it_carried;

use super::walls::length_between;
use crate::scene::format::{LidLoad, Load, Table, WallControl as Wanted};

/// Sets the controls of all walls for a loading stage. A load starts from the last load of the
/// wall, or from the reaction of a wall that was held or driven.
pub(super) fn set(world: &mut World, stage: &Load) {
    let mut query = world.query_filtered::<(Entity, &BodyId, &WallName), With<Wall>>();
    let ordered = query.iter(world).sort_unstable::<&BodyId>();
    let walls: Vec<_> = ordered.map(|(wall, _, name)| (wall, stage.walls.get(&name.0))).collect();
    for (wall, wanted) in walls {
        let (length, metres) = stress_length(world, wall, wanted);
        let before = world.get::<WallControl>(wall).copied().unwrap_or_default();
        let control = match wanted {
            None => match before {
                WallControl::Force { to, .. } => WallControl::Force { from: to, to },
                WallControl::Stress { to, length, .. } => {
                    WallControl::Stress { from: to, to, length }
                }
                WallControl::Custom => WallControl::Custom,
                _ => WallControl::Fixed,
            },
            Some(&(Wanted::Force(to) | Wanted::Lid { load: LidLoad::Force(to), .. })) => {
                let from = match before {
                    WallControl::Force { to, .. } => to,
                    _ => reaction(world, wall),
                };
                WallControl::Force { from, to }
            }
            Some(
                &(Wanted::Stress { stress: to, .. }
                | Wanted::Lid { load: LidLoad::Stress { stress: to, .. }, .. }),
            ) => {
                let from = match before {
                    WallControl::Stress { to, .. } => to,
                    _ => reaction(world, wall) / metres,
                };
                WallControl::Stress { from, to, length }
            }
            Some(Wanted::Follow(table)) => WallControl::Table(match table {
                Table::Displacement(_) => TableOf::Displacement,
                Table::Force(_) => TableOf::Force,
                Table::Rotation { about, .. } => TableOf::Rotation((*about).into()),
                Table::Stress { .. } => TableOf::Stress(length),
            }),
            Some(Wanted::Custom) => WallControl::Custom,
            Some(other) => motion(other).unwrap_or(WallControl::Fixed),
        };
        let mut entity = world.entity_mut(wall);
        entity.insert(control);
        match wanted {
            Some(Wanted::Lid { slide, .. }) => _ = entity.insert(*slide),
            Some(Wanted::Follow(table)) => _ = entity.insert(points(table)),
            _ => {}
        }
        if let WallControl::Rotation { .. }
        | WallControl::Spin { .. }
        | WallControl::Table(TableOf::Rotation(_)) = control
        {
            entity.entry::<WallRotation>().or_default();
        }
    }
}

/// Control of a wall with imposed motion; `None` for other controls.
pub(super) fn motion(control: &Wanted) -> Option<WallControl> {
    match *control {
        Wanted::Displacement(x, y) => Some(WallControl::Displacement(DVec2::new(x, y))),
        Wanted::Velocity(x, y) => Some(WallControl::Velocity(DVec2::new(x, y))),
        Wanted::Rotation { about, angle } => {
            Some(WallControl::Rotation { about: about.into(), angle })
        }
        Wanted::Spin { about, angular_velocity } => {
            Some(WallControl::Spin { about: about.into(), rate: angular_velocity })
        }
        _ => None,
    }
}

fn points(table: &Table) -> WallTable {
    WallTable(match table {
        Table::Displacement(list) => list.iter().map(|(s, x, y)| [*s, *x, *y]).collect(),
        Table::Force(list)
        | Table::Stress { stress: list, .. }
        | Table::Rotation { angle: list, .. } => {
            list.iter().map(|(s, value)| [*s, *value, 0.0]).collect()
        }
    })
}

/// Length that a stress control acts on, in m, times the thickness.
fn stress_length(world: &mut World, wall: Entity, control: Option<&Wanted>) -> (LoadedLength, f64) {
    let Some(between) = control.and_then(Wanted::loaded_between) else {
        return (LoadedLength::Segment, 1.0);
    };
    let length = length_between(world, between);
    let mut geometry = world.query::<(&Wall, &BodyPosition)>();
    let metres = loaded_length(wall, length, &geometry.query(world));
    (length, metres * world.resource::<ClasticAnalysis>().thickness)
}

/// Force of the wall on the specimen along its inward normal, N. The load of a wall that was held
/// starts from this value. A wall that turned has forces along the normals at the start of its last
/// increment, along which its contacts carried; along its present normal the friction would have a
/// part in proportion to the angle.
pub fn reaction(world: &World, wall: Entity) -> f64 {
    let (Some(wall), Some(force), Some(motion)) = (
        world.get::<Wall>(wall),
        world.get::<BodyExternalForce>(wall),
        world.get::<LastMotion>(wall),
    ) else {
        return 0.0;
    };
    DVec2::new(force.0[0], force.0[1]).dot(as_it_carried(wall, motion).inward())
}
