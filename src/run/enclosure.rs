//! What encloses the grains of a compaction: the wall and the base, or the periodic cell.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::body::BodyPosition;
use clastic_components::cell::PeriodicCell;
use clastic_components::wall::Wall;

use super::walls::find_wall;
use crate::scene::format::Compact;

/// Area of the cell, or between the walls of the stage over the length of the base, m^2.
pub(super) fn room(world: &mut World, stage: &Compact) -> Option<f64> {
    if let Some(cell) = world.get_resource::<PeriodicCell>() {
        return Some(cell.area());
    }
    let (wall, base) = (find_wall(world, &stage.wall)?, find_wall(world, &stage.base)?);
    let (height, length) = extent(world, wall, base);
    Some(height * length)
}

/// Distance between the wall and the base, and length of the base, m.
pub(super) fn extent(world: &World, wall: Entity, base: Entity) -> (f64, f64) {
    let place = |wall| world.get::<BodyPosition>(wall).map(|x| x.0).unwrap_or_default();
    let (inward, length) = world
        .get::<Wall>(base)
        .map_or((DVec2::ZERO, 1.0), |base| (base.inward(), 2.0 * base.half_length));
    ((place(wall) - place(base)).dot(inward), length)
}
