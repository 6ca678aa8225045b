//! Regions and sets that select no particle, so that a control of particles would have no effect.
//!
//! Positions are known until a stage moves the particles, and the particles until one is removed.
//! The check therefore covers the first stage that loads or removes. For later stages the run makes
//! this check when they begin.

use std::collections::BTreeMap;

use super::findings::Findings;
use crate::run::particles::ParticleSeed;
use crate::run::select::{Candidate, selects};
use crate::scene::format::{Select, Specimen, Stage};
use crate::scene::spans::join;

pub(super) fn check(findings: &mut Findings) {
    let context = findings.context;
    let scene = context.scene;
    let moves = |stage: &Stage| !matches!(stage, Stage::Cement(_) | Stage::Save(_));
    let unmoved = scene.stages.iter().position(moves);
    let Some((i, stage)) = unmoved.map(|i| (i, &scene.stages[i])) else { return };
    let is_read = match &scene.specimen {
        Specimen::File { .. } => context.specimen.is_some(),
        Specimen::State { .. } => context.starts_here(),
        _ => true,
    };
    // Rows are not indices where particles were taken away before.
    let has_gaps =
        context.specimen.is_some_and(|stored| stored.indices != stored.rows.len() as u64);
    if !is_read || has_gaps || regions(stage, &scene.groups).next().is_none() {
        return;
    }
    // An invalid recipe makes no particles.
    let parts = ["specimen", "groups", "materials", "minerals", "keep"];
    let fields = ["particles", "rigid", "select"].map(|field| format!("stages[{i}].{field}"));
    if !findings.are_sound(&parts) || !fields.iter().all(|field| findings.is_sound(field)) {
        return;
    }
    let seeds = context.at_start();
    let only = context.materials.first().filter(|_| context.materials.len() == 1);
    let probes: BTreeMap<u32, &str> =
        scene.probes.iter().map(|(name, index)| (*index, name.as_str())).collect();
    let centres: Vec<_> = seeds.iter().map(|seed| (seed.position.x, seed.position.y)).collect();
    for (entry, select) in regions(stage, &scene.groups) {
        let has = |(seed, index): (&ParticleSeed, u32)| {
            let of = Candidate {
                index,
                place: seed.position,
                material: seed.material.as_deref().or(only.copied()),
                group: seed.group.as_deref(),
                probe: seed.probe.as_deref().or(probes.get(&index).copied()),
                core: u32::MAX,
            };
            selects(select, &scene.groups, &of)
        };
        if !seeds.iter().zip(0..).any(has) {
            let path = format_args!("stages[{i}].{entry}");
            if let Select::Box { .. } = select {
                let message = "selects no particle: no centre is in the box";
                findings.add(path, message, &bounds("a box that holds some", &centres));
            } else {
                findings.add(path, "selects no particle", &bounds("one that has some", &centres));
            }
        }
    }
}

/// Entries of a stage whose particles depend on places or on sets: place and selection.
fn regions<'a>(
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
fn bounds(what: &str, centres: &[(f64, f64)]) -> String {
    let Some(first) = centres.first() else { return "the specimen has no particles".to_owned() };
    let (mut low, mut high) = (*first, *first);
    for (x, y) in centres {
        low = (low.0.min(*x), low.1.min(*y));
        high = (high.0.max(*x), high.1.max(*y));
    }
    format!(
        "give {what}: the centres are between ({:.4e}, {:.4e}) and ({:.4e}, {:.4e})",
        low.0, low.1, high.0, high.1
    )
}
