//! The stages of a scene, in a world that has its bodies.

use bevy_ecs::prelude::*;

use clastic_components::observation::{Measures, Observation};
use clastic_systems::stepping::EndOfRun;

use super::cement::bond_pairs;
use super::key_results::{KeyResults, count_bonds};
use super::sanity::Sanity;
use super::script::Script;
use crate::scene::format as scene;

/// Adds the bonds that the scene lists, and its stages, to a world that has its bodies.
pub(super) fn begin_script(world: &mut World, scene: &scene::Scene) {
    bond_pairs(world, scene.bonds.iter().map(|bond| (bond.a, bond.b)));
    // The stages read the record, also where another plugin writes it.
    world.init_resource::<Observation>();
    world.init_resource::<Measures>();
    world.insert_resource(KeyResults::of_scene(scene));
    count_bonds(world);
    world.init_resource::<Sanity>();
    insert_script(world, scene);
}

/// Inserts the stages of a scene, before the first one.
pub(super) fn insert_script(world: &mut World, scene: &scene::Scene) {
    world.insert_resource(Script::new(scene));
    // A collapse ends a stage, and an undecided increment the run.
    world.insert_resource(EndOfRun::default());
}
