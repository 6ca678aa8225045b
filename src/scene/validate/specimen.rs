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
use super::places::{not_behind, not_too_far, outline};
use super::select::name_of_group;
use super::sizes::check_sizes;

pub(super) fn check(at: &mut At) {
    let context = at.context;
    size(at);
    let own = &mut at.field("specimen");
    match &context.scene.specimen {
        Specimen::Particles(list) => particles(own, list),
        Specimen::Lattice { columns, rows, radius, origin, material } => {
            let counts = own.at_least_one("columns", *columns, "a number")
                & own.at_least_one("rows", *rows, "a number");
            let fine = own.within("radius", *radius, domain::RADIUS) & own.place("origin", *origin);
            material_of(own, material.as_deref());
            if fine && counts {
                let last = f64::from(rows - 1);
                let indent = if rows % 2 == 0 && *columns > 1 { *radius } else { 0.0 };
                let low = (origin.0, origin.0 + 2.0 * radius * f64::from(columns - 1));
                let high = (low.0 + indent, low.1 - indent);
                let heights = (origin.1, origin.1 + 3_f64.sqrt() * radius * last);
                outline(own, low, high, heights, *radius);
            }
        }
        Specimen::Packing { count, columns, spacing, origin, sizes, material, .. } => {
            let counts = own.at_least_one("count", *count, "a number")
                & own.at_least_one("columns", *columns, "a number");
            let fine =
                own.positive("spacing", *spacing, "a spacing in m") & own.place("origin", *origin);
            material_of(own, material.as_deref());
            let limits = check_sizes(&mut own.field("sizes"), sizes);
            if let Some(limits) = limits.filter(|_| fine) {
                packing(own, counts.then_some((*count, *columns)), (*spacing, *origin), limits);
            }
        }
        Specimen::File { material, .. } => {
            if let Some(stored) = context.specimen {
                rows(own, stored, material.as_deref());
            }
        }
        Specimen::State { materials, .. } => state(at, materials),
    }
    bonds::check(at);
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
            not_too_far(at, "position", "the centre", place, radius);
            not_behind(at, "position", "the centre", place, radius);
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

/// Checks the grid on which a packing starts: every cell holds the largest disk, and no disk is behind
/// a wall. `counts` are the numbers of disks and of columns, `None` where one of them is wrong itself.
fn packing(
    at: &mut At,
    counts: Option<(u32, u32)>,
    (spacing, origin): (f64, (f64, f64)),
    (minimum, maximum): (f64, f64),
) {
    let message = format!("smaller than the maximum diameter ({spacing:?})");
    let help = format!("give a spacing in m of {:?} or more", 2.0 * maximum);
    at.refuse(spacing < 2.0 * maximum, "spacing", message, help);
    let Some((count, columns)) = counts else { return };
    // Every disk stays in its cell, so the outermost centres are at least a radius inside the grid.
    let rows = count.div_ceil(columns);
    let in_last = count - (rows - 1) * columns;
    let right = |columns: u32| origin.0 + spacing * f64::from(columns) - minimum;
    let left = origin.0 + minimum;
    let top = origin.1 + spacing * f64::from(rows) - minimum;
    let (low, high) = ((left, right(count.min(columns))), (left, right(in_last)));
    outline(at, low, high, (origin.1 + minimum, top), minimum);
}

fn rows(at: &mut At, stored: &StoredSpecimen, default: Option<&str>) {
    if default.is_some() || stored.rows.iter().any(|row| row.material.is_none()) {
        material_of(at, default);
    }
    let mut wrong = 0;
    for (i, row) in stored.rows.iter().enumerate() {
        let place = (row.x, row.y);
        let whose = format_args!("particle {i} of the file");
        let fine = row.material.as_deref().is_none_or(|name| at.material("path", name))
            & not_too_far(at, "path", whose, place, row.r)
            & not_behind(at, "path", whose, place, row.r);
        wrong += usize::from(!fine);
        if wrong == MAX_SHOWN {
            return;
        }
    }
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
            "add it to `materials` of the scene, or rename it: materials: {{{name:?}: NAME}}, \
             with one of {}",
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
    let before = at.list.len();
    for (i, row) in stored.rows.iter().enumerate() {
        let whose = format_args!("particle {i} of the state");
        not_behind(at, "specimen.path", whose, (row.x, row.y), row.r);
        if at.list.len() >= before + MAX_SHOWN {
            return;
        }
    }
}
