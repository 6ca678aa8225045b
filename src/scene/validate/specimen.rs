//! Particles, the recipes that make them, and the saved states that have them.

use std::collections::{BTreeMap, BTreeSet};

use clastic_components::domain;

use crate::scene::coincident::coincident;
use crate::scene::format::{Particle, Specimen, Stage};
use crate::scene::limits::{MAX_MEMORY, MAX_PARTICLES};
use crate::scene::memory::{self, Need};
use crate::scene::stored_state::StoredSpecimen;
use crate::text::diagnostic::MAX_SHOWN;
use crate::text::suggest;

use super::bonds;
use super::findings::At;
use super::parts::material_of;
use super::places::is_well_placed;
use super::select::name_of_group;
use super::sizes::check_sizes;

pub(super) fn check(at: &mut At) {
    let context = at.context;
    size(at);
    let own = &mut at.field("specimen");
    match &context.scene.specimen {
        Specimen::Particles(list) => particles(own, list),
        Specimen::Lattice { columns, rows, radius, origin, material } => {
            own.at_least_one("columns", *columns, "a number");
            own.at_least_one("rows", *rows, "a number");
            own.within("radius", *radius, domain::RADIUS);
            own.place("origin", *origin);
            material_of(own, material.as_deref());
        }
        Specimen::Packing { count, columns, spacing, origin, sizes, material, .. } => {
            own.at_least_one("count", *count, "a number");
            own.at_least_one("columns", *columns, "a number");
            own.place("origin", *origin);
            material_of(own, material.as_deref());
            let fine = own.positive("spacing", *spacing, "a spacing in m");
            let limits = check_sizes(&mut own.field("sizes"), sizes).filter(|_| fine);
            let wanted = limits.map_or(0.0, |(_, maximum)| 2.0 * maximum);
            let message = format!("smaller than the maximum diameter ({spacing:?})");
            let help = format!("give a spacing in m of {wanted:?} or more");
            own.refuse(*spacing < wanted, "spacing", message, help);
        }
        Specimen::File { material, .. } => {
            if let Some(stored) = context.specimen {
                rows(own, stored, material.as_deref());
            }
        }
        Specimen::State { materials, .. } => state(at, materials),
    }
    let is_recipe =
        matches!(context.scene.specimen, Specimen::Lattice { .. } | Specimen::Packing { .. });
    if is_recipe && context.scene.keep.is_none() && at.are_sound(&["specimen", "walls"]) {
        let disks = context.at_start().into_iter().map(|seed| (seed.position, seed.radius));
        places(at, "specimen", ("", 1), disks);
    }
    bonds::check(at);
}

/// Checks where the particles `whose` are, up to the first `most` that are where none can be.
fn places(
    at: &mut At,
    field: &str,
    (whose, most): (&str, usize),
    disks: impl Iterator<Item = ((f64, f64), f64)>,
) {
    let wrong = disks.enumerate().filter(|(i, (place, radius))| {
        !is_well_placed(at, field, format_args!("particle {i}{whose}"), *place, *radius)
    });
    let _ = wrong.take(most).count();
}

/// Checks that a specimen is not too large for any machine.
fn size(at: &mut At) {
    let context = at.context;
    if !at.are_sure_of(&["specimen", "stages"]) {
        return;
    }
    let need = Need::of(context.scene, context.specimen);
    let bytes = memory::size(need.bytes);
    let poured = |stage: &Stage| memory::poured(context.scene, stage) > 0.5 * need.particles as f64;
    let place = match context.scene.stages.iter().position(poured) {
        Some(stage) => format!("stages[{stage}].rate"),
        None => "specimen".to_owned(),
    };
    if need.particles > MAX_PARTICLES {
        let message = format!("{} particles, which take about {bytes} of memory", need.particles);
        at.add(place, message, format!("give at most {MAX_PARTICLES}"));
    } else if need.bytes > MAX_MEMORY {
        let message = format!(
            "{} particles with about {:.1e} contacts and bonds, which take about {bytes} of memory",
            need.particles, need.pairs,
        );
        let help = "take fewer particles, a shorter `length` of cement, or overlap them less";
        at.add(place, message, help);
    }
}

fn particles(at: &mut At, list: &[Particle]) {
    for (i, particle) in list.iter().enumerate() {
        let at = &mut at.item("", i);
        let (place, radius) = (particle.position, particle.radius);
        let fine = at.within("radius", radius, domain::RADIUS) & at.place("position", place);
        at.vector("velocity", particle.velocity, domain::VELOCITY.what);
        at.within("angular_velocity", particle.angular_velocity, domain::SPIN);
        material_of(at, particle.material.as_deref());
        name_of_group(at, particle.group.as_deref());
        if fine && at.is_sure("") {
            is_well_placed(at, "position", "the centre", place, radius);
        }
    }
    if at.is_sure_of("specimen") {
        let disk = |p: &Particle| (p.position.0, p.position.1, p.radius);
        let disks: Vec<_> = list.iter().map(disk).collect();
        for (earlier, later) in coincident(&disks) {
            let place = list[later].position;
            let message = format!("the same place as particle {earlier} {place:?}");
            at.add(format_args!("[{later}].position"), message, "leave one of them out");
        }
    }
}

fn rows(at: &mut At, stored: &StoredSpecimen, default: Option<&str>) {
    if default.is_some() || stored.rows.iter().any(|row| row.material.is_none()) {
        material_of(at, default);
    }
    let materials: BTreeSet<_> =
        stored.rows.iter().filter_map(|row| row.material.as_deref()).collect();
    for name in materials {
        at.material("path", name);
    }
    let disks = stored.rows.iter().map(|row| ((row.x, row.y), row.r));
    places(at, "path", (" of the file", MAX_SHOWN), disks);
}

/// Checks the saved state from which a scene starts.
fn state(at: &mut At, renamed: &BTreeMap<String, String>) {
    let context = at.context;
    for (name, new) in renamed {
        at.entry("specimen.materials", name).material("", new);
    }
    // A run that is resumed does not read the state again.
    let Some(stored) = context.specimen else { return };
    let Some(state) = &stored.state else { return };
    let Some(saved) = &state.saved else { return };
    let there: Vec<&str> = saved.materials.iter().map(|(name, _)| name.as_str()).collect();
    for name in renamed.keys().filter(|name| !there.contains(&name.as_str())) {
        let help = suggest::help(name, &there, "materials of the state");
        let message = format!("the state has no material `{name}`");
        at.entry("specimen.materials", name).add_at_key(message, help);
    }
    let used: BTreeSet<&str> =
        stored.rows.iter().filter_map(|row| row.material.as_deref()).collect();
    let lost = used.iter().filter(|name| !context.materials.contains(name));
    // A name that `materials` gives is reported there.
    for name in lost.filter(|name| !renamed.values().any(|new| new == *name)) {
        let message = format!("the scene lacks material `{name}` of the state");
        let help = format!(
            "add it to `materials` of the scene, or rename it: materials: {{{name:?}: NAME}}, with one of {}",
            suggest::list(&context.materials)
        );
        at.refuse(at.is_sure_of("materials"), "specimen", message, help);
    }
    if state.gives_walls {
        return;
    }
    for name in saved.groups_with_walls().unwrap_or_default() {
        let message = format!("walls of the state, which belong to its rigid group `{name}`, go");
        let help = "release the group in the run that saves, or leave `walls` out";
        at.add("walls", message, help);
    }
    let disks = stored.rows.iter().map(|row| ((row.x, row.y), row.r));
    places(at, "specimen.path", (" of the state", MAX_SHOWN), disks);
}
