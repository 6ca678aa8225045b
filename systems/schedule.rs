//! The `Increment` schedule and its sets. The order of all systems must be stated.
//!
//! One run of [`Increment`] commits one increment (or the fraction of one that could be solved).
//! Its sets run [`ControlWalls`], and [`AttemptIncrement`] until an attempt is accepted, with
//! [`AddTrialLoads`] whenever a trial begins.
//!
//! Attempts read and write tables that are gathered once per increment. Bodies, walls, bonds and
//! the contact history change only when an attempt is committed. A failed attempt changes nothing.

use std::time::Instant;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};

use clastic_components::prelude::*;

use crate::state::RegisterState;

/// One increment.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Increment;

/// One attempt at an increment, run by [`IncrementSystems::Attempts`].
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AttemptIncrement;

/// Computes the drives of walls and the loads of particles in the next increment. Run by
/// [`IncrementSystems::Controls`].
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ControlWalls;

/// Collects loads of an embedding program. It runs once per trial: for every tried fraction of an
/// increment and after every step of a followed motion. Its systems add to
/// [`TrialLoads`]. They may read the initial state of the
/// trial from [`BodyTable`], while entities keep the last
/// committed state. The trial ends at `done + fraction` of
/// [`ClasticProgress`].
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AddTrialLoads;

/// The parts of an increment that do not run if the world is halted before them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct AfterGather;

/// Sets of [`Increment`], in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IncrementSystems {
    /// Computes drives of walls and loads of particles for the next increment.
    Controls,
    /// Gathers bodies, bonds, controls and contact memory into tables in the order of identities,
    /// and checks their values. The sets after it do not run if the world is [`ClasticHalted`] by
    /// then.
    Gather,
    /// Updates the rows of persistent tables. Runs only if rows have changed.
    Renumber,
    /// Makes the draft of the contact memory, on which attempts work.
    Draft,
    /// Detects, assembles and solves until an attempt is accepted.
    Attempts,
    /// Commits the accepted attempt to the bodies.
    Update,
    /// Breaks bonds.
    Rupture,
    /// Measures the result of the increment.
    Record,
}

/// Sets of [`AttemptIncrement`], in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AttemptSystems {
    /// Finds potential contacts.
    Detect,
    /// Fills the interactions of [`ConeProgram`](clastic_cone::program::ConeProgram).
    Assemble,
    /// Systems of an embedding program that change these interactions, or append others.
    AssembleExtra,
    /// Fills the rows of the bodies. Every degree of freedom on which an interaction acts is free,
    /// unless a drive imposes its motion.
    Balance,
    /// Solves the program.
    Solve,
    /// Accepts the attempt, tries again, or rejects it.
    Judge,
}

/// Sets of [`ControlWalls`], in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ControlSystems {
    /// Built-in controls, which scenes can name.
    BuiltIn,
    /// Boundary conditions of an embedding program. Its systems write
    /// [`WallDrive`] or
    /// [`BodyDrives`].
    Custom,
}

/// Start of the part of an increment that is being timed.
#[derive(Resource)]
pub struct Lap(Instant);

/// A system that adds the time since the last lap to one part of [`Timings`].
pub(crate) fn lap(part: fn(&mut Timings) -> &mut f64) -> impl Fn(ResMut<Lap>, ResMut<Timings>) {
    move |mut lap, mut timings| {
        *part(&mut timings) += lap.0.elapsed().as_secs_f64();
        lap.0 = Instant::now();
    }
}

/// Starts the clock of an increment.
pub fn start_clock(mut lap: ResMut<Lap>, mut timings: ResMut<Timings>) {
    *timings = Timings::default();
    lap.0 = Instant::now();
}

/// Name of [`ClasticProgress`] in a state.
pub const PROGRESS: &str = "progress";

/// Run condition: rows have changed because bodies were added or removed.
pub(crate) fn rows_changed(rows: Res<KeptRows>) -> bool {
    rows.is_needed()
}

/// Run condition: the attempts ended in a state that is committed.
pub fn committed(attempt: Res<Attempt>) -> bool {
    attempt.status.is_committed()
}

/// Why the run has stopped, in words. No increment is made while the world has this resource.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct ClasticHalted(pub String);

/// Adds the four schedules with their sets.
pub struct SchedulePlugin;

impl Plugin for SchedulePlugin {
    fn build(&self, app: &mut App) {
        app.register_resource::<ClasticProgress>(PROGRESS)
            .register_resource::<ClasticAnalysis>("analysis");
        app.init_resource::<ClasticProgress>()
            .init_resource::<Timings>()
            .insert_resource(Lap(Instant::now()));
        edit_chain(app, Increment, |schedule| {
            // The condition of a set is evaluated once, before its first system: what begins after
            // `Gather` is finished, even if a later system halts the world.
            schedule.configure_sets(AfterGather.run_if(not(resource_exists::<ClasticHalted>)));
            let after_gather = (
                IncrementSystems::Renumber.run_if(rows_changed),
                IncrementSystems::Draft,
                IncrementSystems::Attempts,
                IncrementSystems::Update.run_if(committed),
                IncrementSystems::Rupture.run_if(committed),
                IncrementSystems::Record,
            );
            let begin = (IncrementSystems::Controls, IncrementSystems::Gather).chain();
            schedule.configure_sets((begin, after_gather.chain().in_set(AfterGather)).chain());
        });
        edit_chain(app, AttemptIncrement, |schedule| {
            schedule.configure_sets(
                (
                    AttemptSystems::Detect,
                    AttemptSystems::Assemble,
                    AttemptSystems::AssembleExtra,
                    AttemptSystems::Balance,
                    AttemptSystems::Solve,
                    AttemptSystems::Judge,
                )
                    .chain(),
            );
        });
        edit_chain(app, ControlWalls, |schedule| {
            schedule.configure_sets((ControlSystems::BuiltIn, ControlSystems::Custom).chain());
        });
        edit_chain(app, AddTrialLoads, |_| {});
        // Systems that only add to the loads may run in any order: their sums do not depend on it.
        app.init_resource::<TrialLoads>().allow_ambiguous_resource::<TrialLoads>();
    }
}

/// Edits a schedule whose parts form a chain: threads would only wait for each other. It is edited and
/// not added, because a plugin that was added before may have systems in it.
pub(crate) fn edit_chain(
    app: &mut App,
    label: impl ScheduleLabel,
    configure: impl Fn(&mut Schedule),
) {
    app.edit_schedule(label, |schedule| {
        schedule.set_build_settings(ScheduleBuildSettings {
            // An unstated order could change with other plugins, so it is an error.
            ambiguity_detection: LogLevel::Error,
            hierarchy_detection: LogLevel::Error,
            ..Default::default()
        });
        schedule.set_executor(SingleThreadedExecutor::new());
        configure(schedule);
    });
}
