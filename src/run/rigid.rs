//! Rigid groups at the start of a loading stage: released, made and controlled.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;
use clastic_systems::rigid_groups::{Member, State};

use super::particle_controls::drive;
use super::script::Script;
use super::select::selected;
use super::walls::find_walls;
use crate::scene::format as scene;

/// Releases, makes and controls the rigid groups of a stage.
pub(crate) fn control_groups(world: &mut World, stage: &scene::Load, analysis: &ClasticAnalysis) {
    let mut groups = world.query::<(&BodyId, Entity, &RigidGroup)>();
    let released = groups.iter(world).filter(|(.., group)| stage.release.contains(&group.name));
    for group in released.map(|(_, group, _)| group).collect::<Vec<_>>() {
        world.despawn(group);
    }
    for (name, control) in &stage.rigid {
        if control.makes() {
            make(world, name, control);
        }
    }
    let ordered = groups.iter(world).sort_unstable::<&BodyId>();
    let controls: Vec<_> = ordered.map(|(_, e, of)| (e, stage.rigid.get(&of.name))).collect();
    for (group, control) in controls {
        set_control(world, group, control, analysis);
    }
}

/// Sets drives and loads. A group without an entry keeps its loads, and stands still where it was
/// driven. The load on a degree of freedom that was held or driven starts from the reaction.
fn set_control(
    world: &mut World,
    entity: Entity,
    control: Option<&scene::RigidControl>,
    analysis: &ClasticAnalysis,
) {
    let body = world.entity(entity);
    let mut drives = body.get::<BodyDrives>().map(|drives| drives.0).unwrap_or_default();
    let mut loads = body.get::<LoadControl>().map(|loads| loads.0).unwrap_or_default();
    let reaction = body.get::<BodyExternalForce>().map(|force| force.0).unwrap_or_default();
    let force = control.and_then(|control| control.total_force(analysis.thickness));
    let moment = control.and_then(|control| control.moment);
    let wanted = [force.map(|f| f.0), force.map(|f| f.1), moment];
    for k in 0..3 {
        let before = drives[k];
        drives[k] = match (control, before) {
            (Some(control), _) => drive(control.motions()[k].1, analysis),
            (None, BodyDrive::Imposed(_)) => BodyDrive::Imposed(0.0),
            (None, BodyDrive::Free) => BodyDrive::Free,
        };
        let (from, to) = match before {
            BodyDrive::Free => (loads[k].1, loads[k].1),
            BodyDrive::Imposed(_) => (reaction[k], 0.0),
        };
        loads[k] = match drives[k] {
            BodyDrive::Free => (from, wanted[k].unwrap_or(to)),
            BodyDrive::Imposed(_) => (0.0, 0.0),
        };
    }
    world.entity_mut(entity).insert((BodyDrives(drives), LoadControl(loads)));
}

type Particles<'a> = (
    &'a Particle,
    &'a BodyPosition,
    &'a BodyRotation,
    &'a mut BodyVelocity,
    &'a mut BodyAngularVelocity,
);

/// Makes a group of the selected particles and the named walls. The particles take the velocities
/// of the rigid motion with their momentum and their angular momentum. What the walls carried is
/// the load from which the group starts.
fn make(world: &mut World, name: &str, control: &scene::RigidControl) {
    let about = control.about;
    let (mut ids, chosen): (Vec<BodyId>, Vec<Entity>) = chosen(world, control).into_iter().unzip();
    let walls = walls_of(world, &control.walls);
    let mut query = world.query::<Particles>();
    let member = |entity: &Entity| {
        let (particle, x, rotation, v, spin) = query.get(world, *entity).ok()?;
        let Particle { mass, inertia, radius, .. } = *particle;
        let member = Member { mass, inertia, radius, position: x.0, velocity: v.0, spin: spin.0 };
        Some((rotation.0, member))
    };
    let members: Vec<(f64, Member)> = chosen.iter().filter_map(member).collect();
    let state = State::of(members.iter().map(|(_, member)| *member), about.map(DVec2::from));
    for entity in chosen {
        if let Ok((_, x, _, mut v, mut spin)) = query.get_mut(world, entity) {
            v.0 = state.velocity + state.spin * (x.0 - state.centre).perp();
            spin.0 = state.spin;
        }
    }
    let mut carried = [0.0; 3];
    let mut reference = members.first().map(|(rotation, _)| *rotation);
    for (id, wall) in walls {
        ids.push(id);
        let mut wall = world.entity_mut(wall);
        wall.insert(WallControl::Fixed).remove::<(WallSlide, WallTable)>();
        let turned = wall.entry::<WallRotation>().or_default().get().0;
        reference.get_or_insert(turned);
        let arm = wall.get::<BodyPosition>().map_or(DVec2::ZERO, |x| x.0 - state.centre);
        let [x, y, moment] = wall.get::<BodyExternalForce>().map_or([0.0; 3], |force| force.0);
        carried[0] += x;
        carried[1] += y;
        carried[2] += moment + arm.perp_dot(DVec2::new(x, y));
    }
    ids.sort_unstable();
    let mut group = world.spawn((
        RigidGroup {
            name: name.to_owned(),
            members: ids,
            has_pivot: about.is_some(),
            reference: reference.unwrap_or_default(),
        },
        BodyPosition(state.centre),
        BodyOrigin(state.centre),
        Probe(name.to_owned()),
    ));
    if !control.walls.is_empty() {
        group.insert((
            BodyDrives([BodyDrive::Imposed(0.0); 3]),
            BodyExternalForce::of_state(carried),
        ));
    }
}

