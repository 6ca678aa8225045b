//! Loads of `live` entries of a stage: on the particles that are in their selections when an
//! increment begins.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::body::{AppliedLoad, Ramp};
use clastic_components::increment::Progress;

use super::script::Script;
use super::select::selected;
use crate::scene::format::{Load, ParticleControl, Stage};

/// Name of [`LiveLoads`] in a state.
pub const LIVE_LOADS: &str = "live_loads";

/// The loads of the `live` entries of the stage, in their order. A stage without such entries has
/// no such resource.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LiveLoads(Vec<LiveLoad>);

/// Load on every particle of a selection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct LiveLoad {
    /// The selection as the scene writes it, by which the next stage finds the load.
    select: String,
    /// Values at the start and at the end of the stage, along x and y (N) and of the moment (N m).
    values: [(f64, f64); 3],
}

impl LiveLoads {
    /// Whether any load is on its way to a target.
    pub(super) fn are_ramps(&self) -> bool {
        self.0.iter().any(|load| load.values.iter().any(|(from, to)| from != to))
    }
}

fn live(stage: &Load) -> impl Iterator<Item = &ParticleControl> {
    stage.particles.iter().filter(|control| control.live)
}

fn written(control: &ParticleControl) -> String {
    ron::to_string(&control.select).unwrap_or_default()
}

/// Takes the entries of a stage. A load starts from what an entry with the same selection has
/// reached in the loading stage before, or from zero.
pub(super) fn begin(world: &mut World, stage: &Load) {
    let before = world.remove_resource::<LiveLoads>().unwrap_or_default();
    let loads: Vec<LiveLoad> = live(stage)
        .map(|control| {
            let select = written(control);
            let last = before.0.iter().rev().find(|load| load.select == select);
            let from = last.map_or([0.0; 3], |load| load.values.map(|(_, to)| to));
            let force = control.force;
            let to = [force.map(|f| f.0), force.map(|f| f.1), control.moment];
            LiveLoad { values: [0, 1, 2].map(|k| (from[k], to[k].unwrap_or(from[k]))), select }
        })
        .collect();
    if !loads.is_empty() {
        world.insert_resource(LiveLoads(loads));
    }
}

/// Ends all of them.
pub(super) fn end(world: &mut World) {
    world.remove_resource::<LiveLoads>();
}

/// Makes the values that the loads have reached their targets.
pub(super) fn end_early(world: &mut World, progress: &Progress) {
    let Some(mut loads) = world.get_resource_mut::<LiveLoads>() else { return };
    for (from, to) in loads.0.iter_mut().flat_map(|load| &mut load.values) {
        *to = progress.ramp(*from, *to).from;
    }
}

/// Adds the loads of the increment that begins to those of the particles. Exclusive, because a
/// selection reads every particle of the world.
pub(super) fn add(world: &mut World) {
    let Some(loads) = world.get_resource::<LiveLoads>().cloned() else { return };
    let progress = world.resource::<Progress>().clone();
    let script = world.resource::<Script>();
    let stage = script.scene.stages.get(progress.stage).and_then(Stage::load);
    let selects: Vec<_> =
        stage.into_iter().flat_map(live).map(|control| control.select.clone()).collect();
    for (select, load) in selects.iter().zip(&loads.0) {
        let ramps = load.values.map(|(from, to)| progress.ramp(from, to));
        for (_, entity) in selected(world, select) {
            let Some(mut applied) = world.get_mut::<AppliedLoad>(entity) else { continue };
            for (sum, ramp) in applied.0.iter_mut().zip(ramps) {
                *sum = Ramp { from: sum.from + ramp.from, to: sum.to + ramp.to };
            }
        }
    }
}
