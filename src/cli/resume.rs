//! `clastic resume`: continues a run from its checkpoint, or extends one that has ended.

use std::fs;
use std::path::Path;

use bevy_app::App;

use crate::output::directory;
use crate::output::run_record::CLASTIC_VERSION;
use crate::output::{self, Checkpoint, OutputError, OutputPlugin};
use crate::run::state::{StateError, StateView};
use crate::run::{Simulation, changes};
use crate::scene::{LoadError, from_str_with};

use super::ResumeArgs;
use super::exit::{Exit, Failure, complain, say};
use super::own_findings::own_findings;
use super::run::to_the_end;

pub fn resume(args: &ResumeArgs, mut app: App) -> Result<Exit, Failure> {
    let directory = args.directory.as_path();
    let is_changed = !args.sets.is_empty() || args.scene.is_some();
    let checkpoint = match Checkpoint::read(directory) {
        Err(OutputError::NoCheckpoint(_)) if ended(directory)? => {
            if !is_changed {
                say(format_args!(
                    "{}: this run is at its end; there is nothing to resume. More stages or \
                     increments extend it: `clastic resume {0} --set stages.NAME.increments=N`, or \
                     `--scene FILE` with more stages",
                    directory.display()
                ))?;
                return Ok(Exit::Ok);
            }
            match Checkpoint::read_as(directory, directory::FINAL_CHECKPOINT) {
                Err(OutputError::NoCheckpoint(_)) => return Err(too_late(directory, &args.sets)),
                read => read?,
            }
        }
        read => read?,
    };
    let name = Path::new(&checkpoint.facts.scene_file);
    let particles = StateView::of(&checkpoint.world).map_err(damaged)?.specimen;
    let read = |text: &str, sets: &[String]| from_str_with(text, name, particles.clone(), sets);
    let before = read(&checkpoint.scene, &[])?.scene;
    let text = match &args.scene {
        None => checkpoint.scene.clone(),
        Some(file) => fs::read_to_string(file)
            .map_err(|source| LoadError::Read { path: file.clone(), source })?,
    };
    let loaded = read(&text, &args.sets)?;
    // The run began without such walls, so a setting has added them. Its path is in the message.
    let foreign = own_findings(&loaded.scene, &app);
    if let Some(finding) = foreign.first() {
        return Err(Failure::new(Exit::Scene, finding));
    }
    let view = StateView::of(&checkpoint.world).map_err(damaged)?;
    let refused = changes::refused(&before, &loaded.scene, &view);
    if !refused.is_empty() {
        return Err(Failure::new(Exit::Usage, refused.join("\n")));
    }

    let increment = checkpoint.increment;
    if checkpoint.clastic_version != CLASTIC_VERSION {
        complain(format_args!(
            "the checkpoint was written by clastic {}, this is {CLASTIC_VERSION}: the results from \
             increment {} on may differ from those of a run with one version",
            checkpoint.clastic_version,
            increment + 1
        ));
    }
    app.add_plugins(OutputPlugin);
    let mut simulation =
        Simulation::resume_in(app, &loaded.scene, &checkpoint.world).map_err(damaged)?;
    changes::apply(simulation.world_mut(), &before, &loaded.scene, &view);
    let every = args.output.checkpoint_every;
    let scene = args.scene.iter().map(|file| format!("--scene {}", file.display()));
    let settings: Vec<_> = scene.chain(args.sets.iter().cloned()).collect();
    let world = simulation.world_mut();
    output::resume(world, directory, checkpoint, &loaded, &settings, every)?;
    if !args.output.quiet {
        complain(format_args!("resumed after increment {increment}"));
    }
    to_the_end(simulation, args.output.quiet)
}

/// Failure for a state that this program cannot restore.
fn damaged(error: StateError) -> Failure {
    Failure::new(Exit::Usage, format_args!("the checkpoint cannot be resumed: {error}"))
}

/// Failure for settings of a run that has ended and has no checkpoint of its end. The result files
/// do not contain all of the state from which an increment starts.
fn too_late(directory: &Path, sets: &[String]) -> Failure {
    let sets: Vec<_> = sets.iter().map(|set| format!("--set {set:?}")).collect();
    let message = format!(
        "{}: this run is at its end, and {} is not there, without which it cannot be taken \
         further. Run the scene again with all its settings and the new ones, as in `clastic run \
         SCENE {} --out NEW_DIRECTORY`, or with --force to write over these results",
        directory.display(),
        directory::FINAL_CHECKPOINT,
        sets.join(" "),
    );
    Failure::new(Exit::Usage, message)
}

fn ended(directory: &Path) -> Result<bool, Failure> {
    let record = directory::record(directory)?;
    Ok(["completed", "collapsed"].map(Some).contains(&record["outcome"]["status"].as_str()))
}