/// The particles that an entry selects, by identity.
fn chosen(world: &mut World, control: &scene::RigidControl) -> Vec<(BodyId, Entity)> {
    control.select.as_ref().map(|select| selected(world, select)).unwrap_or_default()
}

/// The walls of these names that are there: every piece of a polyline.
fn walls_of(world: &mut World, names: &[String]) -> Vec<(BodyId, Entity)> {
    let walls: Vec<_> = names.iter().flat_map(|name| find_walls(world, name)).collect();
    walls.into_iter().filter_map(|wall| Some((*world.get::<BodyId>(wall)?, wall))).collect()
}

/// Why the rigid groups of a stage cannot be made or controlled; `None` if they can.
pub fn refusal(world: &mut World, stage: &scene::Load) -> Option<String> {
    let mut taken: Vec<(BodyId, String)> = world
        .query::<&RigidGroup>()
        .iter(world)
        .filter(|group| !stage.release.contains(&group.name))
        .flat_map(|group| group.members.iter().map(|id| (*id, group.name.clone())))
        .collect();
    // The members of the groups of a saved state are known only here.
    let others = stage.remove_walls.iter().chain(stage.walls.keys());
    for name in others {
        let walls = walls_of(world, std::slice::from_ref(name));
        if let Some((_, group)) = taken.iter().find(|(id, _)| walls.iter().any(|w| w.0 == *id)) {
            return Some(format!(
                "wall `{name}` is a member of the rigid group `{group}`; control it by `rigid`, or release `{group}`"
            ));
        }
    }
    for (name, control) in stage.rigid.iter().filter(|(_, control)| control.makes()) {
        let walls = walls_of(world, &control.walls);
        let of_another = walls.iter().find_map(|(id, wall)| {
            let (_, other) = taken.iter().find(|taken| taken.0 == *id)?;
            Some((&world.get::<WallName>(*wall)?.0, other))
        });
        if let Some((wall, other)) = of_another {
            return Some(format!(
                "rigid.{name} has wall `{wall}` of the rigid group `{other}`; release `{other}` in a stage before"
            ));
        }
        let chosen = chosen(world, control).into_iter();
        let mut ids: Vec<BodyId> = chosen.map(|(id, _)| id).collect();
        if ids.is_empty() && control.select.is_some() {
            return Some(format!("rigid.{name} selects no particle; select what is to be rigid"));
        }
        let of_another = taken.iter().find(|(id, _)| ids.binary_search(id).is_ok());
        if let Some((BodyId(id), other)) = of_another {
            return Some(format!(
                "rigid.{name} selects particle {id}, which is a member of the rigid group `{other}`; a particle \
                 belongs to one group: select others, or release `{other}` in a stage before"
            ));
        }
        ids.extend(walls.into_iter().map(|(id, _)| id));
        taken.extend(ids.into_iter().map(|id| (id, name.clone())));
    }
    moving_pivot(world, stage)
}

/// The program of a time step has the inertia of a group about its centre of mass, or about a pivot
/// that is held.
fn moving_pivot(world: &mut World, stage: &scene::Load) -> Option<String> {
    let kind = stage.analysis.unwrap_or(world.resource::<Script>().scene.analysis);
    if kind == scene::Analysis::Static {
        return None;
    }
    let mut groups = world.query::<(&RigidGroup, &BodyDrives)>();
    let stays = |group: &RigidGroup| group.has_pivot && !stage.release.contains(&group.name);
    let is_held = |control: &scene::RigidControl| {
        [control.x, control.y].iter().all(|motion| *motion == scene::Motion::Held)
    };
    let kept = groups.iter(world).filter(|(group, _)| stays(group)).map(|(group, drives)| {
        let stood = || !drives.0[..2].contains(&BodyDrive::Free);
        (&group.name, stage.rigid.get(&group.name).map_or_else(stood, is_held))
    });
    let made = stage.rigid.iter().filter(|(_, control)| control.about.is_some());
    let made = made.map(|(name, control)| (name, is_held(control)));
    let (name, _) = kept.chain(made).find(|(_, is_held)| !is_held)?;
    Some(format!(
        "the pivot of the rigid group `{name}` moves in a dynamic stage; hold its x and y, or make it without `about`"
    ))
}
