//! The `Increment` schedule, its sets, and the rule that their order is complete.
//!
//! One run of [`Increment`] commits one increment (or the fraction of one that could be solved):
//!
//! ```text
//! Increment:         Controls -> Gather -> Renumber -> Draft -> Attempts -> Update -> Rupture -> Record
//!   Controls runs    ControlWalls: BuiltIn -> Custom, for the increment that begins
//!   Attempts runs    AttemptIncrement, again and again until an attempt is accepted:
//!                    Detect -> Assemble -> AssembleExtra -> Solve -> Judge
//!                    and Loads whenever a trial begins
//! ```
//!
//! Attempts read and write tables that are gathered once per increment. Bodies, walls, bonds and the contact
//! history change only when an attempt is committed: one that fails leaves no trace.

use std::time::Instant;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{
    InternedScheduleLabel, LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor,
};

use clastic_components::attempt::{Attempt, IncrementStatus};
use clastic_components::contact::KeptRows;
use clastic_components::increment::{Analysis, Progress};
use clastic_components::observation::Timings;

use crate::state::RegisterState;

/// One increment.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Increment;

/// One attempt at an increment, run by [`IncrementSystems::Attempts`].
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AttemptIncrement;

/// Turns the control of walls and particles into what they do in the increment that begins; run by
/// [`IncrementSystems::Controls`].
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ControlWalls;

/// Asks for loads of an embedding program; run once per trial, that is for every part of an increment that is
/// tried and after every step of a motion that is followed. Its systems read
/// [`Bodies`](clastic_components::contact::Bodies), which is where the trial starts (entities keep the last
/// committed state), and [`Progress`](clastic_components::increment::Progress), whose `done + fraction` is
/// where it ends, and add to [`TrialLoads`](clastic_components::loads::TrialLoads).
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Loads;

/// Sets of [`Increment`], in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IncrementSystems {
    /// Drives walls and loads particles for the increment that begins.
    Controls,
    /// Bodies, bonds, controls and contact memory into tables in identity order.
    Gather,
    /// Tables that are kept by row follow bodies to other rows; only if rows have changed.
    Renumber,
    /// The draft of the contact memory, on which attempts work.
    Draft,
    /// Detection, assembly and solve, until an attempt is accepted.
    Attempts,
    /// Commits the accepted attempt to the bodies.
    Update,
    /// Breaks bonds.
    Rupture,
    /// Measures what happened.
    Record,
}

/// Sets of [`AttemptIncrement`], in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AttemptSystems {
    /// Potential contacts.
    Detect,
    /// The cone program.
    Assemble,
    /// Rows of an embedding program: write [`ConeProgram`](clastic_cone::program::ConeProgram).
    AssembleExtra,
    /// The solution.
    Solve,
    /// Accept, try again, or reject.
    Judge,
}

/// Sets of [`ControlWalls`], in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ControlSystems {
    /// The controls that scenes can name.
    BuiltIn,
    /// Boundary conditions of an embedding program: write
    /// [`WallDrive`](clastic_components::wall::WallDrive) or
    /// [`Drives`](clastic_components::body::Drives).
    Custom,
}

/// When the part of an increment under way began.
#[derive(Resource)]
pub struct Lap(Instant);

/// A system that books the time since the last lap to one part of [`Timings`].
pub fn lap(part: fn(&mut Timings) -> &mut f64) -> impl Fn(ResMut<Lap>, ResMut<Timings>) {
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

/// Name of [`Progress`] in a state.
pub const PROGRESS: &str = "progress";

/// Run condition: bodies have come or gone such that rows have changed.
pub fn rows_changed(rows: Res<KeptRows>) -> bool {
    rows.is_needed()
}

/// Run condition: the attempts ended in a state that is to be committed.
pub fn committed(attempt: Res<Attempt>) -> bool {
    matches!(attempt.status, IncrementStatus::Solved | IncrementStatus::Capped)
}

/// Run condition: bonds are to break. A cascade that ends in a collapse has broken those of its
/// earlier rounds, whatever else is not committed.
pub fn ruptured(attempt: Res<Attempt>) -> bool {
    attempt.status == IncrementStatus::Collapsed
        || matches!(attempt.status, IncrementStatus::Solved | IncrementStatus::Capped)
}

/// Adds the four schedules with their sets.
pub struct SchedulePlugin;

impl Plugin for SchedulePlugin {
    fn build(&self, app: &mut App) {
        app.register_resource::<Progress>(PROGRESS).register_resource::<Analysis>("analysis");
        app.init_resource::<Progress>()
            .init_resource::<Timings>()
            .insert_resource(Lap(Instant::now()));
        let settings = ScheduleBuildSettings {
            // An order that nobody stated is an order that may change: refuse it.
            ambiguity_detection: LogLevel::Error,
            hierarchy_detection: LogLevel::Error,
            ..Default::default()
        };
        // Edited and not added: a plugin that was added before this one may have systems in them.
        let mut edit = |label: InternedScheduleLabel, configure: fn(&mut Schedule)| {
            app.edit_schedule(label, |schedule| {
                schedule.set_build_settings(settings.clone());
                // The parts of an increment form a chain: threads would only wait.
                schedule.set_executor(SingleThreadedExecutor::new());
                configure(schedule);
            });
        };
        edit(Increment.intern(), |schedule| {
            schedule.configure_sets(
                (
                    IncrementSystems::Controls,
                    IncrementSystems::Gather,
                    IncrementSystems::Renumber.run_if(rows_changed),
                    IncrementSystems::Draft,
                    IncrementSystems::Attempts,
                    IncrementSystems::Update.run_if(committed),
                    IncrementSystems::Rupture.run_if(ruptured),
                    IncrementSystems::Record,
                )
                    .chain(),
            );
        });
        edit(AttemptIncrement.intern(), |schedule| {
            schedule.configure_sets(
                (
                    AttemptSystems::Detect,
                    AttemptSystems::Assemble,
                    AttemptSystems::AssembleExtra,
                    AttemptSystems::Solve,
                    AttemptSystems::Judge,
                )
                    .chain(),
            );
        });
        edit(ControlWalls.intern(), |schedule| {
            schedule.configure_sets((ControlSystems::BuiltIn, ControlSystems::Custom).chain());
        });
        edit(Loads.intern(), |_| {});
    }
}
