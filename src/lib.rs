//! clastic: granular contact dynamics with elastic bonds, for cemented sand and rock.
//!
//! Each load increment is one convex cone program: its solution is the contact and bond forces,
//! its multipliers are the displacements. Static analysis has no inertia and no damping; dynamic
//! analysis is the same program with inertia. Particles, walls and bonds are entities, and
//! scheduled systems do the work in a fixed order (see [`systems::schedule`]).
//!
//! - A researcher writes a [`scene`] in RON and runs it with the `clastic` program.
//! - A simulation programmer adds systems to the public sets of [`systems::schedule`]; `cli::main`
//!   (feature `cli`) is the command line with further plugins.
//! - A Bevy developer adds [`ClasticPlugins`] to an app, which then makes one increment in every
//!   `Update`.
//!
//! Two bonded disks, of which one is held and the other is pulled away by 1 um in every increment.
//! The bond force is its stiffness times its elongation:
//!
//! ```
//! use bevy_app::App;
//! use clastic::prelude::*;
//! use glam::DVec2;
//!
//! let mut app = App::new();
//! app.add_plugins(ClasticPlugins::default());
//! let law =
//!     BondLaw { normal_compliance: 1.0 / 8.0e6, tensile_strength: 1.0e4, ..Default::default() };
//! let world = app.world_mut();
//! let mut disk = |x, pull| {
//!     let place = BodyPosition(DVec2::new(x, 0.0));
//!     world.spawn((Particle::disk(6.0e-3, 2650.0, 1.0), place, BodyDrives::imposed(pull))).id()
//! };
//! let (held, pulled) = (disk(0.0, [0.0; 3]), disk(12.0e-3, [1.0e-6, 0.0, 0.0]));
//! world.spawn(Bond::between(held, pulled, law));
//! app.update();
//! let force = app.world().get::<BodyExternalForce>(pulled).unwrap().0[0];
//! assert!((force - 8.0).abs() < 1e-6);
//! ```

pub use clastic_components as components;
pub use clastic_cone as cone;
pub use clastic_reference as reference;
pub use clastic_systems as systems;

#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "export")]
pub mod export;
pub mod frames;
pub mod output;
pub mod run;
pub mod saved;
pub mod scene;
pub mod study;
pub mod tables;
pub mod text;

use bevy_app::{PluginGroup, PluginGroupBuilder, Update};
use bevy_ecs::schedule::{InternedScheduleLabel, ScheduleLabel};

/// All plugins that an increment needs. The `clastic` program uses the same group as an embedding
/// program.
///
/// The app makes one increment whenever `Update`, or the schedule given to [`new`](Self::new),
/// runs. [`ClasticRunning`](systems::stepping::ClasticRunning) pauses it.
///
/// `Update` is the default, and not `FixedPostUpdate` as for the physics of games. A static
/// increment has no duration; an increment may take longer than the time step, and a fixed schedule
/// would then ask for ever more of them; and without Bevy's `TimePlugin` a fixed schedule never
/// runs, so that nothing would move, without a message. For a simulation in real time use
/// `ClasticPlugins::new(FixedPostUpdate)`: an increment is then one time step, whose duration
/// `ClasticAnalysis` sets (`Time<Fixed>` follows it), and `Time<Virtual>` makes it faster or
/// slower.
pub struct ClasticPlugins {
    schedule: InternedScheduleLabel,
}

impl Default for ClasticPlugins {
    fn default() -> Self {
        Self::new(Update)
    }
}

impl ClasticPlugins {
    /// The app makes an increment whenever `schedule` runs.
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern() }
    }
}

impl PluginGroup for ClasticPlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(systems::schedule::SchedulePlugin)
            .add(systems::stepping::SteppingPlugin { schedule: self.schedule })
            .add(systems::assign_identities::AssignIdentitiesPlugin)
            .add(systems::gather_bodies::GatherBodiesPlugin)
            .add(systems::detect_contacts::DetectContactsPlugin)
            .add(systems::assemble_program::AssembleProgramPlugin)
            .add(systems::solve_program::SolveProgramPlugin)
            .add(systems::attempt::AttemptPlugin)
            .add(systems::update_state::UpdateStatePlugin)
            .add(systems::rupture::bonds::RuptureBondsPlugin)
            .add(systems::energy_ledger::EnergyLedgerPlugin)
            .add(systems::control_walls::ControlWallsPlugin)
            .add(systems::membranes::MembranesPlugin)
            .add(systems::links::LinksPlugin)
            .add(systems::record::RecordPlugin)
            .add(systems::announce::AnnouncePlugin)
            .add(systems::material_names::MaterialNamesPlugin)
    }
}

/// Types that most embedding programs need.
///
/// No name is one of Bevy's or of its usual physics engines. Three types whose names are can be
/// reached through their modules: `body::Group`, `body::Probe`, `material::Material`.
pub mod prelude {
    pub use crate::ClasticPlugins;
    pub use crate::components::attempt::{Attempt, IncrementStatus};
    pub use crate::components::body::{
        BodyAngularVelocity, BodyDrive, BodyDrives, BodyExternalForce, BodyId, BodyOrigin,
        BodyPosition, BodyRotation, BodyVelocity, LastMotion, LoadControl,
    };
    pub use crate::components::bond::{Bond, BondBroken, BondId, BondState, Rupture, RuptureMode};
    pub use crate::components::collision::{BodyHit, Collision};
    pub use crate::components::contact::{BodyTable, ContactTable};
    pub use crate::components::increment::{
        Acceptance, AnalysisKind, ClasticAnalysis, ClasticProgress, FrictionLaw, RuptureRules,
    };
    pub use crate::components::link::{Link, LinkKind};
    pub use crate::components::loads::TrialLoads;
    pub use crate::components::material::{BondLaw, ContactLaw};
    pub use crate::components::membrane::{Course, Membrane, MembraneShape, Sides};
    pub use crate::components::observation::Observation;
    pub use crate::components::particle::{MaterialIndex, Particle};
    pub use crate::components::wall::{
        LoadedLength, TableOf, Wall, WallControl, WallDrive, WallName, WallSlide, WallTable,
    };
    pub use crate::components::{body, material};
    pub use crate::cone::program::{ConeProgram, ConeSolution};
    pub use crate::run::{Outcome, ScenePlugin, Simulation, Step};
    pub use crate::systems::identities::IdentityTable;
    pub use crate::systems::load_stage::begin_stage;
    pub use crate::systems::schedule::{
        AddTrialLoads, AttemptIncrement, AttemptSystems, ControlSystems, ControlWalls, Increment,
        IncrementSystems,
    };
    pub use crate::systems::state::WorldState;
    pub use crate::systems::stepping::{
        AdvanceIncrement, AdvanceSystems, ClasticHalted, ClasticRunning, ClasticStepping,
        ClasticStopped, StoppedBy,
    };
}
