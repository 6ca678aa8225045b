//! A run with its output, as `clastic run` makes it.

use std::path::Path;

use clastic::output::{self, OutputFailure, OutputPlugin, RunDirectory, RunOptions};
use clastic::run::{Outcome, Simulation};
use clastic::scene::LoadedScene;

use crate::BenchError;

/// Runs a scene to its end and writes its run directory to `directory`.
///
/// # Errors
/// Where a file cannot be written, an increment cannot be solved or a stage cannot begin.
pub fn written_run(loaded: &LoadedScene, directory: &Path) -> Result<Simulation, BenchError> {
    let specimen = loaded.specimen.as_ref();
    let mut simulation =
        Simulation::in_app(clastic::run::app(OutputPlugin), &loaded.scene, specimen);
    let options = RunOptions { directory: directory.to_owned(), force: true, ..Default::default() };
    output::begin(simulation.world_mut(), options, loaded)?;
    let outcome = simulation.run();
    if let Some(OutputFailure(error)) = simulation.world_mut().remove_resource() {
        return Err(error.into());
    }
    if let Outcome::Undecided { message, .. } | Outcome::Refused { message, .. } = outcome {
        return Err(BenchError::Run(message));
    }
    output::finish(simulation.world_mut(), Some(&outcome))?;
    simulation.world_mut().remove_resource::<RunDirectory>();
    Ok(simulation)
}
