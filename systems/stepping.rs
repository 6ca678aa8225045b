//! Repeated increments: the [`AdvanceIncrement`] schedule, and when the app runs it.

use std::time::Duration;

use bevy_app::{
    App, FixedFirst, FixedLast, FixedPostUpdate, FixedPreUpdate, FixedUpdate, Plugin,
    RunFixedMainLoop, RunFixedMainLoopSystems, Update,
};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{InternedScheduleLabel, ScheduleLabel};
use bevy_time::{Fixed, Time};

use clastic_components::prelude::*;

use crate::mechanism::proof;
pub use crate::schedule::ClasticHalted;
use crate::schedule::{Increment, edit_chain};

/// One increment with the work before and after it.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AdvanceIncrement;

/// Sets of [`AdvanceIncrement`], in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AdvanceSystems {
    /// Work before the increment: stages end and begin. Sets [`IncrementDue`].
    Begin,
    /// The increment.
    Increment,
    /// Work after the increment: its status, and whether the stage continues. Runs only if an
    /// increment was due.
    End,
    /// Messages and events to the app. Runs only if an increment was due and was not undone.
    Announce,
    /// Output, which changes no result. Runs only if an increment was due.
    Output,
}

/// Whether [`AdvanceIncrement`] makes an increment.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct IncrementDue(pub bool);

impl Default for IncrementDue {
    fn default() -> Self {
        Self(true)
    }
}

/// Whether the increment has been undone. [`advance`] then runs [`AdvanceIncrement`] again.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct IncrementUndone(pub bool);

/// Runs [`AdvanceIncrement`] to the end of an increment that stays. A system that undoes one sets
/// [`IncrementUndone`], and sets [`IncrementDue`] to false so that no output is written.
pub fn advance(world: &mut World) {
    loop {
        world.run_schedule(AdvanceIncrement);
        if !std::mem::take(&mut world.resource_mut::<IncrementUndone>().0) {
            break;
        }
    }
}

/// Whether the app goes on by itself when the schedule of its plugins runs. A world without
/// particles makes no increment.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub enum ClasticRunning {
    /// One increment per run of the schedule.
    #[default]
    Always,
    /// One increment per run of the schedule for this number of runs, then none.
    Times(u32),
    /// No increments.
    Paused,
    /// No increments, because the next one would be the last one again, or because the world is
    /// [`ClasticHalted`]. The message [`ClasticStopped`] has the reason. After you have changed
    /// what made the increment fail, insert another `ClasticRunning`.
    Stopped(StoppedBy),
}

/// What has stopped the app.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum StoppedBy {
    /// The last increment has no equilibrium. Nothing of it was committed.
    Collapsed,
    /// Neither an equilibrium nor a collapse was found. Nothing was committed.
    Undecided,
    /// The world has the resource [`ClasticHalted`].
    Halted,
    /// All stages of the scene have ended.
    Completed,
    /// A stage of the scene cannot begin.
    Refused,
}

/// Message, and event for observers, of the app when it stops by itself, and [`ClasticRunning`]
/// becomes [`ClasticRunning::Stopped`].
#[derive(Message, Event, Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ClasticStopped {
    /// What has stopped it.
    pub by: StoppedBy,
    /// Number of the last increment.
    pub increment: u64,
    /// The reason in words.
    pub reason: String,
}

/// How the run has ended and the reason in words, once it has, in a world in which a plugin decides
/// what follows an increment, as the stages of a scene do. Otherwise the app stops at an increment
/// that was not committed.
#[derive(Resource, Clone, Debug, Default)]
pub struct EndOfRun(pub Option<(StoppedBy, String)>);

impl ClasticRunning {
    /// Whether the app may make another increment.
    fn may_go_on(self) -> bool {
        !matches!(self, Self::Times(0) | Self::Paused | Self::Stopped(_))
    }

    /// Reduces the number of remaining increments by one.
    fn made_one(&mut self) {
        if let Self::Times(n) = *self {
            *self = if n <= 1 { Self::Paused } else { Self::Times(n - 1) };
        }
    }
}

/// The set of the system that makes increments, in the schedule of the app: order your own systems
/// before or after it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ClasticStepping;

/// Adds [`AdvanceIncrement`] and runs it whenever `schedule` runs and [`ClasticRunning`] allows it.
/// In one of Bevy's fixed schedules an increment is one time step: `Time<Fixed>` follows `dt` of
/// the [`ClasticAnalysis`].
pub struct SteppingPlugin {
    /// The schedule of the app that makes increments.
    pub schedule: InternedScheduleLabel,
}

impl Default for SteppingPlugin {
    fn default() -> Self {
        Self { schedule: Update.intern() }
    }
}

