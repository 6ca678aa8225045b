//! Selections and groups of particles.

use std::collections::BTreeMap;

use clastic_components::domain;
use glam::DVec2;

use crate::run::select::{Candidate, selects};
use crate::scene::format::{Particle, Select, Specimen, Stage};
use crate::text::spans::join;

use super::Context;
use super::findings::At;
use super::parts::index_exists;

pub(super) fn select(at: &mut At, select: &Select) {
    let context = at.context;
    match select {
        Select::All => {
            let pours = context.scene.stages.iter().any(Stage::pours);
            let is_empty = context.particles == Some(0) && !pours;
            let is_sure = at.are_sound(&["specimen", "keep"]);
            let help = "add particles to the specimen, or leave this entry out";
            at.refuse(is_empty && is_sure, "", "selects no particle: the specimen has none", help);
        }
        Select::Index(list) => {
            let help = "name particles by index, from 0";
            at.refuse(list.is_empty(), "", "selects no particle", help);
            for (i, index) in list.iter().enumerate() {
                index_exists(at, format_args!("[{i}]"), *index);
            }
        }
        Select::Group(name) => {
            at.reference("[0]", name, ("group", "specimen"), &names_of_groups(context));
        }
        Select::Probe(name) => {
            let listed = context.listed().iter().filter_map(|p| p.probe.as_deref());
            let named = context.scene.probes.keys().map(String::as_str);
            let names: Vec<_> = listed.chain(named).collect();
            at.reference("[0]", name, ("probe", "specimen"), &names);
        }
        Select::Range(first, last) => {
            let sound = index_exists(at, "[0]", *first) & index_exists(at, "[1]", *last);
            let help = "give (first, last)";
            at.refuse(sound && first > last, "[1]", format!("before the first ({last})"), help);
        }
        Select::Material(name) => {
            at.material("[0]", name);
        }
        Select::Box { min, max } => {
            let fine = at.place("min", *min) & at.place("max", *max);
            let is_sure = at.is_sure("min") && at.is_sure("max");
            let message = format!("not above and to the right of min ({max:?})");
            let help = "swap the corners";
            at.refuse(fine && is_sure && (min.0 > max.0 || min.1 > max.1), "max", message, help);
        }
        Select::Circle { centre, radius } => {
            at.place("centre", *centre);
            at.within("radius", *radius, domain::RADIUS);
        }
        Select::Layer { normal, from, to } => {
            let fine = at.vector("normal", *normal, "a direction");
            let help = "give (0.0, 1.0) for y";
            at.refuse(fine && normal.0.hypot(normal.1) <= 0.0, "normal", "no direction", help);
            let what = "a distance from the origin in m";
            let fine = at.finite("from", *from, what) & at.finite("to", *to, what);
            at.refuse(fine && from > to, "to", format!("below `from` ({to:?})"), "swap the two");
        }
        Select::Polygon(corners) => {
            for (i, corner) in corners.iter().enumerate() {
                at.place(format_args!("[{i}]"), *corner);
            }
            let help = "give three or more";
            at.refuse(corners.len() < 3, "", "a polygon of fewer than three corners", help);
        }
        Select::Loose(contacts) => {
            at.at_least_one("[0]", *contacts, "a number of contacts");
        }
        Select::Union(_) | Select::Intersection(_) | Select::Except(..) => {
            if select.parts().is_empty() && at.is_sure("") {
                at.add("", "a set of no selections", "give one or more");
            }
            for (i, part) in select.parts().into_iter().enumerate() {
                self::select(&mut at.item("", i), part);
            }
        }
    }
}

/// Names of the groups of a scene, of its specimen, and of the grains that it pours.
fn names_of_groups<'a>(context: &Context<'a>) -> Vec<&'a str> {
    let mut names = context.groups_of_specimen();
    names.extend(context.state().iter().flat_map(|state| &state.groups).map(String::as_str));
    names.extend(context.scene.stages.iter().filter_map(|stage| match stage {
        Stage::Pour(pour) => pour.stream.group.as_deref(),
        _ => None,
    }));
    let of_scene = context.scene.groups.keys().map(String::as_str);
    names.into_iter().chain(of_scene).collect()
}

/// Checks the group to which particles belong.
pub(super) fn name_of_group(at: &mut At, name: Option<&str>) {
    if name.is_some_and(|name| name.trim().is_empty()) {
        at.add("group", "empty name of a group", "give a name");
    }
}

/// Checks the groups of the scene: no name is also one of the specimen, and no group is defined by
/// itself.
pub(super) fn groups(at: &mut At) {
    let context = at.context;
    let groups = &context.scene.groups;
    let taken = context.groups_of_specimen();
    for (name, of) in groups {
        let at = &mut at.entry("groups", name);
        if name.trim().is_empty() {
            at.add_at_key("empty name of a group", "give a name");
        }
        if taken.contains(name.as_str()) {
            let message = format!("the specimen has a group `{name}` too");
            at.add_at_key(message, "give it another name");
        }
        let is_itself = |part: &&Select| matches!(part, Select::Group(other) if other == name);
        if of.all(groups).iter().any(is_itself) {
            let message = format!("group `{name}` is defined by itself");
            at.add("", message, "define it by other groups, or by regions");
        } else {
            select(at, of);
        }
    }
}

