//! Selections and groups of particles.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Arguments;

use clastic_components::domain;

use crate::run::particles::BOUNDARY;
use crate::scene::format::{Particle, Select, Specimen, Stage};
use crate::scene::spans::join;

use super::Context;
use super::findings::Findings;
use super::references::index_exists;

/// Checks a selection of particles.
pub(super) fn select(path: Arguments, select: &Select, findings: &mut Findings) {
    let context = findings.context;
    let particles = match &context.scene.specimen {
        Specimen::Particles(list) => list.as_slice(),
        _ => &[],
    };
    match select {
        Select::All => {
            let pours = context.scene.stages.iter().any(|stage| matches!(stage, Stage::Pour(_)));
            if context.particles == Some(0) && !pours && findings.is_sure_of("specimen") {
                let help = "add particles to the specimen, or leave this entry out";
                findings.add(path, "selects no particle: the specimen has none", help);
            }
        }
        Select::Index(list) => {
            if list.is_empty() {
                findings.add(path, "selects no particle", "name particles by index, from 0");
            }
            for (i, index) in list.iter().enumerate() {
                index_exists(format_args!("{path}[{i}]"), *index, findings);
            }
        }
        Select::Group(name) => {
            let names = names_of_groups(context, particles);
            findings.reference(format_args!("{path}[0]"), name, ("group", "specimen"), &names);
        }
        Select::Probe(name) => {
            let listed = particles.iter().filter_map(|p| p.probe.as_deref());
            let named = context.scene.probes.keys().map(String::as_str);
            let names: Vec<_> = listed.chain(named).collect();
            findings.reference(format_args!("{path}[0]"), name, ("probe", "specimen"), &names);
        }
        Select::Range(first, last) => {
            let sound = index_exists(format_args!("{path}[0]"), *first, findings)
                & index_exists(format_args!("{path}[1]"), *last, findings);
            if sound && first > last {
                let message = format!("before the first ({last})");
                findings.add(format_args!("{path}[1]"), message, "give (first, last)");
            }
        }
        Select::Material(name) => {
            let names = &context.materials;
            findings.reference(format_args!("{path}[0]"), name, ("material", "materials"), names);
        }
        Select::Box { .. } | Select::Circle { .. } | Select::Layer { .. } | Select::Polygon(_) => {
            region(path, select, findings);
        }
        Select::Loose(contacts) => {
            findings.at_least_one(format_args!("{path}[0]"), *contacts, "a number of contacts");
        }
        Select::Union(list) | Select::Intersection(list) => {
            if list.is_empty() {
                findings.add(path, "a set of no selections", "give one or more");
            }
            for (i, part) in list.iter().enumerate() {
                self::select(format_args!("{path}[{i}]"), part, findings);
            }
        }
        Select::Except(from, without) => {
            for (i, part) in [from, without].into_iter().enumerate() {
                self::select(format_args!("{path}[{i}]"), part, findings);
            }
        }
    }
}

/// Names of the groups of a scene, of its specimen, and of the grains that it pours.
fn names_of_groups<'a>(context: &'a Context, particles: &'a [Particle]) -> Vec<&'a str> {
    let mut names: Vec<_> = particles.iter().filter_map(|p| p.group.as_deref()).collect();
    if matches!(context.scene.specimen, Specimen::Lattice { .. }) {
        names.push(BOUNDARY);
    }
    names.extend(context.specimen.iter().flat_map(|s| &s.groups).flatten().map(String::as_str));
    names.extend(context.state().iter().flat_map(|state| &state.groups).map(String::as_str));
    names.extend(context.scene.stages.iter().filter_map(|stage| match stage {
        Stage::Pour(pour) => pour.stream.group.as_deref(),
        _ => None,
    }));
    names.sort_unstable();
    names.dedup();
    names.extend(context.scene.groups.keys().map(String::as_str));
    names
}

/// Checks a region of the plane.
fn region(path: Arguments, select: &Select, findings: &mut Findings) {
    match select {
        Select::Box { min, max } => {
            let fine = findings.vector(format_args!("{path}.min"), *min, domain::PLACE.what)
                & findings.vector(format_args!("{path}.max"), *max, domain::PLACE.what);
            if fine && (min.0 > max.0 || min.1 > max.1) {
                let message = format!("not above and to the right of min ({max:?})");
                findings.add(format_args!("{path}.max"), message, "swap the corners");
            }
        }
        Select::Circle { centre, radius } => {
            findings.vector(format_args!("{path}.centre"), *centre, domain::PLACE.what);
            findings.within(format_args!("{path}.radius"), *radius, domain::RADIUS);
        }
        Select::Layer { normal, from, to } => {
            let what = "a direction";
            if findings.vector(format_args!("{path}.normal"), *normal, what)
                && normal.0.hypot(normal.1) <= 0.0
            {
                findings.add(
                    format_args!("{path}.normal"),
                    "no direction",
                    "give (0.0, 1.0) for y",
                );
            }
            let what = "a distance from the origin in m";
            let fine = findings.finite(format_args!("{path}.from"), *from, what)
                & findings.finite(format_args!("{path}.to"), *to, what);
            if fine && from > to {
                let message = format!("below `from` ({to:?})");
                findings.add(format_args!("{path}.to"), message, "swap the two");
            }
        }
        Select::Polygon(corners) => {
            for (i, corner) in corners.iter().enumerate() {
                findings.vector(format_args!("{path}[{i}]"), *corner, domain::PLACE.what);
            }
            if corners.len() < 3 {
                findings.add(path, "a polygon of fewer than three corners", "give three or more");
            }
        }
        _ => {}
    }
}

/// Checks the groups of the scene: no name is also one of the specimen, and no group is defined by
/// itself.
pub(super) fn groups(findings: &mut Findings) {
    let context = findings.context;
    let groups = &context.scene.groups;
    for (name, of) in groups {
        let path = join("groups", name);
        let path = format_args!("{path}");
        if name.trim().is_empty() {
            findings.add_at_key(path, "empty name of a group".to_owned(), "give a name");
        }
        let taken = match &context.scene.specimen {
            Specimen::Particles(list) => {
                list.iter().any(|particle| particle.group.as_deref() == Some(name))
            }
            Specimen::Lattice { .. } => name == BOUNDARY,
            Specimen::File { .. } => context
                .specimen
                .is_some_and(|stored| stored.groups.iter().flatten().any(|group| group == name)),
            _ => false,
        };
        if taken {
            let message = format!("the specimen has a group `{name}` too");
            findings.add_at_key(path, message, "give it another name");
        }
        if mentions(groups, of, name, &mut BTreeSet::new()) {
            let message = format!("group `{name}` is defined by itself");
            findings.add(path, message, "define it by other groups, or by regions");
        } else {
            select(path, of, findings);
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
