//! A scene under way: its world, the columns of its history, and its output if it has any.

use std::path::PathBuf;

use bevy_ecs::prelude::*;
use clastic::cli::memory::fits;
use clastic::cli::own_findings::own_findings;
use clastic::cli::resolve::resolve;
use clastic::components::body::BodyId;
use clastic::components::contact::BodyTable;
use clastic::output::history;
use clastic::output::{self, OutputFailure, OutputPlugin, RunOptions};
use clastic::prelude::{ClasticHalted, Step};
use clastic::run::stages::Script;
use clastic::run::state::StateView;
use clastic::run::{self, Outcome, changes, sanity};
use clastic::scene::format::Stage;
use clastic::scene::{LoadedScene, from_str, from_str_with, load_with};
use clastic::systems::gather_bodies::gather_bodies;
use clastic::systems::stepping::EndOfRun;
use clastic::text::spans::span_of;

use crate::errors::Error;
use crate::loads::{self, FailedFunction};

/// What to run.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// The text of a scene, or the path or name of one.
    pub scene: String,
    /// Whether `scene` is a text.
    pub is_text: bool,
    /// Settings, `PATH=VALUE`.
    pub sets: Vec<String>,
    /// Directory of the results; without one nothing is written.
    pub out: Option<PathBuf>,
    /// Whether an earlier run in it may be overwritten.
    pub force: bool,
    /// Number of increments between checkpoints; 0: none.
    pub checkpoint_every: u32,
}

/// Reads and checks a scene as the program does.
pub fn read(wanted: &Wanted) -> Result<LoadedScene, Error> {
    let loaded = if wanted.is_text {
        from_str(&wanted.scene, "scene".as_ref(), "".as_ref(), &wanted.sets)?
    } else {
        let app = run::app(());
        let path = resolve(wanted.scene.as_ref())?;
        load_with(&path, &wanted.sets, true, |scene| own_findings(scene, &app))?
    };
    fits(&loaded)?;
    Ok(loaded)
}

/// Warnings of a scene before it runs.
pub fn warnings(loaded: &LoadedScene) -> Vec<String> {
    sanity::before(&loaded.scene, loaded.specimen.as_ref()).warnings
}

/// A scene under way.
pub struct Model {
    /// The world.
    pub simulation: run::Simulation,
    /// The scene that runs.
    pub loaded: LoadedScene,
    /// Columns of a row.
    pub columns: Vec<String>,
    probes: Vec<String>,
    /// How the run ended, once it has.
    pub outcome: Option<Outcome>,
    has_output: bool,
}

impl Model {
    /// The world of a scene before its first increment.
    pub fn begin(wanted: &Wanted) -> Result<Self, Error> {
        let loaded = read(wanted)?;
        let mut app = run::app(());
        loads::add(&mut app);
        if wanted.out.is_some() {
            app.add_plugins(OutputPlugin);
        }
        let specimen = loaded.specimen.as_ref();
        let mut simulation = run::Simulation::in_app(app, &loaded.scene, specimen);
        if let Some(directory) = &wanted.out {
            let options = RunOptions {
                directory: directory.clone(),
                force: wanted.force,
                overrides: wanted.sets.clone(),
                checkpoint_every: wanted.checkpoint_every,
                ..RunOptions::default()
            };
            output::begin(simulation.world_mut(), options, &loaded)?;
        }
        let mut model = Self::of(simulation, loaded);
        model.has_output = wanted.out.is_some();
        Ok(model)
    }

    /// A simulation of a scene.
    pub fn of(simulation: run::Simulation, loaded: LoadedScene) -> Self {
        let (columns, probes) = (history::columns(&loaded.scene), history::probes(&loaded.scene));
        Self { simulation, loaded, columns, probes, outcome: None, has_output: false }
    }

    /// The world.
    pub fn world(&mut self) -> &mut World {
        self.simulation.world_mut()
    }

