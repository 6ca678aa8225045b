//! `clastic resume`: continues a run from its checkpoint.

use std::path::Path;

use clastic::output::directory;
use clastic::output::run_record::CLASTIC_VERSION;
use clastic::output::{self, Checkpoint, OutputPlugin, ResumeError};
use clastic::run::state::{StateError, StateView};
use clastic::run::{Simulation, changes};
use clastic::scene::from_str_with;

use super::ResumeArgs;
use super::exit::{Exit, Failure, complain, say};
use super::own_findings::own_findings;
use super::run::to_the_end;

/// Resumes a run.
pub fn resume(args: &ResumeArgs) -> Result<Exit, Failure> {
    let directory = args.directory.as_path();
    let checkpoint = match Checkpoint::read(directory) {
        Err(ResumeError::NoCheckpoint(_)) if ended(directory)? => {
            if !args.sets.is_empty() {
                return Err(too_late(directory, &args.sets));
            }
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
    let view = StateView::of(state).map_err(damaged)?;
    let read = |sets: &[String], particles| from_str_with(&checkpoint.scene, name, particles, sets);
    let before = read(&[], view.specimen.clone())?.scene;
    let loaded = read(&args.sets, view.specimen.clone())?;
    // The run began without such walls, so a setting has added them. Its path is in the message.
    let foreign = own_findings(&loaded.scene);
    if let Some(finding) = foreign.first() {
        return Err(Failure { exit: Exit::Scene, message: finding.to_string() });
    }
    let refused = changes::refused(&before, &loaded.scene, &view);
    if !refused.is_empty() {
        return Err(Failure { exit: Exit::Usage, message: refused.join("\n") });
    }

    let increment = checkpoint.increment;
    if checkpoint.clastic_version != CLASTIC_VERSION {
        complain(format_args!(
            "the checkpoint was written by clastic {}, this is {CLASTIC_VERSION}: the results from increment {} on \
             need not be those of one version",
            checkpoint.clastic_version,
            increment + 1
        ));
    }
    let mut simulation =
        Simulation::resume_with(&loaded.scene, state, OutputPlugin).map_err(damaged)?;
    changes::apply(simulation.world_mut(), &before, &loaded.scene, &view);
    let every = args.output.checkpoint_every;
    let world = simulation.world_mut();
    output::resume(world, directory, checkpoint, &loaded, &args.sets, every)?;
    if !args.output.quiet {
        complain(format_args!("resumed after increment {increment}"));
    }
    to_the_end(simulation, directory, args.output.quiet)
}

/// Failure for a state that this program cannot restore.
fn damaged(error: StateError) -> Failure {
    Failure { exit: Exit::Usage, message: format!("the checkpoint cannot be resumed: {error}") }
}

/// Failure for settings of a run that has ended. Its checkpoint is gone, and the result files do
/// not contain the state (forces, velocities, broken bonds) from which an increment starts.
fn too_late(directory: &Path, sets: &[String]) -> Failure {
    let sets: Vec<_> = sets.iter().map(|set| format!("--set {set:?}")).collect();
    let message = format!(
        "{}: this run is at its end, and the checkpoint of a run goes away there: {} cannot take it further. \
         Run the scene again with all its settings and the new ones, as in `clastic run SCENE {} --out \
         NEW_DIRECTORY`, or with --force to write over these results",
        directory.display(),
        if sets.len() == 1 { "a setting" } else { "settings" },
        sets.join(" "),
    );
    Failure { exit: Exit::Usage, message }
}

/// Whether the run in a directory has ended.
fn ended(directory: &Path) -> Result<bool, Failure> {
    let record = directory::record(directory)?;
    Ok(["completed", "collapsed"].map(Some).contains(&record["outcome"]["status"].as_str()))
}
