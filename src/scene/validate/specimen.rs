//! Particles, and the recipes that make them.

use clastic_components::domain;

use crate::scene::coincident::coincident;
use crate::scene::diagnostic::MAX_SHOWN;
use crate::scene::format::{Particle, Specimen, Stage, Wall};
use crate::scene::limits::{MAX_MEMORY, MAX_PARTICLES};
use crate::scene::memory::{self, Need};
use crate::scene::specimen_file::StoredSpecimen;

use super::findings::Findings;
use super::outline::{COARSEST, not_behind, not_too_far, outline};
use super::places::{finest, is_behind};
use super::references::material_of;
use super::sizes::check_sizes;
use super::{bonds, state};

pub(super) fn check(findings: &mut Findings) {
    size(findings);
    match &findings.context.scene.specimen {
        Specimen::Particles(list) => particles(list, findings),
        Specimen::Lattice { columns, rows, radius, origin, material } => {
            findings.at_least_one(format_args!("specimen.columns"), *columns, "a number");
            findings.at_least_one(format_args!("specimen.rows"), *rows, "a number");
            let fine = findings.within(format_args!("specimen.radius"), *radius, domain::RADIUS)
                & findings.vector(format_args!("specimen.origin"), *origin, domain::PLACE.what);
            material_of(format_args!("specimen"), material.as_deref(), findings);
            if fine && *columns > 0 && *rows > 0 {
                let last = f64::from(rows - 1);
                let indent = if rows % 2 == 0 && *columns > 1 { *radius } else { 0.0 };
                let low = (origin.0, origin.0 + 2.0 * radius * f64::from(columns - 1));
                let high = (low.0 + indent, low.1 - indent);
                let heights = (origin.1, origin.1 + 3_f64.sqrt() * radius * last);
                outline(low, high, heights, *radius, findings);
            }
        }
        Specimen::Packing { .. } => packing(findings),
        Specimen::File { material, .. } => {
            if let Some(stored) = findings.context.specimen {
                rows(stored, material.as_deref(), findings);
            }
        }
        Specimen::State { materials, .. } => state::check(materials, findings),
    }
    bonds::check(findings);
}

/// Checks that a specimen is not too large for any machine.
fn size(findings: &mut Findings) {
    let context = findings.context;
    if !findings.are_sure_of(&["specimen", "stages"]) {
        return;
    }
    let need = Need::of(context.scene, context.specimen);
    let bytes = memory::size(need.bytes);
    let poured = |stage: &Stage| memory::poured(context.scene, stage) > 0.5 * need.particles as f64;
    let place = match context.scene.stages.iter().position(poured) {
        Some(stage) => format!("stages[{stage}].rate"),
        None => "specimen".to_owned(),
    };
    let path = format_args!("{place}");
    if need.particles > MAX_PARTICLES {
        let message = format!("{} particles, which take about {bytes} of memory", need.particles);
        findings.add(path, message, &format!("give at most {MAX_PARTICLES}"));
    } else if need.bytes > MAX_MEMORY {
        let message = format!(
            "{} particles with about {:.1e} contacts and bonds, which take about {bytes} of memory",
            need.particles, need.pairs,
        );
        let help = "take fewer particles, a shorter `length` of cement, or overlap them less";
        findings.add(path, message, help);
    }
}

