//! Stresses that walls keep from the stage before, on the distance of two walls.

use bevy_ecs::prelude::*;

use clastic_components::body::BodyId;
use clastic_components::wall::{LoadedLength, WallControl, WallName};

use crate::scene::format as scene;

/// A wall keeps a stress on the distance of two walls of which the stage removes one. The stage is
/// refused, because the wall would silently lose its load.
pub fn refusal(world: &mut World, stage: &scene::Load) -> Option<String> {
    let mut walls = world.query::<(&BodyId, &WallName, &WallControl)>();
    let mut kept: Vec<_> = walls
        .iter(world)
        .filter_map(|(id, WallName(name), control)| match *control {
            WallControl::Stress { length: LoadedLength::Between(a, b), .. } => {
                Some((*id, name.clone(), [a, b]))
            }
            _ => None,
        })
        .filter(|(_, name, _)| {
            !stage.walls.contains_key(name) && !stage.remove_walls.contains(name)
        })
        .collect();
    kept.sort_unstable_by_key(|(id, ..)| *id);
    kept.into_iter().find_map(|(_, wall, between)| {
        let names = between.map(|wall| world.get::<WallName>(wall).map(|name| name.0.clone()));
        let [Some(a), Some(b)] = names else { return None };
        let gone = [&a, &b].into_iter().find(|name| stage.remove_walls.contains(name))?;
        Some(format!(
            "the stress that wall `{wall}` keeps acts on the distance of walls `{a}` and `{b}`, and \
             remove_walls takes `{gone}` away; give it another control in this stage: \
             `walls: {{ \"{wall}\": Fixed }}`"
        ))
    })
}
