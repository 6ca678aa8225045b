//! Selections and groups of particles.

use std::collections::{BTreeMap, BTreeSet};

use clastic_components::domain;

use crate::scene::format::{Select, Stage};

use super::Context;
use super::findings::At;
use super::references::index_exists;

/// Checks a selection of particles.
pub(super) fn select(at: &mut At, select: &Select) {
    let context = at.context;
    match select {
        Select::All => {
            let pours = context.scene.stages.iter().any(Stage::pours);
            if context.particles == Some(0) && !pours && at.are_sound(&["specimen", "keep"]) {
                let help = "add particles to the specimen, or leave this entry out";
                at.add("", "selects no particle: the specimen has none", help);
            }
        }
        Select::Index(list) => {
            if list.is_empty() {
                at.add("", "selects no particle", "name particles by index, from 0");
            }
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
            if sound && first > last {
                at.add("[1]", format!("before the first ({last})"), "give (first, last)");
            }
        }
        Select::Material(name) => {
            at.material("[0]", name);
        }
        Select::Box { min, max } => {
            let fine = at.place("min", *min) & at.place("max", *max);
            let is_sure = at.is_sure("min") && at.is_sure("max");
            if fine && is_sure && (min.0 > max.0 || min.1 > max.1) {
                let message = format!("not above and to the right of min ({max:?})");
                at.add("max", message, "swap the corners");
            }
        }
        Select::Circle { centre, radius } => {
            at.place("centre", *centre);
            at.within("radius", *radius, domain::RADIUS);
        }
        Select::Layer { normal, from, to } => {
            let fine = at.vector("normal", *normal, "a direction");
            if fine && normal.0.hypot(normal.1) <= 0.0 {
                at.add("normal", "no direction", "give (0.0, 1.0) for y");
            }
            let what = "a distance from the origin in m";
            let fine = at.finite("from", *from, what) & at.finite("to", *to, what);
            if fine && from > to {
                at.add("to", format!("below `from` ({to:?})"), "swap the two");
            }
        }
        Select::Polygon(corners) => {
            for (i, corner) in corners.iter().enumerate() {
                at.place(format_args!("[{i}]"), *corner);
            }
            if corners.len() < 3 {
                at.add("", "a polygon of fewer than three corners", "give three or more");
            }
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
        if mentions(groups, of, name, &mut BTreeSet::new()) {
            let message = format!("group `{name}` is defined by itself");
            at.add("", message, "define it by other groups, or by regions");
        } else {
            select(at, of);
        }
    }
}

/// Whether a selection names a group, by itself or through other groups.
fn mentions<'a>(
    groups: &'a BTreeMap<String, Select>,
    select: &'a Select,
    name: &str,
    seen: &mut BTreeSet<&'a str>,
) -> bool {
    if let Select::Group(other) = select {
        if other == name || !seen.insert(other) {
            return other == name;
        }
        return groups.get(other).is_some_and(|next| mentions(groups, next, name, seen));
    }
    select.parts().into_iter().any(|part| mentions(groups, part, name, seen))
}