    /// Makes an increment. Returns its row, or nothing once the run has ended.
    pub fn step(&mut self) -> Result<Option<String>, Error> {
        let step = self.simulation.step();
        let world = self.simulation.world_mut();
        if let Some(OutputFailure(error)) = world.remove_resource::<OutputFailure>() {
            return Err(error.into());
        }
        if let Some(FailedFunction(error)) = world.remove_resource::<FailedFunction>() {
            // Nothing of the increment was committed, and another function may do better.
            world.remove_resource::<ClasticHalted>();
            return Err(Error::Python(error));
        }
        match step {
            Step::Increment => Ok(Some(self.row())),
            Step::Finished(Outcome::Halted(message)) => {
                // After the value is mended, the run goes on.
                world.remove_resource::<ClasticHalted>();
                Err(Error::halted(&message))
            }
            Step::Finished(outcome) => {
                self.outcome = Some(outcome);
                Ok(None)
            }
        }
    }

    /// The row of the last increment.
    pub fn row(&self) -> String {
        history::last_row(self.simulation.world(), &self.probes).line()
    }

    /// Ends the output. Returns warnings of the run.
    pub fn finish(&mut self) -> Result<Vec<String>, Error> {
        let outcome = self.outcome.clone();
        output::finish(self.world(), outcome.as_ref())?;
        // The tables are open, and locked, until then.
        self.world().remove_resource::<output::RunDirectory>();
        Ok(sanity::after(self.simulation.world()).warnings)
    }

    /// Adds a stage after those of the scene, in the words of a scene.
    pub fn add_stage(&mut self, stage: &str) -> Result<(), Error> {
        if self.has_output {
            let what = "a run that writes into a directory has the stages of its scene alone";
            return Err(Error::Value(what.to_owned()));
        }
        let absent = |k: &u32| span_of(&self.loaded.text, &format!("stages[{k}]")).is_none();
        let place = (0..).find(absent);
        let mut sets = vec![format!("stages[{}]={stage}", place.unwrap_or_default())];
        let scene = &self.loaded.scene;
        let reference = scene.stages.get(scene.reference_stage()).map(Stage::name);
        // By default strains count from the last stage, which is another one from here on.
        if let (None, Some(name)) = (&scene.reference_stage, reference) {
            sets.push(format!("reference_stage={name:?}"));
        }
        let state = self.simulation.state()?;
        let view = StateView::of(&state)?;
        let text = self.loaded.text.clone();
        let (name, stored) = (self.loaded.path.clone(), view.specimen.clone());
        let loaded = from_str_with(&text, &name, stored, &sets)?;
        let refused = changes::refused(&self.loaded.scene, &loaded.scene, &view);
        if !refused.is_empty() {
            return Err(Error::Value(refused.join("\n")));
        }
        self.columns = history::columns(&loaded.scene);
        self.probes = history::probes(&loaded.scene);
        let world = self.simulation.world_mut();
        let mut script = world.resource_mut::<Script>();
        script.scene = loaded.scene.clone();
        script.outcome = None;
        world.insert_resource(EndOfRun::default());
        self.outcome = None;
        self.loaded = loaded;
        Ok(())
    }

    /// The bodies by row, as they are now.
    pub fn bodies(&mut self) -> &BodyTable {
        let world = self.simulation.world_mut();
        // Gathering the tables does not change the run.
        let _ = world.run_system_cached(gather_bodies);
        world.resource()
    }

    /// Entities of particles by identity.
    pub fn particles(&mut self, ids: &[u32]) -> Result<Vec<Entity>, Error> {
        let bodies = self.bodies();
        let entity = |id: &u32| {
            let row = bodies.row(BodyId(*id)).filter(|row| *row < bodies.particles);
            row.map(|row| bodies.entities[row]).ok_or_else(|| {
                Error::Value(format!(
                    "no particle has the identity {id}; `ids` has those there are"
                ))
            })
        };
        ids.iter().map(entity).collect()
    }
}
