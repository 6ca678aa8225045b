//! Layers, minerals and cuts of a specimen.

use std::collections::BTreeSet;

use crate::run::particles::BOUNDARY;
use crate::scene::format::{Scene, Select, Specimen};
use crate::scene::limits::MAX_PARTICLES;
use crate::scene::memory;
use crate::scene::specimen_file::StoredSpecimen;
use crate::scene::suggest;

use super::findings::Findings;
use super::places::is_behind;
use super::{Context, select};

/// Whether `minerals` or `keep` change the specimen, and it can be made to see how.
pub(super) fn is_manageable(scene: &Scene, stored: Option<&StoredSpecimen>) -> bool {
    let is_resumed = stored.is_some_and(StoredSpecimen::is_resumed);
    let changes = !is_resumed && (scene.keep.is_some() || !scene.minerals.is_empty());
    let is_recipe = match &scene.specimen {
        Specimen::State { .. } => false,
        Specimen::File { .. } => stored.is_some(),
        Specimen::Packing { columns, .. } => *columns > 0,
        Specimen::Particles(_) | Specimen::Lattice { .. } => true,
    };
    changes && is_recipe && memory::particles(&scene.specimen, stored) <= MAX_PARTICLES
}

pub(super) fn check(findings: &mut Findings) {
    let context = findings.context;
    let scene = context.scene;
    if context.is_resumed() {
        return;
    }
    for (i, mineral) in scene.minerals.iter().enumerate() {
        let path = format_args!("minerals[{i}]");
        let names = &context.materials;
        let kind = ("material", "materials");
        findings.reference(format_args!("{path}.material"), &mineral.material, kind, names);
        of_specimen(format!("{path}.select"), &mineral.select, findings);
        if let Some(clusters) = &mineral.clusters {
            let path = format_args!("{path}.clusters");
            let allowed = |share| share > 0.0 && share <= 1.0;
            let what = "a share above 0 and up to 1";
            findings.number(format_args!("{path}.share"), clusters.share, allowed, what);
            findings.positive(format_args!("{path}.size"), clusters.size, "a size in m");
        }
    }
    if let Some(keep) = &scene.keep {
        of_specimen("keep".to_owned(), keep, findings);
    }
    let field = if scene.keep.is_some() { "keep" } else { "minerals" };
    let changes = scene.keep.is_some() || !scene.minerals.is_empty();
    if changes && matches!(scene.specimen, Specimen::State { .. }) {
        let help = "change the specimen in the scene that makes the state";
        findings.add(format_args!("{field}"), "a saved state is taken as it is", help);
        return;
    }
    let parts = ["specimen", "materials", "minerals", "keep"];
    let Some(seeds) = &context.seeds else { return };
    if !findings.are_sound(&parts) {
        return;
    }
    if seeds.is_empty() && memory::particles(&scene.specimen, context.specimen) > 0 {
        let help = "keep a part of the specimen that has particles";
        findings.add(format_args!("keep"), "no particle is left", help);
    }
    let several = context.materials.len() > 1;
    if let Some(bare) = seeds.iter().position(|seed| several && seed.material.is_none()) {
        let place = seeds[bare].position;
        let message = format!("the particle at ({:?}, {:?}) gets no material", place.x, place.y);
        let help = format!(
            "give the specimen a `material`, one of {}, or select it here",
            suggest::list(&context.materials)
        );
        findings.add(format_args!("minerals"), message, &help);
    }
    if scene.keep.is_some() && findings.is_sound("walls") {
        let present = || scene.walls.iter().filter(|wall| wall.present);
        let hidden = seeds.iter().find_map(|seed| {
            let place = (seed.position.x, seed.position.y);
            let wall = present().find(|wall| is_behind(wall, place, seed.radius))?;
            Some((place, &wall.name))
        });
        if let Some((place, wall)) = hidden {
            let message = format!("a particle that is left is behind wall `{wall}` {place:?}");
            let help = "cut it away, or move the wall";
            findings.add(format_args!("keep"), message, help);
        }
    }
}

/// Checks a selection from the specimen, in which the groups of the scene are not known.
fn of_specimen(path: String, of: &Select, findings: &mut Findings) {
    let context = findings.context;
    let groups: BTreeSet<&str> = match &context.scene.specimen {
        Specimen::Particles(list) => list.iter().filter_map(|p| p.group.as_deref()).collect(),
        Specimen::Lattice { .. } => BTreeSet::from([BOUNDARY]),
        _ => BTreeSet::new(),
    };
    let named = names(of).into_iter().find(|name| !groups.contains(name));
    if let Some(name) = named {
        let message = format!("the specimen has no group `{name}`");
        let help = "give the region itself: groups of the scene select from the specimen as cut";
        findings.add(format_args!("{path}"), message, help);
        return;
    }
    if of.needs_forces(&context.scene.groups) {
        let help = "select by place, or take loose particles away in a `Remove` stage";
        findings.add(format_args!("{path}"), "no contact carries force yet", help);
    }
    let whole = Context::uncut(context.scene, context.specimen);
    let mut of_whole = findings.of(&whole);
    select::select(format_args!("{path}"), of, &mut of_whole);
    findings.extend(of_whole);
}

/// Groups that a selection names.
fn names(select: &Select) -> Vec<&str> {
    match select {
        Select::Group(name) => vec![name],
        _ => select.parts().into_iter().flat_map(names).collect(),
    }
}
