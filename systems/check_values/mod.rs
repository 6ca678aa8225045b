//! Checks the values of settings, bodies, bonds, controls and loads, which a program may have set
//! since the last increment: each where it enters a table. Scenes go through the same tables; their
//! reader checks them before, against the same [domains](clastic_components::domain), so that it
//! can name the line.

mod bad;
mod bodies;
mod bonds;
mod controls;
mod groups;
mod laws;
mod links;
mod loads;
mod membranes;
mod missing;
mod settings;

use bevy_ecs::archetype::Archetypes;
use bevy_ecs::component::Components;
use bevy_ecs::prelude::*;

use crate::gather_bodies::BondData;
use crate::schedule::ClasticHalted;
use clastic_components::prelude::*;

pub(crate) use self::loads::refused_load;
use self::settings::Settings;

/// Halts the world at the first value that has no meaning, before an attempt works with it: a
/// position that is not a number would otherwise come back as an increment without a solution, and
/// a control without its table as no control. It runs in every increment, on the tables that have
/// just been gathered.
pub(crate) fn check_values(
    bodies: Res<BodyTable>,
    settings: Settings,
    materials: Option<Res<Materials>>,
    (archetypes, components): (&Archetypes, &Components),
    particles: Query<(&BodyId, &Particle)>,
    bonds: Query<BondData>,
    links: Query<(Entity, &Link)>,
    membranes: Query<&Membrane>,
    groups: Query<(&BodyId, &RigidGroup)>,
    controls: Query<(Option<&WallTable>, Option<&WallSlide>)>,
    names: Query<(Option<&Name>, Option<&WallName>)>,
    halted: Option<Res<ClasticHalted>>,
    mut commands: Commands,
) {
    if halted.is_some() {
        return;
    }
    let called = |entity: Entity| match names.get(entity) {
        Ok((Some(name), _)) => format!("`{name}`"),
        Ok((None, Some(WallName(name)))) => format!("`{name}`"),
        _ => format!("entity {entity}"),
    };
    let body = |row: usize| match bodies.names.get(&(row as u32)) {
        Some(_) => bodies.name(row),
        None => format!("{}, {},", bodies.name(row), called(bodies.entities[row])),
    };
    let list = materials.as_ref().map_or(&[][..], |materials| &materials.0);
    let of_material = || {
        list.iter().enumerate().find_map(|(i, material)| {
            let bad = laws::of_material(material)?;
            Some(bad.in_words(format_args!("material {i} (`{}`)", material.name)))
        })
    };
    let of_particle = |i| Some(bodies::particle(&bodies, i, list.len())?.in_words(body(i)));
    // The smallest identity: what a query finds first depends on the history of the world.
    let of_thickness = || {
        let bad = particles
            .iter()
            .filter_map(|(id, disk)| Some((*id, bodies::thickness(disk, &settings.analysis)?)));
        let (id, bad) = bad.min_by_key(|(id, _)| *id)?;
        Some(bad.in_words(body(bodies.row(id)?)))
    };
    let of_wall = |wall: &WallRow| {
        let row = wall.body as usize;
        let control = || {
            let (table, slide) = controls.get(bodies.entities[row]).ok()?;
            controls::control(wall, table, slide, settings.analysis.kind)
        };
        Some(bodies::wall(&bodies, wall).or_else(control)?.in_words(body(row)))
    };
    let of_group =
        |group: &GroupRow| Some(bodies::group(&bodies, group)?.in_words(body(group.body as usize)));
    let of_bond = || {
        let bad = bonds::in_tables(&bodies).or_else(|| bonds::loose(&bodies, &bonds));
        let (id, entity, pair, bad) = bad?;
        Some(bad.in_words(format_args!("bond {}, {}, {pair}", id.0, called(entity))))
    };
    let message = settings
        .bad()
        .map(|(name, bad)| bad.in_words(format_args!("`{name}`")))
        .or_else(|| Some(bodies::cell(bodies.cell.as_ref()?)?.in_words("`PeriodicCell`")))
        .or_else(|| {
            let (entity, bad) = missing::misfit(archetypes, components)?;
            Some(bad.in_words(called(entity)))
        })
        .or_else(of_material)
        .or_else(|| (0..bodies.particles).find_map(of_particle))
        .or_else(of_thickness)
        .or_else(|| bodies.walls.iter().find_map(of_wall))
        .or_else(|| bodies.groups.iter().find_map(of_group))
        .or_else(|| groups::bad(&bodies, settings.analysis.kind, &groups))
        .or_else(|| membranes::bad(&bodies, &membranes))
        .or_else(of_bond)
        .or_else(|| links::bad(&bodies, &links, &bonds));
    if let Some(message) = message {
        commands.insert_resource(ClasticHalted(message));
    }
}
