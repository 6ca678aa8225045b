//! `clastic resume`: takes a run on from its checkpoint.

use std::path::Path;

use clastic::output::directory;
use clastic::output::run_record::CLASTIC_VERSION;
use clastic::output::{Checkpoint, ResumeError, RunWriter};
use clastic::run::{Simulation, changes};
use clastic::scene::from_str_with;

use super::ResumeArgs;
use super::exit::{Exit, Failure, complain, say};
use super::run::to_the_end;

/// Resumes a run.
pub fn resume(args: &ResumeArgs) -> Result<Exit, Failure> {
    let directory = args.directory.as_path();
    let checkpoint = match Checkpoint::read(directory) {
        Err(ResumeError::NoCheckpoint(_)) if ended(directory)? => {
            say(format_args!(
                "{}: this run is at its end; there is nothing to resume",
                directory.display()
            ))?;
            return Ok(Exit::Ok);
        }
        read => read?,
    };
    let name = Path::new(&checkpoint.facts.scene_file);
    let state = &checkpoint.world;
    let read = |sets: &[String], particles| from_str_with(&checkpoint.scene, name, particles, sets);
    let before = read(&[], state.specimen())?.scene;
    let loaded = read(&args.sets, state.specimen())?;
    let refused = changes::refused(&before, &loaded.scene, state);
    if !refused.is_empty() {
        return Err(Failure { exit: Exit::Usage, message: refused.join("\n") });
    }

    let increment = state.progress.increment;
    if checkpoint.clastic_version != CLASTIC_VERSION {
        complain(format_args!(
            "the checkpoint was written by clastic {}, this is {CLASTIC_VERSION}: the results from increment {} on \
             need not be those of one version",
            checkpoint.clastic_version,
            increment + 1
        ));
    }
    let mut simulation = Simulation::resume(&loaded.scene, state);
    changes::apply(simulation.world_mut(), &before, &loaded.scene, state);
    let every = args.output.checkpoint_every;
    let writer = RunWriter::resume(directory, checkpoint, &loaded, &args.sets, every)?;
    if !args.output.quiet {
        complain(format_args!("resumed after increment {increment}"));
    }
    to_the_end(simulation, writer, directory, args.output.quiet)
}

/// Whether the run of a directory came to its end.
fn ended(directory: &Path) -> Result<bool, Failure> {
    let record = directory::record(directory)?;
    Ok(["completed", "collapsed"].map(Some).contains(&record["outcome"]["status"].as_str()))
}
