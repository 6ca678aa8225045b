//! Start of a loading stage: removed and added walls, controls of walls and particles.

use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce;
use glam::DVec2;

use clastic_components::body::{BodyId, Drive, Drives, ExternalForce, LoadControl, Position};
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::particle::Particle;
use clastic_components::wall::{
    LoadedLength, TableOf, Wall, WallControl, WallName, WallRotation, WallSlide, WallTable,
};
use clastic_systems::control_walls::loaded_length;

use super::drive::drive;
use super::script::Script;
use super::select::selected;
use super::settings::analysis;
use super::wall_pieces::{CUT, is_cut};
use super::walls::{WallCatalogue, find_wall, find_walls, spawn_wall};
use super::{live_loads, membranes, rigid};
use crate::scene::format as scene;

/// Sets up a loading stage.
pub fn begin(world: &mut World, stage: &scene::Load) {
    let analysis = set_up(world, stage.analysis, stage.gravity, stage.increments);

    let confining = membranes::stress_of(world, &stage.remove_walls);
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
    control_walls(world, stage);
    super::cell::control(world, stage);
    control_particles(world, stage, &analysis);
    live_loads::begin(world, stage);
    rigid::control_groups(world, stage, &analysis);
    membranes::control_membranes(world, stage, confining);
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
) -> Analysis {
    let scene = &world.resource::<Script>().scene;
    let analysis =
        analysis(scene, kind.unwrap_or(scene.analysis), gravity.unwrap_or(scene.gravity));
    world.insert_resource(analysis);
    world.resource_mut::<Progress>().total = f64::from(increments);
    analysis
}

