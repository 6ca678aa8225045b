//! `clastic run`: runs a scene to its end, or until somebody stops it.

use clastic::components::increment::Progress as Place;
use clastic::components::observation::Observation;
use clastic::output::directory::default_directory;
use clastic::output::{Ending, RunOptions, RunWriter};
use clastic::run::stages::Script;
use clastic::run::{Outcome, Simulation, Step};
use clastic::scene::load;

use super::RunArgs;
use super::exit::{Exit, Failure, complain, say};
use super::interrupt::Interrupt;
use super::memory::fits;
use super::progress::Progress;
use super::resolve::resolve;
use super::summary::summary;

/// Runs a scene.
pub fn run(args: &RunArgs) -> Result<Exit, Failure> {
    let path = resolve(&args.scene.scene)?;
    let loaded = load(&path, &args.scene.sets)?;
    fits(&loaded)?;
    let directory = args.out.clone().unwrap_or_else(|| default_directory(&path));
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let options = RunOptions {
        directory: directory.clone(),
        force: args.force,
        overrides: args.scene.sets.clone(),
        dump_programs: args.dump_programs.clone(),
    };
    let mut writer = RunWriter::create(options, &loaded, simulation.world_mut())?;

    let interrupt = Interrupt::listen();
    let mut progress = Progress::new(args.quiet, loaded.scene.stages.len());
    let ending = loop {
        if let Step::Finished(outcome) = simulation.step() {
            break Ending::Finished(outcome);
        }
        writer.record(simulation.world_mut())?;
        let world = simulation.world();
        progress.show(world.resource::<Place>(), world.resource::<Observation>());
        if interrupt.requested() {
            break Ending::Interrupted;
        }
    };
    progress.end();

    let results = writer.finish(simulation.world_mut(), &ending)?;
    let increments = simulation.world().resource::<Observation>().increment;
    for missed in args.dump_programs.iter().filter(|n| **n > increments) {
        complain(format_args!(
            "--dump-program {missed}: the run ended with increment {increments}"
        ));
    }
    let stages = &simulation.world().resource::<Script>().ends;
    say(summary(&ending, increments, stages, &results, &directory));
    match ending {
        Ending::Interrupted => Ok(Exit::Interrupted),
        Ending::Finished(Outcome::Stalled { message, .. }) => {
            Err(Failure { exit: Exit::Solver, message })
        }
        Ending::Finished(Outcome::Completed | Outcome::Collapsed { .. }) => Ok(Exit::Ok),
    }
}
