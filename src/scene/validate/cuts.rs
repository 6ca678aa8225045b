//! Layers, minerals and cuts of a specimen.

use std::collections::BTreeMap;

use crate::scene::format::{Scene, Select, Sizes, Specimen};
use crate::scene::limits::MAX_PARTICLES;
use crate::scene::memory;
use crate::scene::stored_state::StoredSpecimen;
use crate::text::suggest;

use super::findings::At;
use super::places::walls_before;
use super::{Context, select};

/// Whether `minerals` or `keep` change the specimen, and it can be made to see how.
pub(super) fn is_manageable(scene: &Scene, stored: Option<&StoredSpecimen>) -> bool {
    let is_resumed = stored.is_some_and(StoredSpecimen::is_resumed);
    let changes = !is_resumed && (scene.keep.is_some() || !scene.minerals.is_empty());
    let is_recipe = match &scene.specimen {
        Specimen::State { .. } => false,
        Specimen::File { .. } => stored.is_some(),
        Specimen::Packing { columns, sizes, .. } => {
            let is_curve = |passing: &[_]| passing.len() > 1;
            *columns > 0 && !matches!(sizes, Sizes::Sieve { passing } if !is_curve(passing))
        }
        Specimen::Particles(_) | Specimen::Lattice { .. } => true,
    };
    changes && is_recipe && memory::particles(&scene.specimen, stored) <= MAX_PARTICLES
}

pub(super) fn check(at: &mut At) {
    let context = at.context;
    let scene = context.scene;
    if context.is_resumed() {
        return;
    }
    for (i, mineral) in scene.minerals.iter().enumerate() {
        let at = &mut at.item("minerals", i);
        at.material("material", &mineral.material);
        of_specimen(&mut at.field("select"), &mineral.select);
    }
    if let Some(keep) = &scene.keep {
        of_specimen(&mut at.field("keep"), keep);
    }
    let field = if scene.keep.is_some() { "keep" } else { "minerals" };
    let changes = scene.keep.is_some() || !scene.minerals.is_empty();
    if changes && matches!(scene.specimen, Specimen::State { .. }) {
        let help = "change the specimen in the scene that makes the state";
        at.add(field, "a saved state is taken as it is", help);
        return;
    }
    let Some(seeds) = &context.seeds else { return };
    if !at.are_sound(&["specimen", "materials", "minerals", "keep"]) {
        return;
    }
    let is_lost = seeds.is_empty() && memory::particles(&scene.specimen, context.specimen) > 0;
    let help = "keep a part of the specimen that has particles";
    at.refuse(is_lost, "keep", "no particle is left", help);
    for (i, mineral) in scene.minerals.iter().enumerate() {
        let takes = seeds.iter().any(|seed| seed.material.as_ref() == Some(&mineral.material));
        let help = "give a selection in m that has particles of the specimen, or leave it out";
        let at = &mut at.item("minerals", i);
        at.refuse(!takes && !is_lost, "select", "no particle gets its material", help);
    }
    let several = context.materials.len() > 1;
    if let Some(bare) = seeds.iter().find(|seed| several && seed.material.is_none()) {
        let message = format!("the particle at {:?} gets no material", bare.position);
        let names = suggest::list(&context.materials);
        let help = format!("give the specimen a `material`, one of {names}, or select it here");
        at.add("minerals", message, help);
    }
    if scene.keep.is_some() && at.are_sound(&["walls"]) {
        let hidden = seeds.iter().find_map(|seed| {
            let place = seed.position;
            Some((place, &walls_before(scene, place, seed.radius).next()?.name))
        });
        if let Some((place, wall)) = hidden {
            let message = format!("a particle that is left is behind wall `{wall}` {place:?}");
            at.add("keep", message, "cut it away, or move the wall");
        }
    }
}

/// Checks a selection from the specimen, in which the groups of the scene are not known.
fn of_specimen(at: &mut At, of: &Select) {
    let context = at.context;
    let groups = context.groups_of_specimen();
    let no_groups = BTreeMap::new();
    let unknown = |part: &&Select| matches!(part, Select::Group(name) if !groups.contains(&**name));
    if let Some(Select::Group(name)) = of.all(&no_groups).into_iter().find(unknown) {
        let message = format!("the specimen has no group `{name}`");
        let help = "give the region itself: groups of the scene select from the specimen as cut";
        at.add("", message, help);
        return;
    }
    let help = "select by place, or take loose particles away in a `Remove` stage";
    at.refuse(of.needs_forces(&context.scene.groups), "", "no contact carries force yet", help);
    at.with(&Context::uncut(context.scene, context.specimen), |at| select::select(at, of));
}
