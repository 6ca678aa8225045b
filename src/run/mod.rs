//! Runs scenes: from the text to a world, and from stage to stage.
//!
//! The world contains all state; [`Simulation`] only holds the app. An embedding program uses its
//! own app: it adds [`ClasticPlugins`] and [`ScenePlugin`], and [`spawn::spawn_scene`] fills its
//! world.

mod advice;
pub(crate) mod cell;
pub mod cement;
pub mod changes;
pub(crate) mod compact;
mod cores;
pub(crate) mod disks;
pub mod key_results;
mod landing;
mod laws;
pub(crate) mod load;
mod load_refusals;
pub mod measures;
mod membranes;
pub mod minerals;
mod mixed;
mod particle_controls;
pub mod particles;
pub mod plugin;
pub(crate) mod pour;
mod pour_room;
mod provided;
mod random;
pub(crate) mod remove;
mod resolve_measures;
mod rigid;
pub mod sanity;
pub mod save;
mod scale;
pub(crate) mod scatter;
pub mod script;
pub(crate) mod select;
pub(crate) mod settings;
pub(crate) mod sieve;
pub mod spawn;
pub mod stages;
pub mod state;
mod stop;
mod touching;
mod until;
mod wall_controls;
pub(crate) mod wall_pieces;
pub(crate) mod walls;

use bevy_app::{App, Plugins};
use bevy_ecs::prelude::*;

use clastic_components::increment::ClasticProgress;
use clastic_systems::stepping::{self, ClasticHalted, IncrementDue};

pub use load::end_stage;
pub use plugin::ScenePlugin;
pub use script::{Collapse, CollapsedBy, EndedBy, Outcome, StageEnd, Step};
pub use state::{StateError, WorldState};

use crate::ClasticPlugins;
use crate::scene::format::Scene;
use crate::scene::specimen_file::StoredSpecimen;

/// A running scene.
///
/// A disk falls on a floor and comes to rest under its weight, m g = rho pi r^2 h g:
///
/// ```
/// use clastic::prelude::*;
/// use clastic::scene::from_str;
///
/// let text = r#"(
///     version: 1, title: "a disk falls", gravity: (0.0, -10.0),
///     analysis: Dynamic(dt: 1.0e-3),
///     materials: { "m": (density: 2000.0) },
///     specimen: Particles([(position: (0.0, 0.06), radius: 0.05)]),
///     walls: [(name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), probe: "floor")],
///     stages: [Load(name: "fall", increments: 200)],
/// )"#;
/// let loaded = from_str(text, "fall.ron".as_ref(), "".as_ref(), &[])?;
/// let mut simulation = Simulation::new(&loaded.scene, None);
/// assert_eq!(simulation.run(), Outcome::Completed);
/// let record = simulation.world().resource::<Observation>();
/// let weight = 2000.0 * std::f64::consts::PI * 0.05_f64.powi(2) * 10.0;
/// assert!((record.probes[0].force[1] - weight).abs() < 1e-6 * weight);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Simulation {
    app: App,
}

impl Simulation {
    /// A world with the particles, walls and explicit bonds of the scene, before its first stage.
    /// `stored` is the content of the specimen file, if the scene names one.
    pub fn new(scene: &Scene, stored: Option<&StoredSpecimen>) -> Self {
        Self::in_app(app(()), scene, stored)
    }

    /// Adds the scene to an app that has [`ClasticPlugins`], [`ScenePlugin`] and plugins of your
    /// own ([`app`]), which may provide stages and state.
    pub fn in_app(mut app: App, scene: &Scene, stored: Option<&StoredSpecimen>) -> Self {
        spawn::spawn_scene(app.world_mut(), scene, stored);
        Self { app }
    }

    /// A world that continues from a state under the settings of `scene`. With the scene of the
    /// state, all further results are equal to those of an uninterrupted run, bit by bit.
    ///
    /// # Errors
    /// If the state has an entry that no plugin registers, or that cannot be decoded.
    pub fn resume(scene: &Scene, state: &WorldState) -> Result<Self, StateError> {
        Self::resume_in(app(()), scene, state)
    }

    /// Restores a state in an app that has [`ClasticPlugins`], [`ScenePlugin`] and the plugins with
    /// which the state was made.
    ///
    /// # Errors
    /// If the state has an entry that no plugin registers, or that cannot be decoded.
    pub fn resume_in(mut app: App, scene: &Scene, state: &WorldState) -> Result<Self, StateError> {
        state::restore(app.world_mut(), scene, state)?;
        Ok(Self { app })
    }

    /// The state between two increments, from which [`resume`](Self::resume) goes on. After an
    /// undecided increment it is the state before that increment.
    ///
    /// # Errors
    /// If a part of it cannot be encoded.
    pub fn state(&mut self) -> Result<WorldState, StateError> {
        state::capture(self.world_mut())
    }

    /// Runs the next increment. Ends and beginnings of stages, and stages without increments, come
    /// before it.
    pub fn step(&mut self) -> Step {
        advance(self.app.world_mut())
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
    pub fn world(&self) -> &World {
        self.app.world()
    }

    /// The world, for changes.
    pub fn world_mut(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// The app, for plugins and systems.
    pub fn app_mut(&mut self) -> &mut App {
        &mut self.app
    }
}

/// Advances a world with a scene to the end of the next increment.
pub fn advance(world: &mut World) -> Step {
    stepping::advance(world);
    if let Some(ClasticHalted(message)) = world.get_resource::<ClasticHalted>() {
        let stage = &world.resource::<ClasticProgress>().stage_name;
        let place = if stage.is_empty() { String::new() } else { format!("in stage `{stage}`: ") };
        return Step::Finished(Outcome::Halted(format!("{place}{message}")));
    }
    match &world.resource::<script::Script>().outcome {
        Some(outcome) if !world.resource::<IncrementDue>().0 => Step::Finished(outcome.clone()),
        _ => Step::Increment,
    }
}

/// An app with [`ClasticPlugins`], [`ScenePlugin`] and further plugins, before any scene.
pub fn app<M>(plugins: impl Plugins<M>) -> App {
    let mut app = App::new();
    app.add_plugins((ClasticPlugins::default(), ScenePlugin)).add_plugins(plugins);
    app
}
