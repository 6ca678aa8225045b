//! Systems: checkpoints.

use std::time::Instant;

use bevy_ecs::prelude::*;

use clastic_components::increment::ClasticProgress;
use clastic_components::observation::Observation;
use clastic_systems::schedule::PROGRESS;

use super::checkpoint::Checkpoint;
use super::run_directory::RunDirectory;
use super::{OutputError, directory, frames};
use crate::run::script::Script;
use crate::run::state::{WorldState, capture};
use crate::scene::format::Stage;

/// Run condition: a checkpoint is due.
pub fn is_checkpoint_due(observation: Res<Observation>, run: Res<RunDirectory>) -> bool {
    let every = u64::from(run.options.checkpoint_every);
    every > 0 && observation.increment.is_multiple_of(every)
}

/// Writes a checkpoint. Exclusive, because it reads everything that plugins have registered.
pub fn save(world: &mut World) -> Result<(), OutputError> {
    let clock = Instant::now();
    // The checkpoint does not contain this frame.
    frames::write_peak(world)?;
    let (increment, state) = state(world, directory::CHECKPOINT)?;
    let mut run = world.resource_mut::<RunDirectory>();
    run.checkpoint(increment, state)?.write(run.directory(), directory::CHECKPOINT)?;
    run.saved = Some(increment);
    run.saving += clock.elapsed().as_secs_f64();
    Ok(())
}

/// The checkpoint after the last increment of a run, from which more increments or stages continue.
/// Its stage has not ended yet, since the end cannot be undone: lids stop, tables are taken away.
/// Stages without increments that come after it are made anew by the run that goes on.
#[derive(Resource, Debug)]
pub struct LastCheckpoint(Checkpoint);

/// Run condition: no stage has another increment. A stage of a plugin may still decide otherwise.
pub fn is_last_increment(script: Option<Res<Script>>, progress: Res<ClasticProgress>) -> bool {
    script.is_some_and(|script| {
        let to_come = script.scene.stages.iter().skip(progress.stage + 1);
        script.begun && progress.is_over() && !to_come.clone().any(Stage::has_increments)
    })
}

/// Keeps the checkpoint of the state as it is. Exclusive, because it reads everything that plugins
/// have registered.
pub fn keep_last(world: &mut World) -> Result<(), OutputError> {
    let checkpoint = the_end(world)?;
    world.insert_resource(LastCheckpoint(checkpoint));
    Ok(())
}

/// Writes the checkpoint of a run that has ended: that after its last increment, or of a run without
/// increments the state as it is.
pub fn save_the_end(world: &mut World) -> Result<(), OutputError> {
    let checkpoint = match world.remove_resource::<LastCheckpoint>() {
        Some(LastCheckpoint(checkpoint)) => checkpoint,
        None => the_end(world)?,
    };
    let run = world.resource::<RunDirectory>();
    checkpoint.write(run.directory(), directory::FINAL_CHECKPOINT)
}

fn the_end(world: &mut World) -> Result<Checkpoint, OutputError> {
    let (increment, state) = state(world, directory::FINAL_CHECKPOINT)?;
    let mut run = world.resource_mut::<RunDirectory>();
    Ok(run.checkpoint(increment, state)?.of_the_end())
}

/// The state for the file `name`, and its increment: an undecided one was not committed.
fn state(world: &mut World, name: &str) -> Result<(u64, WorldState), OutputError> {
    let path = world.resource::<RunDirectory>().path(name);
    let state = capture(world).map_err(OutputError::at(&path))?;
    let progress: ClasticProgress = state.get(PROGRESS).map_err(OutputError::at(&path))?;
    Ok((progress.increment, state))
}
