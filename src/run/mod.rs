//! Running a scene: from its text to a world, and from stage to stage.
//!
//! All state lives in the world; [`Simulation`] only holds the app. An embedding program can do
//! the same with its own app: [`spawn::spawn_scene`] fills a world, [`stages::advance`] takes it
//! one increment on.

mod advice;
pub mod cement;
pub mod changes;
pub mod compact;
pub mod load;
pub mod particles;
pub mod spawn;
pub mod stages;
pub mod state;

use bevy_app::App;
use bevy_ecs::prelude::*;

pub use stages::{Collapse, CollapsedBy, EndedBy, Outcome, StageEnd, Step};
pub use state::WorldState;

use crate::ClasticPlugins;
use crate::scene::format::Scene;
use crate::scene::specimen_file::StoredSpecimen;

/// A scene that runs.
pub struct Simulation {
    app: App,
}

impl Simulation {
    /// A world with the scene's particles, walls and explicit bonds, before its first stage.
    /// `stored` is the content of the specimen file, where the scene names one.
    #[must_use]
    pub fn new(scene: &Scene, stored: Option<&StoredSpecimen>) -> Self {
        let mut app = App::new();
        app.add_plugins(ClasticPlugins);
        spawn::spawn_scene(app.world_mut(), scene, stored);
        Self { app }
    }

    /// A world that goes on from a state under the settings of `scene`: with those of the scene
    /// that the state comes from it goes on as if nothing had happened, to the last bit.
    #[must_use]
    pub fn resume(scene: &Scene, state: &WorldState) -> Self {
        let mut app = App::new();
        app.add_plugins(ClasticPlugins);
        state.restore(app.world_mut(), scene);
        Self { app }
    }

    /// Runs the next increment, and what lies before it: ends and beginnings of stages, stages
    /// without increments.
    pub fn step(&mut self) -> Step {
        stages::advance(self.app.world_mut())
    }

    /// Runs to the end.
    pub fn run(&mut self) -> Outcome {
        loop {
            if let Step::Finished(outcome) = self.step() {
                return outcome;
            }
        }
    }

    /// The world.
    #[must_use]
    pub fn world(&self) -> &World {
        self.app.world()
    }

    /// The world, to change it.
    pub fn world_mut(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// The app, to add plugins and systems to it.
    pub fn app_mut(&mut self) -> &mut App {
        &mut self.app
    }
}
