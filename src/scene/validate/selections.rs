//! Regions and sets that select no particle, so that a control of particles would have no effect.
//!
//! Positions are known until a stage moves the particles, and the particles until one is removed.
//! The check therefore covers the first stage that loads or removes. For later stages the run makes
//! this check when they begin.

use std::collections::BTreeMap;

use glam::DVec2;

use super::findings::At;
use crate::run::select::{Candidate, selects};
use crate::scene::format::{Particle, Select, Specimen, Stage};
use crate::scene::spans::join;

pub(super) fn check(at: &mut At) {
    let context = at.context;
    let scene = context.scene;
    let moves = |stage: &Stage| !matches!(stage, Stage::Cement(_) | Stage::Save(_));
    let unmoved = scene.stages.iter().position(moves);
    let Some((i, stage)) = unmoved.map(|i| (i, &scene.stages[i])) else { return };
    let is_known = match &scene.specimen {
        // A run that is resumed does not read the state again, and its particles are elsewhere.
        Specimen::State { .. } => context.state().is_some_and(|state| state.saved.is_some()),
        _ => context.is_read(),
    };
    // Rows are not indices where particles were taken away before.
    let has_gaps =
        context.specimen.is_some_and(|stored| stored.indices != stored.rows.len() as u64);
    if !is_known || has_gaps || regions(stage, &scene.groups).next().is_none() {
        return;
    }
    // An invalid recipe makes no particles.
    let at = &mut at.item("stages", i);
    let is_sound = at.are_sound(&["specimen", "groups", "materials", "minerals", "keep"])
        && ["particles", "rigid", "select"].iter().all(|field| at.is_sound(&at.path(field)));
    if !is_sound {
        return;
    }
    let seeds = context.at_start();
    let only = context.materials.first().filter(|_| context.materials.len() == 1);
    let probes: BTreeMap<u32, &str> =
        scene.probes.iter().map(|(name, index)| (*index, name.as_str())).collect();
    for (entry, select) in regions(stage, &scene.groups) {
        let has = |(seed, index): (&Particle, u32)| {
            let of = Candidate {
                index,
                place: seed.position.into(),
                material: seed.material.as_deref().or(only.copied()),
                group: seed.group.as_deref(),
                probe: seed.probe.as_deref().or(probes.get(&index).copied()),
                core: u32::MAX,
            };
            selects(select, &scene.groups, &of)
        };
        if !seeds.iter().zip(0..).any(has) {
            let (why, what) = match select {
                Select::Box { .. } => (": no centre is in the box", "a box that holds some"),
                _ => ("", "one that has some"),
            };
            at.add(entry, format!("selects no particle{why}"), bounds(what, &seeds));
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
