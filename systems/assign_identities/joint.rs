//! A bond between two entities that is free of stress where they are.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use super::IdentityError;

/// The bond between the bodies as they lie in `world`.
pub(super) fn resolve(joint: Joint, world: &World) -> Result<Bond, IdentityError> {
    let Joint { a, b, law } = joint;
    let refuse = |what| IdentityError::Joint { a, b, what };
    let body = |entity| {
        let id = world.get::<BodyId>(entity).copied();
        id.ok_or(refuse("one of them is no body; insert its Particle or Wall first"))
    };
    let (id_a, id_b) = (body(a)?, body(b)?);
    let disk = |entity| {
        let place = world.get::<BodyPosition>(entity).map(|x| x.0).unwrap_or_default();
        world.get::<Particle>(entity).map(|disk| (place, disk.radius))
    };
    if a == b {
        return Err(refuse("a bond joins two bodies, and these are one entity"));
    }
    let (first, second, initial_gap) = match (disk(a), disk(b)) {
        (Some((x, r)), Some((y, s))) => (id_a.min(id_b), id_a.max(id_b), x.distance(y) - r - s),
        (Some((x, r)), None) => (id_a, id_b, height(world, b, x) - r),
        (None, Some((x, r))) => (id_b, id_a, height(world, a, x) - r),
        (None, None) => {
            return Err(refuse(
                "a wall bonds to disks and not to a wall; one of them must have a Particle",
            ));
        }
    };
    Ok(Bond { a: first, b: second, initial_gap, law })
}

/// Distance of a point from a wall, m; negative on the outer side of a line.
fn height(world: &World, wall: Entity, point: DVec2) -> f64 {
    let middle = world.get::<BodyPosition>(wall).map(|x| x.0).unwrap_or_default();
    let shape = world.get::<WallShape>(wall).copied().unwrap_or_default();
    world
        .get::<Wall>(wall)
        .map_or(0.0, |wall| shape.nearest(wall.inward(), wall.half_length, point - middle).distance)
}
