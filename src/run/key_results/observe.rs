//! Systems: the key results follow every increment.

use std::f64::consts::PI;

use bevy_ecs::prelude::*;

use clastic_components::attempt::IncrementStatus;
use clastic_components::contact::BodyTable;
use clastic_components::increment::{ClasticAnalysis, ClasticProgress};
use clastic_components::observation::{Observation, RuptureCount};
use clastic_systems::identities::IdentityTable;
use clastic_systems::measures::kept::kept_stresses;

use super::collected::{KeyResults, Phase};
use crate::run::cement::intact;
use crate::run::script::Script;
use crate::run::walls::WallCatalogue;
use crate::scene::format::{Specimen, Stage};

/// Run condition: the increment is undecided.
pub(crate) fn is_undecided(observation: Res<Observation>) -> bool {
    observation.status == IncrementStatus::Undecided
}

/// Records the increment in the key results.
pub(crate) fn observe_increment(
    (script, progress): (Res<Script>, Res<ClasticProgress>),
    observation: Res<Observation>,
    (bodies, analysis): (Res<BodyTable>, Res<ClasticAnalysis>),
    identities: Res<IdentityTable>,
    mut results: ResMut<KeyResults>,
) {
    let is_compaction = matches!(script.stage(progress.stage), Some(Stage::Compact(_)));
    let phase = match (is_compaction, progress.stage >= script.reference_stage()) {
        (true, _) => Phase::Preparation,
        (false, false) => Phase::Loading,
        (false, true) => Phase::Reference,
    };
    results.see_bonds(identities.next().bond as usize);
    let area: f64 = bodies.radii.iter().map(|r| PI * r * r).sum();
    let volume = area * analysis.thickness;
    results.kinetic = analysis.kind.dt().map_or(0.0, |_| observation.kinetic_energy / volume);
    results.observe(&observation, phase);
}

/// Records the bonds that are there. A stage that makes bonds may be the last one, which no
/// increment follows.
pub(crate) fn count_bonds(world: &mut World) {
    let created = world.resource::<IdentityTable>().next().bond as usize;
    let intact = intact(world);
    world.resource_mut::<KeyResults>().count_bonds(created, intact);
}

/// Takes the stresses at the start of the reference stage from the forces of a saved state. Where
/// the scene has walls of its own they carry nothing yet, and the start stays unknown.
pub(crate) fn start_from_state(world: &mut World) {
    let scene = &world.resource::<Script>().scene;
    let has_its_walls = world.resource::<WallCatalogue>().inherited.is_some();
    if !matches!(scene.specimen, Specimen::State { .. }) || !has_its_walls {
        return;
    }
    let broken = world.get_resource::<RuptureCount>().map_or(0, |count| count.0.iter().sum());
    if let [Some(axial), lateral] = kept_stresses(world) {
        world.resource_mut::<KeyResults>().start_from(axial, lateral, broken);
    }
}
