//! Start from a saved state: its bodies, bonds and forces under the settings of another scene.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use clastic_components::body::{BodyId, Probe};
use clastic_components::energy::EnergyLedger;
use clastic_components::membrane::Membrane;
use clastic_components::particle::{MaterialIndex, Particle};
use clastic_components::wall::Wall;
use clastic_systems::identities::IdentityTable;
use clastic_systems::state::StateError;
use clastic_systems::stepping::ClasticHalted;

use super::laws::material_of;
use super::membranes;
use super::settings::insert_settings;
use super::spawn::begin_script;
use super::wall_pieces::count;
use super::walls::{WallCatalogue, spawn_wall};
use crate::saved::SavedState;
use crate::scene::StoredState;
use crate::scene::format::{Scene, Specimen};

/// Fills a world without bodies with a saved state and the settings of a scene. A state with an
/// entry that no plugin registers halts the run before its first increment.
pub(super) fn from_saved(
    world: &mut World,
    scene: &Scene,
    state: &StoredState,
    saved: &SavedState,
) {
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
