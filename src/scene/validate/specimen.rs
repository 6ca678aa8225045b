//! Particles, the recipes that make them, and their bonds.

use std::collections::BTreeMap;
use std::fmt::Arguments;

use crate::scene::coincident::coincident;
use crate::scene::diagnostic::MAX_SHOWN;
use crate::scene::format::{Particle, Sizes, Specimen, Stage, Wall};
use crate::scene::limits::{MAX_MEMORY, MAX_PARTICLES};
use crate::scene::memory::{self, Need};
use crate::scene::spans::join;
use crate::scene::specimen_file::StoredSpecimen;
use crate::scene::suggest;

use super::findings::Findings;
use super::places::{finest, is_behind};
use super::{Context, state};

/// Maximum spacing of floating-point numbers at a disk, in radii.
const COARSEST: f64 = 1e-4;

pub(super) fn check(context: &Context, findings: &mut Findings) {
    size(context, findings);
    match &context.scene.specimen {
        Specimen::Particles(list) => particles(context, list, findings),
        Specimen::Lattice { columns, rows, radius, origin, material } => {
            findings.at_least_one(format_args!("specimen.columns"), *columns, "a number");
            findings.at_least_one(format_args!("specimen.rows"), *rows, "a number");
            let fine = findings.positive(format_args!("specimen.radius"), *radius, "a radius in m")
                & findings.vector(format_args!("specimen.origin"), *origin, "a place in m");
            material_of(context, format_args!("specimen"), material.as_deref(), findings);
            if fine && *columns > 0 && *rows > 0 {
                let last = f64::from(rows - 1);
                let indent = if rows % 2 == 0 && *columns > 1 { *radius } else { 0.0 };
                let low = (origin.0, origin.0 + 2.0 * radius * f64::from(columns - 1));
                let high = (low.0 + indent, low.1 - indent);
                let heights = (origin.1, origin.1 + 3_f64.sqrt() * radius * last);
                outline(context, low, high, heights, *radius, findings);
            }
        }
        Specimen::Packing { .. } => packing(context, findings),
        Specimen::File { material, .. } => {
            if let Some(stored) = context.specimen {
                rows(context, stored, material.as_deref(), findings);
            }
        }
        Specimen::State { materials, .. } => state::check(context, materials, findings),
    }
    bonds(context, findings);
}

