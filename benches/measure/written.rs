//! A run with its output, as `clastic run` makes it.

use std::path::Path;

use clastic::output::{Ending, RunOptions, RunWriter};
use clastic::run::{Outcome, Simulation, Step};
use clastic::scene::LoadedScene;

use crate::BenchError;

/// Runs a scene to its end and writes what a run leaves into `directory`.
///
/// # Errors
/// Where a file cannot be written, an increment cannot be solved or a stage cannot begin.
pub fn written_run(loaded: &LoadedScene, directory: &Path) -> Result<Simulation, BenchError> {
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let options = RunOptions { directory: directory.to_owned(), force: true, ..Default::default() };
    let mut writer = RunWriter::create(options, loaded, simulation.world_mut())?;
    let outcome = loop {
        if let Step::Finished(outcome) = simulation.step() {
            break outcome;
        }
        writer.record(simulation.world_mut())?;
    };
    if let Outcome::Undecided { message, .. } | Outcome::Refused { message, .. } = outcome {
        return Err(BenchError::Run(message));
    }
    writer.finish(simulation.world_mut(), &Ending::Finished(outcome))?;
    Ok(simulation)
}
