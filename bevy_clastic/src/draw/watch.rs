//! Draws the world of the same app, in which the engine makes its increments.

use bevy::app::{App, Plugin, PostUpdate};
use bevy::prelude::*;
use clastic::components::increment::ClasticProgress;
use clastic::prelude::{Particle, Wall};
use clastic::systems::gather_bodies::gather_bodies;

use super::{Drawing, Shown};
use crate::picture::Picture;

/// Takes a picture after every increment of `ClasticPlugins` in the same app, and when bodies have
/// come or gone. Beside [`DrawPlugin`](super::DrawPlugin) this draws the world.
pub struct WatchPlugin;

impl Plugin for WatchPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PostUpdate, watch.before(Drawing));
    }
}

/// What a picture was taken of: increments and numbers of bodies.
#[derive(Default, PartialEq)]
struct Taken(u64, usize, usize);

/// Exclusive, because a picture reads the whole world.
fn watch(
    world: &mut World,
    disks: &mut QueryState<(), With<Particle>>,
    walls: &mut QueryState<(), With<Wall>>,
    mut taken: Local<Taken>,
) {
    let increment = world.resource::<ClasticProgress>().increment;
    let now = Taken(increment, disks.iter(world).count(), walls.iter(world).count());
    if now == *taken {
        return;
    }
    if increment == taken.0 {
        // Bodies that have come since the last increment are not in its tables.
        let _ = world.run_system_cached(gather_bodies);
    }
    let picture = Picture::take(world);
    world.resource_mut::<Shown>().show(picture);
    *taken = now;
}
