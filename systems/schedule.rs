//! The `Increment` schedule, its sets, and the rule that their order is complete.
//!
//! One run of [`Increment`] commits one increment (or the fraction of one that could be solved):
//!
//! ```text
//! Increment:         Attempts -> Update -> Rupture -> Walls -> Record
//!   Attempts runs    AttemptIncrement, again and again until an attempt is accepted:
//!                    Gather -> Detect -> Assemble -> AssembleExtra -> Solve -> Judge
//!   Walls runs       ControlWalls: BuiltIn -> Custom, for the increment that follows
//! ```
//!
//! Attempts change no bodies, walls, bonds or contact history, but for grains that settle
//! ([`settle`](crate::attempt::settle)), and they are put back if the increment fails: one that does
//! not converge leaves no trace.

use std::time::Instant;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};

use clastic_components::attempt::{Attempt, IncrementStatus};
use clastic_components::observation::Timings;

/// One increment.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Increment;

/// One attempt at an increment, run by [`IncrementSystems::Attempts`].
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AttemptIncrement;

/// Turns the control of walls into their drives for the next increment; run at the start of a
/// stage and in [`IncrementSystems::Walls`].
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ControlWalls;

/// Sets of [`Increment`], in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IncrementSystems {
    /// Detection, assembly and solve, until an attempt is accepted.
    Attempts,
    /// Commits the accepted attempt to the bodies.
    Update,
    /// Breaks bonds.
    Rupture,
    /// Drives walls for the next increment.
    Walls,
    /// Measures what happened.
    Record,
}

/// Sets of [`AttemptIncrement`], in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AttemptSystems {
    /// Bodies and bonds into identity order.
    Gather,
    /// Potential contacts.
    Detect,
    /// The cone program.
    Assemble,
    /// Rows and loads of an embedding program: write [`ConeProgram`](clastic_components::program::ConeProgram).
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

/// Adds the three schedules with their sets.
pub struct SchedulePlugin;

impl Plugin for SchedulePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Timings>().insert_resource(Lap(Instant::now()));
        let settings = ScheduleBuildSettings {
            // An order that nobody stated is an order that may change: refuse it.
            ambiguity_detection: LogLevel::Error,
            hierarchy_detection: LogLevel::Error,
            ..Default::default()
        };
        let mut increment = Schedule::new(Increment);
        increment.configure_sets(
            (
                IncrementSystems::Attempts,
                IncrementSystems::Update.run_if(committed),
                IncrementSystems::Rupture.run_if(ruptured),
                IncrementSystems::Walls.run_if(committed),
                IncrementSystems::Record,
            )
                .chain(),
        );
        let mut attempt = Schedule::new(AttemptIncrement);
        attempt.configure_sets(
            (
                AttemptSystems::Gather,
                AttemptSystems::Detect,
                AttemptSystems::Assemble,
                AttemptSystems::AssembleExtra,
                AttemptSystems::Solve,
                AttemptSystems::Judge,
            )
                .chain(),
        );
        let mut control = Schedule::new(ControlWalls);
        control.configure_sets((ControlSystems::BuiltIn, ControlSystems::Custom).chain());
        for mut schedule in [increment, attempt, control] {
            schedule.set_build_settings(settings.clone());
            // The parts of an increment depend on each other in a chain: threads would only wait.
            schedule.set_executor(SingleThreadedExecutor::new());
            app.add_schedule(schedule);
        }
    }
}
