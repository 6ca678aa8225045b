//! Start of a loading stage: removed and added walls, controls of walls and particles, and the
//! lengths of strains and stresses.

use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce;
use glam::DVec2;

use clastic_components::body::{
    BodyId, Drive, Drives, ExternalForce, Group, LoadControl, Position, Probe,
};
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::observation::{
    MeasureArea, MeasureLength, Measures, StrainMeasure, StressComponent, StressMeasure,
};
use clastic_components::particle::Particle;
use clastic_components::wall::{LoadedLength, Wall, WallControl, WallName};
use clastic_systems::control_walls::loaded_length;

use super::rigid;
use super::spawn::{analysis, find_wall, spawn_wall};
use super::stages::Script;
use crate::scene::format as scene;

/// Sets up a loading stage.
pub fn begin(world: &mut World, stage: &scene::Load) {
    let analysis = set_up(world, stage.analysis, stage.gravity, stage.increments);

    for name in &stage.remove_walls {
        if let Some(wall) = find_wall(world, name) {
            world.despawn(wall);
        }
    }
    for name in &stage.add_walls {
        if find_wall(world, name).is_none() {
            spawn_wall(world, name);
        }
    }
    control_walls(world, stage);
    control_particles(world, stage, &analysis);
    rigid::control_groups(world, stage, &analysis);
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
            Some(scene::WallControl::Force(to)) => {
                let from = match before {
                    WallControl::Force { to, .. } => to,
                    _ => reaction(world, wall),
                };
                WallControl::Force { from, to: *to }
            }
            Some(scene::WallControl::Stress { stress, .. }) => {
                let from = match before {
                    WallControl::Stress { to, .. } => to,
                    _ => reaction(world, wall) / metres,
                };
                WallControl::Stress { from, to: *stress, length }
            }
            Some(scene::WallControl::Custom) => WallControl::Custom,
        };
        world.entity_mut(wall).insert(control);
    }
}