/// Checks that a specimen is not too large for any machine.
fn size(context: &Context, findings: &mut Findings) {
    if !findings.is_sure_of("specimen") || !findings.is_sure_of("stages") {
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

fn particles(context: &Context, list: &[Particle], findings: &mut Findings) {
    for (i, particle) in list.iter().enumerate() {
        let path = format_args!("specimen[{i}]");
        let fine =
            findings.positive(format_args!("{path}.radius"), particle.radius, "a radius in m")
                & findings.vector(
                    format_args!("{path}.position"),
                    particle.position,
                    "a place in m",
                );
        findings.vector(format_args!("{path}.velocity"), particle.velocity, "a velocity in m/s");
        let spin = particle.angular_velocity;
        findings.finite(format_args!("{path}.angular_velocity"), spin, "a velocity in rad/s");
        material_of(context, path, particle.material.as_deref(), findings);
        if particle.group.as_ref().is_some_and(|group| group.trim().is_empty()) {
            findings.add(format_args!("{path}.group"), "empty name of a group", "give a name");
        }
        if fine && findings.is_sure_of_part(path) {
            let path = format_args!("{path}.position");
            not_too_far(path, "the centre", particle.position, particle.radius, findings);
            not_behind(context, path, "the centre", particle.position, particle.radius, findings);
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

fn packing(context: &Context, findings: &mut Findings) {
    let Specimen::Packing { count, columns, spacing, origin, sizes, material, .. } =
        &context.scene.specimen
    else {
        return;
    };
    findings.at_least_one(format_args!("specimen.count"), *count, "a number");
    findings.at_least_one(format_args!("specimen.columns"), *columns, "a number");
    let fine = findings.positive(format_args!("specimen.spacing"), *spacing, "a spacing in m")
        & findings.vector(format_args!("specimen.origin"), *origin, "a place in m");
    material_of(context, format_args!("specimen"), material.as_deref(), findings);
    let limits = self::sizes(format_args!("specimen.sizes"), sizes, findings);
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
        outline(context, low, high, (origin.1 + minimum, top), minimum, findings);
    }
}

/// Checks a size distribution. Returns its minimum and maximum radius.
pub(super) fn sizes(path: Arguments, sizes: &Sizes, findings: &mut Findings) -> Option<(f64, f64)> {
    let radius = format_args!("{path}.radius");
    let what = "a radius in m";
    match sizes {
        Sizes::Equal { radius: r } => findings.positive(radius, *r, what).then_some((*r, *r)),
        Sizes::Uniform { radius: range } => findings.range(radius, *range, what).then_some(*range),
        Sizes::Sieve { passing } => sieve(format_args!("{path}.passing"), passing, findings),
        &Sizes::LogNormal { radius: median, deviation, limits } => {
            let ranged = findings.range(format_args!("{path}.limits"), limits, what);
            findings.not_negative(
                format_args!("{path}.deviation"),
                deviation,
                "a standard deviation of ln(radius)",
            );
            if findings.positive(radius, median, what)
                && ranged
                && !(limits.0..=limits.1).contains(&median)
            {
                let message = format!("the median is outside of the limits ({median:?})");
                findings.add(radius, message, "give a median between the limits");
            }
            ranged.then_some(limits)
        }
    }
}

/// Checks a sieve curve. Returns its minimum and maximum radius.
fn sieve(path: Arguments, passing: &[(f64, f64)], findings: &mut Findings) -> Option<(f64, f64)> {
    let mut fine = true;
    for (i, (diameter, percent)) in passing.iter().enumerate() {
        let what = "a diameter in m";
        fine &= findings.positive(format_args!("{path}[{i}][0]"), *diameter, what);
        let allowed = |percent| (0.0..=100.0).contains(&percent);
        let what = "the per cent by mass that pass, 0 to 100";
        fine &= findings.number(format_args!("{path}[{i}][1]"), *percent, allowed, what);
    }
    if !fine || !findings.is_sure_of_part(path) {
        return None;
    }
    let (Some(first), Some(last)) = (passing.first(), passing.last().filter(|_| passing.len() > 1))
    else {
        let help = "give (diameter, per cent) from 0 to 100 %, two points or more";
        findings.add(path, "a curve of fewer than two points", help);
        return None;
    };
    for (i, step) in passing.windows(2).enumerate() {
        let (before, here) = (step[0], step[1]);
        if here.0 <= before.0 || here.1 < before.1 {
            let message = format!("not above the point before it ({here:?} after {before:?})");
            let help = "order the points by diameter; more per cent pass a larger one";
            findings.add(format_args!("{path}[{}]", i + 1), message, help);
            return None;
        }
    }
    for (i, point, wanted, what) in
        [(0, first, 0.0, "smallest"), (passing.len() - 1, last, 100.0, "largest")]
    {
        if point.1 != wanted {
            let message = format!("{:?} % pass the {what} diameter", point.1);
            let help = format!("begin with 0 % and end with 100 %: give the {what} grain");
            findings.add(format_args!("{path}[{i}]"), message, &help);
            return None;
        }
    }
    let n = passing.len();
    if passing[1].1 == 0.0 || passing[n - 2].1 == 100.0 {
        let i = if passing[1].1 == 0.0 { 0 } else { n - 1 };
        let help = "leave it out: the curve ends at the first 0 % and the first 100 %";
        findings.add(format_args!("{path}[{i}]"), "a step without mass at an end", help);
        return None;
    }
    Some((0.5 * first.0, 0.5 * last.0))
}

fn rows(
    context: &Context,
    stored: &StoredSpecimen,
    default: Option<&str>,
    findings: &mut Findings,
) {
    let name_list = &context.materials;
    if default.is_some() || stored.rows.iter().any(|row| row.material.is_none()) {
        material_of(context, format_args!("specimen"), default, findings);
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
        not_behind(context, path, &whose, (row.x, row.y), row.r, findings);
        if shown == MAX_SHOWN {
            return;
        }
    }
}

/// Checks the corners of a specimen that a recipe makes.
fn outline(
    context: &Context,
    low: (f64, f64),
    high: (f64, f64),
    (bottom, top): (f64, f64),
    radius: f64,
    findings: &mut Findings,
) {
    // What is cut away may lie behind a wall; `cuts` looks at the rest.
    let is_cut = context.scene.keep.is_some();
    if is_cut || !findings.is_sure_of("specimen") || !findings.is_sure_of("walls") {
        return;
    }
    let corners = [(low.0, bottom), (low.1, bottom), (high.0, top), (high.1, top)];
    let far = corners.iter().copied().max_by(|a, b| finest(*a).total_cmp(&finest(*b)));
    if let Some(far) = far {
        not_too_far(format_args!("specimen"), "a corner of it", far, radius, findings);
    }
    let outside =
        |wall: &Wall| wall.present && corners.iter().any(|corner| is_behind(wall, *corner, radius));
    if let Some(wall) = context.scene.walls.iter().find(|wall| outside(wall)) {
        let message = format!("the specimen reaches behind wall `{}`", wall.name);
        let help = "move its origin or the wall; a wall has its inside on the left of start to end";
        findings.add(format_args!("specimen"), message, help);
    }
}

/// Checks that floating-point numbers are fine enough at a disk.
fn not_too_far(
    path: Arguments,
    what: &str,
    place: (f64, f64),
    radius: f64,
    findings: &mut Findings,
) {
    let step = finest(place);
    if step > COARSEST * radius {
        let message = format!("{what} is too far from the origin {place:?}");
        let help = format!(
            "numbers there are {step:.1e} m apart, too coarse for a radius of {radius:?} m"
        );
        findings.add(path, message, &help);
    }
}

pub(super) fn not_behind(
    context: &Context,
    path: Arguments,
    what: &str,
    place: (f64, f64),
    radius: f64,
    findings: &mut Findings,
) {
    if !findings.is_sure_of("walls") || context.scene.keep.is_some() {
        return;
    }
    let present = context.scene.walls.iter().filter(|wall| wall.present);
    for wall in present.filter(|wall| is_behind(wall, place, radius)) {
        let message = format!("{what} is behind wall `{}` {place:?}", wall.name);
        let help = "move it inside; a wall has its inside on the left of start to end";
        findings.add(path, message, help);
    }
}

/// Checks the material of a particle or of a recipe.
pub(super) fn material_of(
    context: &Context,
    path: Arguments,
    material: Option<&str>,
    findings: &mut Findings,
) {
    let names = &context.materials;
    let minerals = &context.scene.minerals;
    match material {
        Some(name) => {
            let path = format_args!("{path}.material");
            findings.reference(path, name, ("material", "materials"), names);
        }
        // `cuts` checks that minerals leave no particle without a material.
        None if !names.is_empty() && !minerals.is_empty() => {}
        None if names.len() != 1 && findings.is_sure_of("materials") => {
            let (message, help) = match names.len() {
                0 => ("missing material: the scene has none", "add one to `materials`".to_owned()),
                _ => {
                    let help = format!("name one of {}", suggest::list(names));
                    ("missing material: the scene has several", help)
                }
            };
            findings.add(format_args!("{path}.material"), message, &help);
        }
        None => {}
    }
}

fn bonds(context: &Context, findings: &mut Findings) {
    let scene = context.scene;
    if !findings.is_sure_of("specimen") || !findings.is_sure_of("bonds") {
        return;
    }
    let mut seen = BTreeMap::new();
    for (i, bond) in scene.bonds.iter().enumerate() {
        let mut exist = true;
        for (end, index) in [("a", bond.a), ("b", bond.b)] {
            exist &= index_exists(context, format_args!("bonds[{i}].{end}"), index, findings);
        }
        let path = format_args!("bonds[{i}]");
        if bond.a == bond.b {
            let message = format!("a bond of particle {} to itself", bond.a);
            findings.add(path, message, "name two particles");
        } else if let Some(first) = seen.insert((bond.a.min(bond.b), bond.a.max(bond.b)), i) {
            let message = format!("a second bond of particles {} and {}", bond.a, bond.b);
            findings.add(path, message, &format!("the first is bonds[{first}]"));
        } else if exist {
            bond_law(context, path, (bond.a, bond.b), findings);
        }
    }
}

fn bond_law(context: &Context, path: Arguments, (a, b): (u32, u32), findings: &mut Findings) {
    let only = (context.materials.len() == 1).then(|| context.materials[0]);
    let of = |index: u32| {
        let index = index as usize;
        if let Some(seeds) = &context.seeds {
            return seeds.get(index)?.material.as_deref().or(only);
        }
        let named = match &context.scene.specimen {
            Specimen::Particles(list) => list.get(index)?.material.as_deref(),
            Specimen::Lattice { material, .. } | Specimen::Packing { material, .. } => {
                material.as_deref()
            }
            Specimen::File { material, .. } => {
                let row = context.specimen?.rows.get(index)?;
                row.material.as_deref().or(material.as_deref())
            }
            Specimen::State { .. } => context.specimen?.rows.get(index)?.material.as_deref(),
        };
        named.or(only)
    };
    // A missing or unknown material is reported at the particle.
    let lawless = |name: &&str| {
        context.scene.materials.get(*name).is_some_and(|material| material.bond.is_none())
    };
    let material = [of(a), of(b)].into_iter().flatten().find(lawless);
    if let Some(name) = material.filter(|_| findings.is_sure_of("materials")) {
        let help = format!("add `bond: (...)` to {}", join("materials", name));
        findings.add(path, format!("material `{name}` has no bond law"), &help);
    }
}

/// Checks the index of a particle.
pub(super) fn index_exists(
    context: &Context,
    path: Arguments,
    index: u32,
    findings: &mut Findings,
) -> bool {
    let exists = context.particles.is_none_or(|count| u64::from(index) < count);
    if !exists && findings.is_sure_of("specimen") {
        let count = context.particles.unwrap_or_default();
        let help = match count {
            0 => "the specimen has no particles".to_owned(),
            _ => format!("the particles are 0 to {}", count - 1),
        };
        findings.add(path, format!("no such particle ({index})"), &help);
    }
    exists
}
