//! Systems: checkpoints.

use std::time::Instant;

use bevy_ecs::prelude::*;

use clastic_components::increment::ClasticProgress;
use clastic_components::observation::Observation;
use clastic_systems::schedule::PROGRESS;

use super::checkpoint::{Checkpoint, WHOLE};
use super::run_directory::RunDirectory;
use super::{OutputError, directory, frames};
use crate::run::script::Script;
use crate::run::state::capture;
use crate::scene::format::Stage;

/// Run condition: a checkpoint is due.
pub(crate) fn is_checkpoint_due(observation: Res<Observation>, run: Res<RunDirectory>) -> bool {
    let every = u64::from(run.options.checkpoint_every);
    every > 0 && observation.increment.is_multiple_of(every)
}

/// Writes a checkpoint. Exclusive, because it reads everything that plugins have registered.
pub fn save(world: &mut World) -> Result<(), OutputError> {
    let clock = Instant::now();
    // The checkpoint does not contain this frame.
    frames::write_peak(world)?;
    let checkpoint = checkpoint(world, directory::CHECKPOINT)?;
    let mut run = world.resource_mut::<RunDirectory>();
    checkpoint.write(run.directory(), directory::CHECKPOINT)?;
    run.saved = Some(checkpoint.increment);
    run.saving += clock.elapsed().as_secs_f64();
    Ok(())
}

/// Run condition: no stage has another increment. A stage of a plugin may still decide otherwise.
pub(crate) fn is_last_increment(
    script: Option<Res<Script>>,
    progress: Res<ClasticProgress>,
) -> bool {
    script.is_some_and(|script| {
        let to_come = script.scene.stages.iter().skip(progress.stage + 1);
        script.begun && progress.is_over() && !to_come.clone().any(Stage::has_increments)
    })
}

/// Keeps the checkpoint after the last increment. Its stage has not ended yet, since the end cannot
/// be undone: lids stop, tables are taken away. Stages without increments that come after it are
/// made anew by the run that goes on. Exclusive, as [`save`].
pub(crate) fn keep_last(world: &mut World) -> Result<(), OutputError> {
    let last = the_end(world)?;
    world.resource_mut::<RunDirectory>().last = Some(last);
    Ok(())
}

/// Writes the checkpoint of a run that has ended: that after its last increment, or of a run without
/// increments the state as it is.
pub(crate) fn save_the_end(world: &mut World) -> Result<(), OutputError> {
    let last = world.resource_mut::<RunDirectory>().last.take();
    let checkpoint = last.map_or_else(|| the_end(world), Ok)?;
    let run = world.resource::<RunDirectory>();
    checkpoint.write(run.directory(), directory::FINAL_CHECKPOINT)
}

/// The state as it is as the checkpoint of the end, which has the same bytes in every run.
fn the_end(world: &mut World) -> Result<Checkpoint, OutputError> {
    let mut checkpoint = checkpoint(world, directory::FINAL_CHECKPOINT)?;
    checkpoint.options.checkpoint_every = 0;
    // The length of the timings is another in every run.
    checkpoint.lengths[3] = WHOLE;
    Ok(checkpoint)
}

/// The checkpoint for the file `name`. An undecided increment was not committed, and does not count.
fn checkpoint(world: &mut World, name: &str) -> Result<Checkpoint, OutputError> {
    let path = world.resource::<RunDirectory>().path(name);
    let state = capture(world).map_err(OutputError::at(&path))?;
    let progress: ClasticProgress = state.get(PROGRESS).map_err(OutputError::at(&path))?;
    world.resource_mut::<RunDirectory>().checkpoint(progress.increment, state)
}
