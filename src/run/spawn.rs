//! Fills a world with a scene: settings, particles, walls, explicit bonds, stages.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use clastic_components::body::{
    BodyAngularVelocity, BodyId, BodyOrigin, BodyPosition, BodyVelocity, Group, Probe,
};
use clastic_components::energy::EnergyLedger;
use clastic_components::observation::{Measures, Observation};
use clastic_components::particle::{MaterialIndex, Particle};
use clastic_systems::identities::{IdentityTable, NextIdentities};
use clastic_systems::stepping::EndOfRun;

use super::cement::bond_pairs;
use super::key_results::{KeyResults, count_bonds};
use super::laws::material_of;
use super::minerals::specimen;
use super::sanity::Sanity;
use super::script::Script;
pub use super::settings::{analysis, insert_settings};
use super::start;
pub use super::walls::{WallCatalogue, find_wall, find_walls, spawn_wall};
use crate::scene::format as scene;
use crate::scene::specimen_file::StoredSpecimen;

/// Fills `world` with a scene. The world must have the resources of
/// [`ClasticPlugins`](crate::ClasticPlugins).
///
/// # Panics
/// If the world has bodies already. A world holds one scene: bodies are numbered from 0, and the
/// bodies of two scenes would have the same numbers.
pub fn spawn_scene(world: &mut World, scene: &scene::Scene, stored: Option<&StoredSpecimen>) {
    let bodies = world.query::<&BodyId>().iter(world).count();
    assert!(
        bodies == 0,
        "spawn_scene: the world has {bodies} bodies already, and a world holds one scene; use a new world"
    );
    if let Some(state) = stored.and_then(|stored| stored.state.as_ref())
        && let Some(saved) = &state.saved
    {
        return start::from_saved(world, scene, state, saved);
    }
    let seeds = specimen(scene, stored);
    insert_settings(world, scene, seeds.len() as u32);
    let probes: BTreeMap<u32, &String> = scene.probes.iter().map(|(name, i)| (*i, name)).collect();
    for (i, seed) in seeds.iter().enumerate() {
        let (material, density) = material_of(scene, seed.material.as_ref());
        let mut entity = world.spawn((
            BodyId(i as u32),
            Particle::disk(seed.radius, density, scene.thickness),
            BodyPosition(seed.position.into()),
            BodyOrigin(seed.position.into()),
            BodyVelocity(seed.velocity.into()),
            BodyAngularVelocity(seed.angular_velocity),
            MaterialIndex(material),
        ));
        if let Some(group) = &seed.group {
            entity.insert(Group(group.clone()));
        }
        if let Some(probe) = seed.probe.as_ref().or(probes.get(&(i as u32)).copied()) {
            entity.insert(Probe(probe.clone()));
        }
    }

    if let Some(cell) = &scene.cell {
        world.insert_resource(super::cell::at_start(cell));
    }
    for wall in scene.walls.iter().filter(|w| w.present) {
        spawn_wall(world, &wall.name);
    }
    // Walls that come later have the identities after the particles too.
    let body = world.resource::<WallCatalogue>().first_of(scene.walls.len());
    world.get_resource_or_init::<IdentityTable>().skip_to(NextIdentities { body, bond: 0 });
    if scene.output.energy {
        world.insert_resource(EnergyLedger::default());
    }
    begin_script(world, scene);
}

/// Adds the bonds that the scene lists, and its stages, to a world that has its bodies.
pub(super) fn begin_script(world: &mut World, scene: &scene::Scene) {
    insert_script(world, scene);
    bond_pairs(world, scene.bonds.iter().map(|bond| (bond.a, bond.b)));
    // The stages read the record, also where another plugin writes it.
    world.init_resource::<Observation>();
    world.init_resource::<Measures>();
    world.insert_resource(KeyResults::of_scene(scene));
    count_bonds(world);
    world.init_resource::<Sanity>();
}

/// Inserts the stages of a scene, before the first one.
pub(super) fn insert_script(world: &mut World, scene: &scene::Scene) {
    world.insert_resource(Script::new(scene));
    // A collapse ends a stage, and an undecided increment the run.
    world.insert_resource(EndOfRun::default());
}
