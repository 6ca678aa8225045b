//! `clastic run`: runs a scene to its end, or until it is interrupted.

use std::fs;

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::components::increment::ClasticProgress;
use crate::components::observation::Observation;
use crate::output::directory::{self, default_directory};
use crate::output::{self, OutputError, OutputFailure, OutputPlugin, RunDirectory, RunOptions};
use crate::run::sanity;
use crate::run::stages::Script;
use crate::run::{Outcome, Simulation, Step};
use crate::scene::format::Stage;
use crate::scene::load::placed;
use crate::scene::{Finding, load_with};
use crate::text::suggest;

use super::RunArgs;
use super::exit::{Exit, Failure, complain, say};
use super::interrupt::Interrupt;
use super::memory::fits;
use super::own_findings::own_findings;
use super::progress::Progress;
use super::resolve::resolve;
use super::summary::summary;

pub fn run(args: &RunArgs, mut app: App) -> Result<Exit, Failure> {
    let path = resolve(&args.scene.scene)?;
    let loaded = load_with(&path, &args.scene.sets, true, |scene| own_findings(scene, &app))?;
    fits(&loaded)?;
    let dumps = args.dump_programs.iter();
    let dump_in_stages: Vec<_> =
        dumps.clone().filter_map(|(stage, n)| Some((stage.clone()?, *n))).collect();
    let stages: Vec<_> = loaded.scene.stages.iter().map(Stage::name).collect();
    if let Some((stage, _)) = dump_in_stages.iter().find(|(name, _)| !stages.contains(&&**name)) {
        let help = suggest::help(stage, &stages, "stages");
        let message = format!("--dump-program {stage}:N: the scene has no such stage; {help}");
        return Err(Failure::new(Exit::Usage, message));
    }
    for warning in sanity::before(&loaded.scene, loaded.specimen.as_ref()).warnings {
        complain(format_args!("WARNING: {warning}"));
    }
    app.add_plugins(OutputPlugin);
    let mut simulation = Simulation::in_app(app, &loaded.scene, loaded.specimen.as_ref());
    let options = RunOptions {
        directory: args.out.clone().unwrap_or_else(|| default_directory(&path)),
        force: args.force,
        overrides: args.scene.sets.clone(),
        dump_programs: dumps.filter(|(stage, _)| stage.is_none()).map(|(_, n)| *n).collect(),
        dump_in_stages,
        checkpoint_every: args.output.checkpoint_every.unwrap_or(0),
    };
    output::begin(simulation.world_mut(), options, &loaded)?;
    to_the_end(simulation, args.output.quiet)
}

/// Runs a simulation with an open run directory to its end and writes the results.
pub fn to_the_end(mut simulation: Simulation, quiet: bool) -> Result<Exit, Failure> {
    let interrupt = Interrupt::listen();
    let mut progress =
        Progress::new(quiet, simulation.world().resource::<Script>().scene.stages.len());
    let outcome = loop {
        let step = simulation.step();
        let world = simulation.world_mut();
        if let Some(OutputFailure(error)) = world.remove_resource::<OutputFailure>() {
            return Err(stopped(error, world.resource()));
        }
        if let Step::Finished(outcome) = step {
            break Some(outcome);
        }
        progress.show(world.resource::<ClasticProgress>(), world.resource::<Observation>());
        if interrupt.requested() && world.resource::<Script>().outcome.is_none() {
            break None;
        }
    };
    progress.end();

    let world = simulation.world_mut();
    let finished = output::finish(world, outcome.as_ref());
    let (world, run) = (&*world, world.resource::<RunDirectory>());
    let results = finished.map_err(|error| stopped(error, run))?;
    let folder = run.directory();
    let increments = world.resource::<Observation>().increment;
    for missed in run.options.dump_programs.iter().filter(|n| **n > increments) {
        complain(format_args!(
            "--dump-program {missed}: the run ended with increment {increments}"
        ));
    }
    let script = world.resource::<Script>();
    for (stage, n) in &run.options.dump_in_stages {
        let made = script.ends.iter().find(|end| end.stage == *stage).map_or(0, |e| e.rows);
        if *n > made {
            complain(format_args!(
                "--dump-program {stage}:{n}: the stage ended with its increment {made}"
            ));
        }
    }
    let mut text = summary(outcome.as_ref(), increments, script, &run.record, folder);
    let packs = script.scene.stages.iter().all(|s| matches!(s, Stage::Compact(_)));
    if let Some(porosity) = results.porosity.filter(|_| packs) {
        text += &format!("\nporosity of the packing {porosity:.4}");
    }
    let said = say(text);
    // A closed terminal cannot print the summary. That is no failure of an interrupted run.
    if outcome.is_some() {
        said?;
    }
    match outcome {
        None => Ok(Exit::Interrupted),
        Some(Outcome::Undecided { message, .. }) => Err(Failure::new(Exit::Solver, message)),
        Some(Outcome::Halted(message)) => Err(in_stage(world, run, message, "")),
        Some(Outcome::Refused { message, .. }) => {
            let help = format!(
                "once the stage is mended, `clastic resume {} --set PATH=VALUE` goes on (another wall or material \
                 needs another run)",
                folder.display()
            );
            Err(in_stage(world, run, message, &help))
        }
        Some(Outcome::Completed | Outcome::Collapsed(_)) => Ok(Exit::Ok),
    }
}

/// A mistake of the stage that the run has come to, with its place in the scene as run.
fn in_stage(world: &World, run: &RunDirectory, message: String, help: &str) -> Failure {
    let path = format!("stages[{}]", world.resource::<ClasticProgress>().stage);
    let file = run.path(directory::SCENE);
    let text = fs::read_to_string(&file).unwrap_or_default();
    Failure::new(Exit::Scene, placed(&file, &text, Finding::new(path, message, help)))
}

/// Message for output that fails during a run.
fn stopped(error: OutputError, run: &RunDirectory) -> Failure {
    let mut failure = Failure::from(error);
    if let Some(increment) = run.saved {
        failure.message += &format!(
            "\nthe run stopped; once that is mended, `clastic resume {}` goes on after increment {increment}",
            run.directory().display()
        );
    }
    failure
}