/// Ends the current stage before its loads reach their targets. The next stage starts from the
/// current loads, and keeps those that it does not change.
pub fn end_early(world: &mut World) {
    let progress = world.resource::<Progress>().clone();
    let reached = |from: f64, to: f64| progress.ramp(from, to).from;
    let mut walls = world.query::<&mut WallControl>();
    for mut control in walls.iter_mut(world) {
        match &mut *control {
            WallControl::Force { from, to } | WallControl::Stress { from, to, .. } => {
                *to = reached(*from, *to);
            }
            _ => {}
        }
    }
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
    let Some(scene::WallControl::Stress { between, .. }) = control else {
        return (LoadedLength::Segment, 1.0);
    };
    let between =
        between.as_ref().and_then(|(a, b)| Some((find_wall(world, a)?, find_wall(world, b)?)));
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

/// The drive of a motion in a stage with this analysis.
pub(super) fn drive(motion: scene::Motion, analysis: &Analysis) -> Drive {
    let dt = match analysis.kind {
        AnalysisKind::Dynamic { dt, .. } => dt,
        AnalysisKind::Static | AnalysisKind::LeastMotion { .. } => 0.0,
    };
    match motion {
        scene::Motion::Free => Drive::Free,
        scene::Motion::Held => Drive::Imposed(0.0),
        scene::Motion::Displacement(u) => Drive::Imposed(u),
        scene::Motion::Velocity(v) => Drive::Imposed(v * dt),
    }
}

fn control_particles(world: &mut World, stage: &scene::Load, analysis: &Analysis) {
    let mut particles = world.query::<(
        &BodyId,
        &Particle,
        &Position,
        Option<&Group>,
        Option<&Probe>,
        &mut Drives,
        &mut LoadControl,
    )>();
    for (id, _, x, group, probe, mut drives, mut loads) in particles.iter_mut(world) {
        drives.0 = [Drive::Free; 3];
        for load in &mut loads.0 {
            load.0 = load.1;
        }
        for control in &stage.particles {
            if !selects(&control.select, *id, x.0, group, probe) {
                continue;
            }
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
    let mut particles = world
        .query_filtered::<(&BodyId, &Position, Option<&Group>, Option<&Probe>), With<Particle>>();
    let k = stage.particles.iter().position(|control| {
        let mut all = particles.iter(world);
        !all.any(|(id, x, group, probe)| selects(&control.select, *id, x.0, group, probe))
    })?;
    let (what, remedy) = match &stage.particles[k].select {
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
    };
    Some(format!(
        "stage `{}` cannot begin: particles[{k}].select selects no particle: {what}; {remedy}",
        stage.name
    ))
}

pub(super) fn selects(
    select: &scene::Select,
    id: BodyId,
    x: DVec2,
    group: Option<&Group>,
    probe: Option<&Probe>,
) -> bool {
    match select {
        scene::Select::All => true,
        scene::Select::Index(list) => list.contains(&id.0),
        scene::Select::Group(name) => group.is_some_and(|g| g.0 == *name),
        scene::Select::Probe(name) => probe.is_some_and(|p| p.0 == *name),
        scene::Select::Box { min, max } => {
            x.x >= min.0 && x.y >= min.1 && x.x <= max.0 && x.y <= max.1
        }
    }
}

/// Resolves the names in the scene's measures. A measure with a missing body or wall is left out.
pub fn resolve_measures(world: &mut World) {
    let script = world.resource::<Script>();
    let wanted = script.scene.measures.clone();
    let reference_stage = script.reference_stage();
    let axial_strain = wanted.axial_strain.and_then(|m| strain(world, &m));
    let lateral_strain = wanted.lateral_strain.and_then(|m| strain(world, &m));
    let axial_stress = wanted.axial_stress.and_then(|m| stress(world, &m));
    let lateral_stress = wanted.lateral_stress.and_then(|m| stress(world, &m));
    let mut measures = world.resource_mut::<Measures>();
    let reference = measures.reference;
    *measures = Measures {
        reference_stage,
        axial_strain,
        lateral_strain,
        axial_stress,
        lateral_stress,
        reference,
    };
}

fn particle(world: &mut World, index: u32) -> Option<Entity> {
    let mut particles = world.query_filtered::<(Entity, &BodyId), With<Particle>>();
    particles.iter(world).find(|(_, id)| id.0 == index).map(|(e, _)| e)
}

fn strain(world: &mut World, measure: &scene::Strain) -> Option<StrainMeasure> {
    Some(match measure {
        scene::Strain::Walls(a, b) => {
            StrainMeasure::Walls(find_wall(world, a)?, find_wall(world, b)?)
        }
        scene::Strain::Particles(a, b) => {
            StrainMeasure::Particles(particle(world, *a)?, particle(world, *b)?)
        }
    })
}

fn stress(world: &mut World, measure: &scene::Stress) -> Option<StressMeasure> {
    Some(match measure {
        scene::Stress::Walls { walls, length } => StressMeasure::Walls {
            walls: walls.iter().map(|w| find_wall(world, w)).collect::<Option<_>>()?,
            length: match length {
                scene::Length::Fixed(length) => MeasureLength::Fixed(*length),
                scene::Length::Between(a, b) => {
                    MeasureLength::Between(find_wall(world, a)?, find_wall(world, b)?)
                }
            },
        },
        scene::Stress::Average { component, area } => StressMeasure::Average {
            component: match component {
                scene::Component::Xx => StressComponent::Xx,
                scene::Component::Yy => StressComponent::Yy,
                scene::Component::Xy => StressComponent::Xy,
            },
            area: match area {
                scene::Area::Fixed(area) => MeasureArea::Fixed(*area),
                scene::Area::Box((a, b), (c, d)) => MeasureArea::Box([
                    find_wall(world, a)?,
                    find_wall(world, b)?,
                    find_wall(world, c)?,
                    find_wall(world, d)?,
                ]),
            },
        },
    })
}