/// Finds regions and sets that select no particle: a control of particles would have no effect.
///
/// Positions are known until a stage moves the particles, and the particles until one is removed.
/// The check therefore covers the first stage that loads or removes. For later stages the run makes
/// this check when they begin.
pub(super) fn regions(at: &mut At) {
    let groups = &at.context.scene.groups;
    let Some((i, stage)) = unmoved(at.context) else { return };
    let rigid: Vec<_> = stage.load().into_iter().flat_map(|load| &load.rigid).collect();
    if by_place(stage, groups).next().is_none() && rigid.len() < 2 {
        return;
    }
    let at = &mut at.item("stages", i);
    let is_sound = ["particles", "rigid", "select"].iter().all(|f| at.are_sound(&[&at.path(f)]));
    let Some(seeds) = known_seeds(at).filter(|_| is_sound) else { return };
    let taken = |select: &Select| members(at.context, &seeds, select);
    let with_select = rigid.into_iter().filter_map(|(name, of)| Some((name, of.select.as_ref()?)));
    let made = with_select.filter(|(_, select)| !select.needs_forces(groups));
    let made: Vec<_> = made.map(|(name, select)| (name, taken(select))).collect();
    let empty = by_place(stage, groups).filter(|(_, select)| taken(select).is_empty());
    let empty: Vec<_> = empty.collect();
    for (k, (name, of_one)) in made.iter().enumerate() {
        let shared = made[..k].iter().find_map(|(other, of_other)| {
            Some((other, of_one.iter().find(|index| of_other.binary_search(index).is_ok())?))
        });
        if let Some((other, index)) = shared {
            let message =
                format!("takes particle {index}, which is a member of the rigid group `{other}`");
            let help = "a particle belongs to one group: select others";
            at.entry("rigid", name).add("select", message, help);
        }
    }
    for (entry, select) in empty {
        let (why, what) = match select {
            Select::Box { .. } => (": no centre is in the box", "a box that holds some"),
            _ => ("", "one that has some"),
        };
        at.add(entry, format!("selects no particle{why}"), bounds(what, &seeds));
    }
}

/// The first stage that moves or removes particles, with its index.
fn unmoved<'a>(context: &Context<'a>) -> Option<(usize, &'a Stage)> {
    let moves = |stage: &Stage| !matches!(stage, Stage::Cement(_) | Stage::Save(_));
    context.scene.stages.iter().enumerate().find(|(_, stage)| moves(stage))
}

/// The particles at the start, by index; `None` where they are not known.
fn known_seeds(at: &At) -> Option<Vec<Particle>> {
    let context = at.context;
    let is_known = match &context.scene.specimen {
        // A run that is resumed does not read the state again, and its particles are elsewhere.
        Specimen::State { .. } => context.state().is_some_and(|state| state.saved.is_some()),
        _ => context.is_read(),
    };
    // Rows are not indices where particles were taken away before.
    let has_gaps =
        context.specimen.is_some_and(|stored| stored.indices != stored.rows.len() as u64);
    // An invalid recipe makes no particles.
    let is_sound = at.are_sound(&["specimen", "groups", "materials", "minerals", "keep"]);
    (is_known && !has_gaps && is_sound).then(|| context.at_start())
}

/// Indices of the particles at the start that a selection takes.
fn members(context: &Context, seeds: &[Particle], select: &Select) -> Vec<u32> {
    let scene = context.scene;
    let only = context.materials.first().filter(|_| context.materials.len() == 1);
    let probes: BTreeMap<u32, &str> =
        scene.probes.iter().map(|(name, index)| (*index, name.as_str())).collect();
    let has = |(seed, index): &(&Particle, u32)| {
        let of = Candidate {
            index: *index,
            place: seed.position.into(),
            material: seed.material.as_deref().or(only.copied()),
            group: seed.group.as_deref(),
            probe: seed.probe.as_deref().or(probes.get(index).copied()),
            core: u32::MAX,
        };
        selects(select, &scene.groups, &of)
    };
    seeds.iter().zip(0..).filter(has).map(|(_, index)| index).collect()
}

/// Entries of a stage whose particles depend on places or on sets: place and selection.
fn by_place<'a>(
    stage: &'a Stage,
    groups: &'a BTreeMap<String, Select>,
) -> impl Iterator<Item = (String, &'a Select)> {
    let of = |select: &Select| match select {
        Select::All | Select::Index(_) | Select::Range(..) | Select::Probe(_) => false,
        Select::Group(name) if !groups.contains_key(name) => false,
        _ => !select.needs_forces(groups),
    };
    let load = stage.load();
    let controls = load.into_iter().flat_map(|load| load.particles.iter().enumerate());
    let controls = controls.map(|(k, control)| (format!("particles[{k}].select"), &control.select));
    let rigid = load.into_iter().flat_map(|load| &load.rigid).filter_map(|(name, control)| {
        Some((format!("{}.select", join("rigid", name)), control.select.as_ref()?))
    });
    let removed = if let Stage::Remove(stage) = stage { Some(&stage.select) } else { None };
    let removed = removed.map(|select| ("select".to_owned(), select));
    controls.chain(rigid).chain(removed).filter(move |(_, select)| of(select))
}

/// What to give instead, with the range of the centres.
fn bounds(what: &str, seeds: &[Particle]) -> String {
    let centres = || seeds.iter().map(|seed| DVec2::from(seed.position));
    let (Some(low), Some(high)) = (centres().reduce(DVec2::min), centres().reduce(DVec2::max))
    else {
        return "the specimen has no particles".to_owned();
    };
    format!(
        "give {what}: the centres are between ({:.4e}, {:.4e}) and ({:.4e}, {:.4e})",
        low.x, low.y, high.x, high.y
    )
}
