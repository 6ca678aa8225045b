//! Systems: checkpoints.

use std::io;
use std::time::Instant;

use bevy_ecs::prelude::*;

use clastic_components::increment::Progress;
use clastic_components::observation::Observation;
use clastic_systems::schedule::PROGRESS;

use super::run_directory::RunDirectory;
use super::{OutputError, frames, names};
use crate::run::state::{StateError, WorldState, capture};

/// Run condition: a checkpoint is due.
pub fn is_checkpoint_due(observation: Res<Observation>, run: Res<RunDirectory>) -> bool {
    let every = u64::from(run.options.checkpoint_every);
    every > 0 && observation.increment.is_multiple_of(every)
}

/// Writes a checkpoint. Exclusive, because it reads everything that plugins have registered.
pub fn save(world: &mut World) -> Result<(), OutputError> {
    let clock = Instant::now();
    // The checkpoint does not have it.
    frames::write_peak(world)?;
    let (increment, state) = state(world, names::CHECKPOINT)?;
    let mut run = world.resource_mut::<RunDirectory>();
    run.save(increment, state)?;
    run.saving += clock.elapsed().as_secs_f64();
    Ok(())
}

/// Writes the checkpoint of a run that has ended, from which more stages or increments continue.
pub fn save_the_end(world: &mut World) -> Result<(), OutputError> {
    let (increment, state) = state(world, names::FINAL_CHECKPOINT)?;
    let mut run = world.resource_mut::<RunDirectory>();
    let checkpoint = run.checkpoint(increment, state)?.of_the_end();
    checkpoint.write_as(run.directory(), names::FINAL_CHECKPOINT)
}

/// The state for the file `name`, and its increment: an undecided one was not committed.
fn state(world: &mut World, name: &str) -> Result<(u64, WorldState), OutputError> {
    let path = world.resource::<RunDirectory>().path(name);
    let invalid = |error: StateError| OutputError::at(&path)(io::Error::other(error));
    let state = capture(world).map_err(invalid)?;
    let increment = state.get::<Progress>(PROGRESS).map_err(invalid)?.increment;
    Ok((increment, state))
}