impl Plugin for SteppingPlugin {
    fn build(&self, app: &mut App) {
        edit_chain(app, AdvanceIncrement, |advance| {
            advance.configure_sets(
                (
                    AdvanceSystems::Begin.run_if(not(resource_exists::<ClasticHalted>)),
                    AdvanceSystems::Increment.run_if(is_due),
                    AdvanceSystems::End.run_if(is_due),
                    AdvanceSystems::Announce.run_if(has_news),
                    AdvanceSystems::Output.run_if(is_due),
                )
                    .chain(),
            );
            advance.add_systems(increment.in_set(AdvanceSystems::Increment));
        });
        app.init_resource::<IncrementDue>()
            .init_resource::<IncrementCommitted>()
            .init_resource::<IncrementUndone>()
            .init_resource::<ClasticRunning>()
            .add_message::<ClasticStopped>()
            .add_systems(self.schedule, step.in_set(ClasticStepping));
        let fixed = [
            FixedFirst.intern(),
            FixedPreUpdate.intern(),
            FixedUpdate.intern(),
            FixedPostUpdate.intern(),
            FixedLast.intern(),
        ];
        if fixed.contains(&self.schedule) {
            app.add_systems(
                RunFixedMainLoop,
                follow_time_step
                    .run_if(resource_exists::<Time<Fixed>>)
                    .in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop),
            );
        }
    }
}

/// Gives Bevy's fixed schedules the time step of a dynamic analysis, which alone sets it. In
/// statics, where increments have no duration, the app chooses how many it wants per second.
fn follow_time_step(analysis: Res<ClasticAnalysis>, mut time: ResMut<Time<Fixed>>) {
    let AnalysisKind::Dynamic { dt, .. } = analysis.kind else { return };
    // Others are refused when the increment begins.
    let step = Duration::try_from_secs_f64(dt).unwrap_or_default();
    if step != Duration::ZERO && step != time.timestep() {
        time.set_timestep(step);
    }
}

/// Run condition: [`AdvanceIncrement`] makes an increment, and nothing has halted it.
pub fn is_due(due: Res<IncrementDue>, halted: Option<Res<ClasticHalted>>) -> bool {
    due.0 && halted.is_none()
}

/// Run condition: as [`is_due`], or the world halted after an increment was committed, whose events
/// are announced all the same.
fn has_news(
    due: Res<IncrementDue>,
    halted: Option<Res<ClasticHalted>>,
    committed: Res<IncrementCommitted>,
) -> bool {
    due.0 && (committed.0 || halted.is_none())
}

/// Whether [`AdvanceIncrement`] has just committed an increment.
#[derive(Resource, Default)]
struct IncrementCommitted(bool);

/// Exclusive, because it runs a schedule.
fn increment(world: &mut World) {
    let before = world.resource::<ClasticProgress>().increment;
    world.run_schedule(Increment);
    let is_tried = world.resource::<ClasticProgress>().increment != before;
    let status = world.get_resource::<Attempt>().map(|attempt| attempt.status);
    let is_committed = is_tried && status.is_some_and(IncrementStatus::is_committed);
    world.insert_resource(IncrementCommitted(is_committed));
}

/// Makes an increment if the app is [`ClasticRunning`] and has a particle or a wall. Exclusive,
/// because it runs a schedule.
fn step(world: &mut World, bodies: &mut QueryState<(), Or<(With<Particle>, With<Wall>)>>) {
    // `QueryState::is_empty` looks only at the archetypes that it knows, and it learns of no new
    // ones.
    let is_empty = bodies.iter(world).next().is_none();
    if is_empty || !world.resource::<ClasticRunning>().may_go_on() {
        return;
    }
    let before = world.resource::<ClasticProgress>().increment;
    advance(world);
    let increment = world.resource::<ClasticProgress>().increment;
    if let Some((by, reason)) = obstacle(world, increment != before) {
        world.insert_resource(ClasticRunning::Stopped(by));
        let stopped = ClasticStopped { by, increment, reason };
        world.write_message(stopped.clone());
        world.trigger(stopped);
    } else if increment != before {
        world.resource_mut::<ClasticRunning>().made_one();
    }
}

/// What keeps the app from going on. `tried` is whether it has just tried an increment.
fn obstacle(world: &World, tried: bool) -> Option<(StoppedBy, String)> {
    if let Some(ClasticHalted(reason)) = world.get_resource::<ClasticHalted>() {
        return Some((StoppedBy::Halted, reason.clone()));
    }
    if let Some(EndOfRun(end)) = world.get_resource::<EndOfRun>() {
        return end.clone();
    }
    if !tried {
        return None;
    }
    let attempt = world.get_resource::<Attempt>()?;
    match attempt.status {
        IncrementStatus::Solved | IncrementStatus::Capped => None,
        IncrementStatus::Collapsed => {
            let reason = proof(world).unwrap_or_else(|| attempt.complaint.clone());
            Some((StoppedBy::Collapsed, reason))
        }
        IncrementStatus::Undecided => Some((StoppedBy::Undecided, attempt.complaint.clone())),
    }
}