fn control_walls(world: &mut World, stage: &scene::Load) {
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
                entity.insert(match *slide {
                    scene::Slide::Displacement(u) => WallSlide::Displacement(u),
                    scene::Slide::Velocity(v) => WallSlide::Velocity(v),
                });
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

/// Ends what walls do in a stage only: loads from tables keep the values that they have reached,
/// and lids stop.
pub fn end(world: &mut World) {
    let progress = world.resource::<Progress>().clone();
    let dt = match world.resource::<Analysis>().kind {
        AnalysisKind::Dynamic { dt, .. } => Some(dt),
        AnalysisKind::Static | AnalysisKind::Compaction { .. } => None,
    };
    let mut walls = world.query::<(&mut WallControl, &WallTable)>();
    for (mut control, table) in walls.iter_mut(world) {
        let value = table.next(&progress, dt)[0].x;
        *control = match *control {
            WallControl::Table(TableOf::Force) => WallControl::Force { from: value, to: value },
            WallControl::Table(TableOf::Stress(length)) => {
                WallControl::Stress { from: value, to: value, length }
            }
            WallControl::Table(TableOf::Displacement | TableOf::Rotation(_)) => WallControl::Fixed,
            other => other,
        };
    }
    let mut walls = world.query_filtered::<Entity, Or<(With<WallTable>, With<WallSlide>)>>();
    let walls: Vec<_> = walls.iter(world).collect();
    for wall in walls {
        world.entity_mut(wall).remove::<(WallSlide, WallTable)>();
    }
}

/// Ends the current stage before its loads reach their targets. The next stage starts from the
/// current loads, and keeps those that it does not change.
pub fn end_early(world: &mut World) {
    let progress = world.resource::<Progress>().clone();
    let reached = |from: f64, to: f64| progress.ramp(from, to).from;
    end(world);
    super::cell::end_early(world);
    let mut walls = world.query::<&mut WallControl>();
    for mut control in walls.iter_mut(world) {
        match &mut *control {
            WallControl::Force { from, to } | WallControl::Stress { from, to, .. } => {
                *to = reached(*from, *to);
            }
            _ => {}
        }
    }
    membranes::end_early(world, &progress);
    live_loads::end_early(world, &progress);
    let mut particles = world.query::<&mut LoadControl>();
    for mut control in particles.iter_mut(world) {
        for (from, to) in &mut control.0 {
            *to = reached(*from, *to);
        }
    }
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
    let measure = move |geometry: Query<(&Wall, &Position)>| loaded_length(wall, length, &geometry);
    let metres = world.run_system_once(measure).unwrap_or(1.0);
    (length, metres * world.resource::<Analysis>().thickness)
}

/// Force of the wall on the specimen along its inward normal, N. The load of a wall that was held
/// starts from this value.
fn reaction(world: &World, wall: Entity) -> f64 {
    match (world.get::<Wall>(wall), world.get::<ExternalForce>(wall)) {
        (Some(wall), Some(force)) => DVec2::new(force.0[0], force.0[1]).dot(wall.inward()),
        _ => 0.0,
    }
}

fn control_particles(world: &mut World, stage: &scene::Load, analysis: &Analysis) {
    let mut particles = world.query_filtered::<(&mut Drives, &mut LoadControl), With<Particle>>();
    for (mut drives, mut loads) in particles.iter_mut(world) {
        drives.0 = [Drive::Free; 3];
        for load in &mut loads.0 {
            load.0 = load.1;
        }
    }
    let mut particles = world.query::<(&Position, &mut Drives, &mut LoadControl)>();
    for control in stage.particles.iter().filter(|control| !control.live) {
        for (_, entity) in selected(world, &control.select) {
            let Ok((x, mut drives, mut loads)) = particles.get_mut(world, entity) else { continue };
            for (k, motion) in [control.x, control.y, control.rotation].into_iter().enumerate() {
                if motion != scene::Motion::Free {
                    drives.0[k] = drive(motion, analysis);
                }
            }
            if let Some(((xx, xy), (yx, yy))) = control.affine {
                drives.0[0] = Drive::Imposed(xx * x.0.x + xy * x.0.y);
                drives.0[1] = Drive::Imposed(yx * x.0.x + yy * x.0.y);
            }
            if let Some((fx, fy)) = control.force {
                loads.0[0].1 = fx;
                loads.0[1].1 = fy;
            }
            if let Some(moment) = control.moment {
                loads.0[2].1 = moment;
            }
        }
    }
}

/// An entry of `particles` that selects no particle. The stage is refused, because without this
/// entry the results would be those of another scene.
pub fn selects_nothing(world: &mut World, stage: &scene::Load) -> Option<String> {
    let empty = |control: &scene::ParticleControl| {
        !control.live && selected(world, &control.select).is_empty()
    };
    let k = stage.particles.iter().position(empty)?;
    let (what, remedy) = why_empty(&stage.particles[k].select);
    Some(format!(
        "stage `{}` cannot begin: particles[{k}].select selects no particle: {what}; {remedy}",
        stage.name
    ))
}

/// Why a selection has no particle, and what to do.
pub(super) fn why_empty(select: &scene::Select) -> (String, String) {
    match select {
        scene::Select::All => {
            ("the specimen has no particles".to_owned(), "leave the entry out".to_owned())
        }
        scene::Select::Index(list) => (
            format!("no particle has an index of {list:?}"),
            "name particles that exist".to_owned(),
        ),
        scene::Select::Group(name) => {
            (format!("no particle is of group `{name}`"), "name a group that exists".to_owned())
        }
        scene::Select::Probe(name) => {
            (format!("no particle is the probe `{name}`"), "name a probe that exists".to_owned())
        }
        scene::Select::Box { min, max } => {
            let what = format!("no particle has its centre in the box from {min:?} to {max:?}");
            (what, "give a box that holds the particles where they are by then".to_owned())
        }
        _ => (
            "no particle is in it".to_owned(),
            "give one that has particles where they are by then".to_owned(),
        ),
    }
}

/// A thin wall that comes where a particle is. The stage is refused, because the side of the
/// particle is not clear.
pub fn cuts_through(world: &mut World, stage: &scene::Load) -> Option<String> {
    let catalogue = world.get_resource::<WallCatalogue>()?;
    let comes = |wall: &&scene::Wall| stage.add_walls.contains(&wall.name) && !wall.shape.is_line();
    let walls: Vec<_> = catalogue.walls.iter().filter(comes).cloned().collect();
    let mut particles = world.query::<(&BodyId, &Particle, &Position)>();
    let cut = |wall: &scene::Wall| {
        let all = particles.iter(world);
        let cut = all.filter(|(_, particle, x)| is_cut(wall, x.0, particle.radius));
        cut.map(|(id, ..)| id.0).min()
    };
    let (wall, particle) =
        walls.iter().zip(walls.iter().map(cut)).find_map(|(w, p)| Some((w, p?)))?;
    Some(format!(
        "stage `{}` cannot begin: wall `{}` of add_walls would cut through particle {particle}, whose \
         centre is within {CUT:?} radii of it; add it where there is room",
        stage.name, wall.name
    ))
}