fn particles(list: &[Particle], findings: &mut Findings) {
    for (i, particle) in list.iter().enumerate() {
        let path = format_args!("specimen[{i}]");
        let fine = findings.within(format_args!("{path}.radius"), particle.radius, domain::RADIUS)
            & findings.vector(
                format_args!("{path}.position"),
                particle.position,
                domain::PLACE.what,
            );
        findings.vector(format_args!("{path}.velocity"), particle.velocity, domain::VELOCITY.what);
        let spin = particle.angular_velocity;
        findings.finite(format_args!("{path}.angular_velocity"), spin, domain::SPIN.what);
        material_of(path, particle.material.as_deref(), findings);
        if particle.group.as_ref().is_some_and(|group| group.trim().is_empty()) {
            findings.add(format_args!("{path}.group"), "empty name of a group", "give a name");
        }
        if fine && findings.is_sure_of_part(path) {
            let path = format_args!("{path}.position");
            not_too_far(path, "the centre", particle.position, particle.radius, findings);
            not_behind(path, "the centre", particle.position, particle.radius, findings);
        }
    }
    if findings.is_sure_of("specimen") {
        let disk = |p: &Particle| (p.position.0, p.position.1, p.radius);
        let disks: Vec<_> = list.iter().map(disk).collect();
        for (earlier, later) in coincident(&disks, MAX_SHOWN) {
            let message =
                format!("the same place as particle {earlier} {:?}", list[later].position);
            let path = format_args!("specimen[{later}].position");
            findings.add(path, message, "leave one of them out");
        }
    }
}

fn packing(findings: &mut Findings) {
    let Specimen::Packing { count, columns, spacing, origin, sizes, material, .. } =
        &findings.context.scene.specimen
    else {
        return;
    };
    findings.at_least_one(format_args!("specimen.count"), *count, "a number");
    findings.at_least_one(format_args!("specimen.columns"), *columns, "a number");
    let fine = findings.positive(format_args!("specimen.spacing"), *spacing, "a spacing in m")
        & findings.vector(format_args!("specimen.origin"), *origin, domain::PLACE.what);
    material_of(format_args!("specimen"), material.as_deref(), findings);
    let limits = check_sizes(format_args!("specimen.sizes"), sizes, findings);
    let Some((minimum, maximum)) = limits.filter(|_| fine) else { return };
    if *spacing < 2.0 * maximum {
        let message = format!("smaller than the maximum diameter ({spacing:?})");
        let help = format!("give a spacing in m of {:?} or more", 2.0 * maximum);
        findings.add(format_args!("specimen.spacing"), message, &help);
    }
    if *count > 0 && *columns > 0 {
        // Every disk stays in its cell, so the outermost centres are at least a radius inside the
        // grid.
        let rows = count.div_ceil(*columns);
        let in_last = count - (rows - 1) * columns;
        let right = |columns: u32| origin.0 + spacing * f64::from(columns) - minimum;
        let left = origin.0 + minimum;
        let top = origin.1 + spacing * f64::from(rows) - minimum;
        let (low, high) = ((left, right(*count.min(columns))), (left, right(in_last)));
        outline(low, high, (origin.1 + minimum, top), minimum, findings);
    }
}

fn rows(stored: &StoredSpecimen, default: Option<&str>, findings: &mut Findings) {
    let context = findings.context;
    let name_list = &context.materials;
    if default.is_some() || stored.rows.iter().any(|row| row.material.is_none()) {
        material_of(format_args!("specimen"), default, findings);
    }
    let mut shown = 0;
    for (i, row) in stored.rows.iter().enumerate() {
        let is_cut = context.scene.keep.is_some();
        let behind =
            |wall: &&Wall| !is_cut && wall.present && is_behind(wall, (row.x, row.y), row.r);
        let known = row.material.as_deref().is_none_or(|name| name_list.contains(&name));
        let far = finest((row.x, row.y)) > COARSEST * row.r;
        if known && !far && !context.scene.walls.iter().any(|wall| behind(&wall)) {
            continue;
        }
        shown += 1;
        let (path, whose) = (format_args!("specimen.path"), format!("particle {i} of the file"));
        if let Some(name) = row.material.as_deref().filter(|_| !known) {
            findings.reference(path, name, ("material", "materials"), name_list);
        }
        not_too_far(path, &whose, (row.x, row.y), row.r, findings);
        not_behind(path, &whose, (row.x, row.y), row.r, findings);
        if shown == MAX_SHOWN {
            return;
        }
    }
}
