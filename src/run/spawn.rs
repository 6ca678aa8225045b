//! Fills a world with a scene: settings, particles, walls, explicit bonds, stages; or with a saved
//! state, its bodies, bonds and forces, under the settings of another scene.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_systems::identities::{IdentityTable, NextIdentities};
use clastic_systems::state::StateError;
use clastic_systems::stepping::{ClasticHalted, EndOfRun};

use super::cement::bond_pairs;
use super::key_results::{KeyResults, count_bonds};
use super::laws::material_of;
use super::membranes;
use super::minerals::specimen;
use super::sanity::Sanity;
use super::script::Script;
pub use super::settings::{analysis, insert_settings};
use super::wall_pieces::count;
pub use super::walls::{WallCatalogue, find_wall, find_walls, spawn_wall};
use crate::saved::SavedState;
use crate::scene::StoredState;
use crate::scene::format::{Scene, Specimen};
use crate::scene::specimen_file::StoredSpecimen;

/// Fills `world` with a scene. The world must have the resources of
/// [`ClasticPlugins`](crate::ClasticPlugins).
///
/// # Panics
/// If the world has bodies already. A world holds one scene: bodies are numbered from 0, and the
/// bodies of two scenes would have the same numbers.
pub fn spawn_scene(world: &mut World, scene: &Scene, stored: Option<&StoredSpecimen>) {
    let bodies = world.query::<&BodyId>().iter(world).count();
    assert!(
        bodies == 0,
        "spawn_scene: the world has {bodies} bodies already, and a world holds one scene; use a new world"
    );
    if let Some(state) = stored.and_then(|stored| stored.state.as_ref())
        && let Some(saved) = &state.saved
    {
        return from_saved(world, scene, state, saved);
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
fn begin_script(world: &mut World, scene: &Scene) {
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
pub(super) fn insert_script(world: &mut World, scene: &Scene) {
    world.insert_resource(Script::new(scene));
    // A collapse ends a stage, and an undecided increment the run.
    world.insert_resource(EndOfRun::default());
}

/// Fills a world without bodies with a saved state and the settings of a scene. A state with an
/// entry that no plugin registers halts the run before its first increment.
fn from_saved(world: &mut World, scene: &Scene, state: &StoredState, saved: &SavedState) {
    insert_settings(world, scene, saved.next.body);
    if let Err(error) = restore(world, scene, state, saved) {
        world.insert_resource(ClasticHalted(format!("the saved state cannot be used: {error}")));
    }
    begin_script(world, scene);
    membranes::renew(world);
}

fn restore(
    world: &mut World,
    scene: &Scene,
    state: &StoredState,
    saved: &SavedState,
) -> Result<(), StateError> {
    saved.world.restore(world)?;
    materials(world, scene, saved);
    probes(world, scene);
    walls(world, scene, state, saved);
    world.resource_mut::<WallCatalogue>().rigid.clone_from(&state.rigid);
    if scene.output.energy {
        world.init_resource::<EnergyLedger>();
    } else {
        world.remove_resource::<EnergyLedger>();
    }
    Ok(())
}

/// Gives the particles the materials of the scene, by name, and the masses that follow.
fn materials(world: &mut World, scene: &Scene, saved: &SavedState) {
    let Specimen::State { materials: renamed, .. } = &scene.specimen else { return };
    let same_thickness = scene.thickness.to_bits() == saved.thickness.to_bits();
    // By index in the state: index in the scene, and the density if masses change.
    let of = saved.materials.iter().map(|(name, before)| {
        let (index, density) = material_of(scene, Some(renamed.get(name).unwrap_or(name)));
        let stays = same_thickness && density.to_bits() == before.to_bits();
        (index, (!stays).then_some(density))
    });
    let of: Vec<(u32, Option<f64>)> = of.collect();
    let mut particles = world.query::<(Entity, &Particle, &mut MaterialIndex)>();
    let mut heavier = Vec::new();
    for (entity, particle, mut material) in particles.iter_mut(world) {
        let Some((index, density)) = of.get(material.0 as usize) else { continue };
        material.0 = *index;
        if let Some(density) = density {
            heavier.push((entity, Particle::disk(particle.radius, *density, scene.thickness)));
        }
    }
    for (entity, particle) in heavier {
        world.entity_mut(entity).insert(particle);
    }
}

/// Gives particles the names under which the scene records them.
fn probes(world: &mut World, scene: &Scene) {
    let names: BTreeMap<u32, &String> = scene.probes.iter().map(|(name, i)| (*i, name)).collect();
    let mut particles = world.query_filtered::<(Entity, &BodyId), With<Particle>>();
    let ids: Vec<_> = particles.iter(world).map(|(entity, id)| (entity, id.0)).collect();
    for (entity, id) in ids {
        match names.get(&id) {
            Some(name) => world.entity_mut(entity).insert(Probe((*name).clone())),
            None => world.entity_mut(entity).remove::<Probe>(),
        };
    }
}

/// Keeps the walls of the state and its membranes, or takes them away and adds the walls that the
/// scene lists.
fn walls(world: &mut World, scene: &Scene, state: &StoredState, saved: &SavedState) {
    if state.gives_walls || scene.walls.is_empty() {
        world.insert_resource(WallCatalogue {
            first: saved.first_wall,
            walls: saved.walls.clone(),
            inherited: Some(state.walls.clone()),
            membranes: state.membranes.clone(),
            rigid: Vec::new(),
        });
        return;
    }
    let mut there = world.query_filtered::<Entity, Or<(With<Wall>, With<Membrane>)>>();
    for entity in there.iter(world).collect::<Vec<_>>() {
        world.despawn(entity);
    }
    for wall in scene.walls.iter().filter(|wall| wall.present) {
        spawn_wall(world, &wall.name);
    }
    let mut next = saved.next;
    next.body += scene.walls.iter().map(count).sum::<u32>();
    world.get_resource_or_init::<IdentityTable>().skip_to(next);
}
