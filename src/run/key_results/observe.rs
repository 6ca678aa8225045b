//! Systems: the key results follow every increment.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::IncrementStatus;
use clastic_components::body::BodyExternalForce;
use clastic_components::contact::BodyTable;
use clastic_components::increment::{ClasticAnalysis, ClasticProgress};
use clastic_components::observation::{Measures, Observation, RuptureCount, StressMeasure};
use clastic_components::wall::Wall;
use clastic_systems::identities::IdentityTable;
use clastic_systems::measures::kept::kept_stresses;

use super::collected::{KeyResults, Phase};
use crate::run::cement::intact;
use crate::run::disks::{in_other_unit, sides};
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
    (measures, walls): (Res<Measures>, Query<(Entity, &Wall, &BodyExternalForce)>),
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
    results.thrust = thrust_beside(&measures, &walls);
    let stress = measures.axial_stress.as_ref().zip(sides(&bodies));
    if stress.is_some_and(|(stress, sides)| in_other_unit(stress, sides).is_some()) {
        let unknown = Observation { axial_stress: None, ..observation.clone() };
        results.observe(&unknown, phase);
    } else {
        results.observe(&observation, phase);
    }
}

/// Maximum normal force of the walls beside the specimen over that of its platens; 0 where the axial stress is not
/// that of walls.
fn thrust_beside(measures: &Measures, walls: &Query<(Entity, &Wall, &BodyExternalForce)>) -> f64 {
    let Some(StressMeasure::Walls { walls: platens, .. }) = &measures.axial_stress else {
        return 0.0;
    };
    let Some(Ok((_, platen, _))) = platens.first().map(|wall| walls.get(*wall)) else { return 0.0 };
    let (mut on, mut beside) = (0.0_f64, 0.0_f64);
    for (entity, wall, force) in walls {
        let force = DVec2::new(force.0[0], force.0[1]).dot(wall.inward()).abs();
        if platens.contains(&entity) {
            on = force.max(on);
        } else if wall.inward().dot(platen.inward()).abs() < FRAC_1_SQRT_2 {
            beside = force.max(beside);
        }
    }
    if on > 0.0 { beside / on } else { 0.0 }
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
