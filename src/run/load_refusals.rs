//! Why a loading stage cannot begin: selections without particles, walls where particles are or
//! behind which they lie, stresses on lengths that end.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use glam::DVec2;

use super::cement::intact;
use super::script::Script;
use super::select::selected;
use super::touching::placed;
use super::wall_pieces::{CUT, is_cut};
use super::walls::WallCatalogue;
use super::{membranes, rigid};
use crate::scene::format as scene;
use crate::scene::validate::is_behind;
use crate::text::shown::label;

/// Why a loading stage cannot begin; `None` if it can.
pub fn refusal(world: &mut World, stage: &scene::Load) -> Option<String> {
    selects_nothing(world, stage)
        .or_else(|| releases_nothing(world, stage))
        .or_else(|| cuts_through(world, stage))
        .or_else(|| leaves_behind(world, stage))
        .or_else(|| meets_nothing(world, stage))
        .or_else(|| loses_its_length(world, stage))
        .or_else(|| breaks_too_many(world, stage))
        .or_else(|| rigid::refusal(world, stage))
        .or_else(|| membranes::refusal(world, stage))
}

/// An entry of `particles` that selects no particle. The stage is refused, because without this
/// entry the results would be those of another scene.
fn selects_nothing(world: &mut World, stage: &scene::Load) -> Option<String> {
    let k = stage.particles.iter().position(|c| selected(world, &c.select).is_empty())?;
    Some(format!("particles[{k}].select {}", selects_none(&stage.particles[k].select)))
}

/// A stop at more broken bonds than there are. The stage is refused, because it would never hold.
fn breaks_too_many(world: &mut World, stage: &scene::Load) -> Option<String> {
    let broken = world.get_resource::<RuptureCount>().copied().unwrap_or_default().0;
    let intact = intact(world);
    let scene = &world.resource::<Script>().scene;
    stage.stop.iter().enumerate().find_map(|(k, stop)| {
        let (scene::Stop::Above(name, value) | scene::Stop::Until(name, value)) = stop else {
            return None;
        };
        let Some(Quantity::Broken(modes)) = scene.measure(name) else { return None };
        let most = intact + broken[modes.places()].iter().sum::<usize>();
        (*value > most as f64).then(|| {
            format!(
                "stop[{k}] can never hold: it is at {value:?} broken bonds, and there are {most} bonds; give a \
                 smaller number, or a `BrokenShare`"
            )
        })
    })
}

/// An entry of `particles` that releases loads of particles which have none.
fn releases_nothing(world: &mut World, stage: &scene::Load) -> Option<String> {
    let k = stage.particles.iter().position(|control| {
        let selected = selected(world, &control.select);
        let mut loads = selected.iter().filter_map(|(_, entity)| world.get::<LoadControl>(*entity));
        control.remains.is_some() && loads.all(|load| load.0.iter().all(|(_, now)| *now == 0.0))
    })?;
    Some(format!(
        "particles[{k}].remains is for loads, and the selected particles have none; load them before \
         (`Remove` with `keep_tractions: true`, `force`, `moment`)"
    ))
}

/// That a selection has no particle, and what to do.
pub(super) fn selects_none(select: &scene::Select) -> String {
    let select = label(&format!("{select:?}"));
    format!(
        "selects no particle: none is in {select}; give one that has some where they are by then"
    )
}

/// The walls that a stage adds: those that come at the outermost particles, or the others.
fn added(world: &World, stage: &scene::Load, touching: bool) -> Vec<scene::Wall> {
    let comes =
        |wall: &&scene::Wall| stage.add_walls.contains(&wall.name) && wall.touching == touching;
    world.resource::<WallCatalogue>().walls.iter().filter(comes).cloned().collect()
}

/// The first wall that a stage adds where it should not, by `is_wrong` of it and a disk, and the particles there.
fn added_on(
    world: &mut World,
    stage: &scene::Load,
    is_wrong: impl Fn(&scene::Wall, DVec2, f64) -> bool,
) -> Option<(String, Vec<BodyId>)> {
    let walls = added(world, stage, false);
    let mut particles = world.query::<(&BodyId, &Particle, &BodyPosition)>();
    walls.into_iter().find_map(|wall| {
        let all = particles.iter(world).sort_unstable::<&BodyId>();
        let there = all.filter(|(_, of, x)| is_wrong(&wall, x.0, of.radius));
        let there: Vec<_> = there.map(|(id, ..)| *id).collect();
        Some((wall.name, there)).filter(|(_, there)| !there.is_empty())
    })
}

/// A wall that comes where a particle is. The stage is refused, because the side of the particle from a
/// thin wall is not clear, and a line would press on it with half of its stiffness times its radius.
fn cuts_through(world: &mut World, stage: &scene::Load) -> Option<String> {
    let (wall, there) = added_on(world, stage, is_cut)?;
    Some(format!(
        "wall `{wall}` of add_walls would cut through particle {}, whose centre is within {CUT:?} radii of it; \
         add it where there is room",
        there[0].0
    ))
}

/// A wall that is to touch the outermost particle and meets none on its way.
fn meets_nothing(world: &mut World, stage: &scene::Load) -> Option<String> {
    let wall = added(world, stage, true).into_iter().find(|wall| placed(world, wall).is_none())?;
    Some(format!(
        "wall `{}` of add_walls is to touch the outermost particle, and meets \
         none on its way along its inward normal; draw it where particles are in its way",
        wall.name
    ))
}

/// A wall that comes with particles behind it, as one does that is drawn from its end to its start.
/// The stage is refused, because it would push them through the wall in one increment.
fn leaves_behind(world: &mut World, stage: &scene::Load) -> Option<String> {
    let behind = |wall: &scene::Wall, x: DVec2, radius| is_behind(wall, x.into(), radius);
    let (wall, there) = added_on(world, stage, behind)?;
    let number =
        if let [_] = there[..] { "a particle" } else { &format!("{} particles", there.len()) };
    Some(format!(
        "wall `{wall}` of add_walls comes with {number} behind it; a wall has its inside on the left of start to \
         end; exchange them, or take such particles away before (`Remove`)"
    ))
}

/// A wall keeps a stress on the distance of two walls of which the stage removes one. The stage is
/// refused, because the wall would silently lose its load.
fn loses_its_length(world: &mut World, stage: &scene::Load) -> Option<String> {
    let mut walls = world.query::<(&BodyId, &WallName, &WallControl)>();
    walls.iter(world).sort_unstable::<&BodyId>().find_map(|(_, WallName(wall), control)| {
        let WallControl::Stress { length: LoadedLength::Between(a, b), .. } = *control else {
            return None;
        };
        if stage.walls.contains_key(wall) || stage.remove_walls.contains(wall) {
            return None;
        }
        let (a, b) = (&world.get::<WallName>(a)?.0, &world.get::<WallName>(b)?.0);
        let gone = [a, b].into_iter().find(|name| stage.remove_walls.contains(name))?;
        Some(format!(
            "the stress that wall `{wall}` keeps acts on the distance of walls `{a}` and `{b}`, and \
             remove_walls takes `{gone}` away; give it another control in this stage: \
             `walls: {{ \"{wall}\": Fixed }}`"
        ))
    })
}
