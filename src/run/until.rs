//! `Until`: the last increment of a stage is shortened, so that a measure lands on a value.
//!
//! The state before every increment of such a stage is kept. An increment in which the measure
//! passes the value is undone and repeated shorter ([`landing`](super::landing)). Repeats leave no
//! trace in the state: they begin with the memory of the solver that the increment began with.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::prelude::*;
use clastic_systems::state::{StateOf, WorldState};
use clastic_systems::stepping::{ClasticHalted, IncrementDue, IncrementUndone};

use super::landing::{Next, Point, RESOLUTION, Search, Side, Try};
use super::measures::{error_of, kept, reading};
use super::script::Script;
use super::state::{capture, rewind};
use crate::scene::format::{Stage, Stop};

/// Name of [`Approach`] in a state.
pub(crate) const APPROACH: &str = "until";

/// Error with which a measure lands, over the value or over the maximum magnitude of the measure in
/// the stage, if that is more.
pub const TOLERANCE: f64 = 1e-6;

/// Part of a time step that a dynamic stage makes to read a measure that does not follow from the
/// state alone. In a much smaller one the forces of impacts would dominate, which grow as steps
/// become short.
const READING: f64 = 0.25;

/// How the measure of an `Until` approaches its value in the current stage.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Approach {
    /// Whether the stage has an `Until`.
    on: bool,
    /// 1 where the measure began below the value, -1 above it, 0 while it has been at it.
    side: f64,
    /// Maximum magnitude of the measure in the stage.
    scale: f64,
    /// Progress of the stage and measure after the last increments, two at most.
    points: Vec<Point>,
}

impl StateOf for Approach {
    fn take(world: &mut World) -> Option<Self> {
        world.get_resource::<Self>().filter(|approach| approach.on).cloned()
    }

    fn put(self, world: &mut World) {
        world.insert_resource(self);
    }
}

/// The increment that may be undone. It is no part of the state: between two increments of the
/// history nothing is searched.
#[derive(Resource)]
pub(crate) struct Undoable {
    state: WorldState,
    /// [`ClasticProgress::tried`] before the increment was shortened.
    tried: f64,
    /// [`Script::stop`], which is no part of the state.
    stop: bool,
    /// `None` for an increment that only reads the measure at the start of the stage.
    search: Option<Search>,
    /// Where the increment under way is to end.
    asked: f64,
}

fn until(stage: &Stage) -> Option<(&str, f64)> {
    stage.stop().iter().find_map(|stop| match stop {
        Stop::Until(name, value) => Some((name.as_str(), *value)),
        _ => None,
    })
}

/// Begins a stage.
pub(super) fn begin(world: &mut World, stage: &Stage) {
    world.insert_resource(Approach { on: until(stage).is_some(), ..Approach::default() });
}

/// Run condition: the stage has an `Until`.
pub(super) fn is_on(approach: Option<Res<Approach>>) -> bool {
    approach.is_some_and(|approach| approach.on)
}

/// Keeps the state before an increment that may be undone, and shortens the increment where the
/// measure is expected to come to its value, or to read the measure at the start of the stage.
/// Exclusive, because it reads everything that plugins have registered.
pub(super) fn keep_state(world: &mut World) {
    if world.contains_resource::<Undoable>() {
        return;
    }
    let progress = world.resource::<ClasticProgress>();
    let stage = world.resource::<Script>().stage(progress.stage);
    let Some((name, value)) = stage.and_then(until) else { return };
    let name = name.to_owned();
    let (done, tried) = (progress.done, progress.tried);
    // Ruptures at constant load are not undone.
    if progress.relaxing || world.resource::<Observation>().in_avalanche {
        return;
    }
    // As the attempts do it.
    let whole = done + (2.0 * tried).min(1.0 - done.fract());
    let is_dynamic = world.resource::<ClasticAnalysis>().kind.dt().is_some();
    // A static stage reads the equilibrium with which it begins. A dynamic one has none: it reads
    // what the state keeps. Both follow from a saved state, so that a run in two pieces begins the
    // stage as a run in one does.
    let is_new = world.resource::<Approach>().points.is_empty();
    let kept = if is_dynamic && is_new { kept(world, &name) } else { None };
    let mut approach = world.resource_mut::<Approach>();
    if let Some(kept) = kept {
        approach.see(done, kept, value, 0.0);
    }
    let search = Search::new(&approach.points, whole, value);
    let state = match capture(world) {
        Ok(state) => state,
        Err(error) => {
            world.insert_resource(ClasticHalted(format!("the state before an increment: {error}")));
            return;
        }
    };
    let stop = world.resource::<Script>().stop;
    let reading = if is_dynamic { READING } else { RESOLUTION };
    let asked = search.as_ref().map_or(done + reading, Search::ahead);
    world.resource_mut::<ClasticProgress>().tried = 0.5 * (asked - done);
    world.insert_resource(Undoable { state, tried, stop, search, asked });
}

/// Undoes the increment and has it repeated shorter, where the measure has passed the value of the
/// `Until` of the stage. Whether it has done so.
pub(super) fn repeats(world: &mut World, stage: &Stage) -> bool {
    // See `forget_halted`.
    if world.contains_resource::<ClasticHalted>() {
        return false;
    }
    let Some(mut undoable) = world.remove_resource::<Undoable>() else { return false };
    let Some((name, value)) = until(stage) else { return false };
    let Some(search) = &mut undoable.search else {
        return begin_anew(world, &undoable, name, value);
    };
    let next = if world.resource::<Attempt>().status.is_committed() {
        let Some(made) = tried(world, name, value, undoable.asked) else { return false };
        search.see(made)
    } else {
        search.without_last().map_or(Next::GoOn, Next::Repeat)
    };
    let Next::Repeat(end) = next else { return false };
    if !undo(world, &undoable) {
        return true;
    }
    undoable.asked = end;
    let mut progress = world.resource_mut::<ClasticProgress>();
    progress.tried = 0.5 * (end - progress.done);
    world.insert_resource(undoable);
    true
}

/// Run condition: the world was halted within an increment that may be undone.
pub(super) fn is_halted(
    halted: Option<Res<ClasticHalted>>,
    undoable: Option<Res<Undoable>>,
) -> bool {
    halted.is_some() && undoable.is_some()
}

/// Forgets the search of a halted increment, and the length that it gave to the increment. The kept
/// state has the values that halted the world. The app may go on with others, so that the search
/// begins anew.
pub(super) fn forget_halted(
    undoable: Res<Undoable>,
    mut progress: ResMut<ClasticProgress>,
    mut commands: Commands,
) {
    progress.tried = undoable.tried;
    commands.remove_resource::<Undoable>();
}

/// Undoes the increment that has read the measure at the start of the stage.
fn begin_anew(world: &mut World, undoable: &Undoable, name: &str, value: f64) -> bool {
    let is_solved = world.resource::<Attempt>().status.is_committed();
    let start = reading(world, name).filter(|_| is_solved);
    let error = error_of(world, name);
    if undo(world, undoable) {
        let done = world.resource::<ClasticProgress>().done;
        let mut approach = world.resource_mut::<Approach>();
        match start {
            Some(start) => _ = approach.see(done, start, value, error),
            // Known after the first increment, which is not undone.
            None => approach.points.push([done, f64::NAN]),
        }
    }
    true
}

/// Rewinds the world to the state before the increment. Whether this is possible.
fn undo(world: &mut World, undoable: &Undoable) -> bool {
    world.insert_resource(IncrementDue(false));
    if let Err(error) = rewind(world, &undoable.state) {
        // A part of the state is that before the increment, and a part that after it.
        world.insert_resource(ClasticHalted(format!("an increment cannot be undone: {error}")));
        return false;
    }
    world.resource_mut::<Script>().stop = undoable.stop;
    world.insert_resource(IncrementUndone(true));
    true
}

/// The increment as a try; `None` if the measure is not defined.
fn tried(world: &mut World, name: &str, value: f64, asked: f64) -> Option<Try> {
    let now = reading(world, name)?;
    let error = error_of(world, name);
    let end = [world.resource::<ClasticProgress>().done, now];
    let ruptures = world.resource::<Observation>().in_avalanche;
    let mut approach = world.resource::<Approach>().clone();
    let tolerance = approach.see(end[0], now, value, error);
    let way = approach.side * (value - now);
    let side = match way {
        _ if approach.side == 0.0 || way > tolerance => Side::Short,
        _ if way < -tolerance => Side::Past,
        _ => Side::At,
    };
    // Before a rupture that ends the increment at the value the stage cannot end.
    let side = if ruptures && side == Side::At { Side::Short } else { side };
    Some(Try { end, side, is_cut: end[0] < asked - 0.1 * RESOLUTION, ruptures })
}

/// The `Until` of the stage, if its measure has reached the value; and the measure, if it has passed
/// the value by more than the tolerance: it jumps there.
pub(super) fn reached(world: &mut World, stage: &Stage) -> Option<(Stop, Option<f64>)> {
    let (name, value) = until(stage)?;
    let now = reading(world, name)?;
    let error = error_of(world, name);
    let done = world.resource::<ClasticProgress>().done;
    let mut approach = world.resource_mut::<Approach>();
    let tolerance = approach.see(done, now, value, error);
    let beyond = approach.side * (now - value);
    (approach.side != 0.0 && beyond >= -tolerance)
        .then(|| (Stop::Until(name.to_owned(), value), (beyond > tolerance).then_some(now)))
}

/// The condition that a stage which ended with its last increment has missed: its `Until` if it has
/// not landed on it, also because its measure is not defined, otherwise the first condition. A
/// measure that was at the value of the `Until` all the time has not missed it, and a stage that
/// pours may end with room left.
pub(super) fn missed(world: &World, stage: &Stage) -> Option<Stop> {
    let Some((name, value)) = until(stage) else {
        // A compaction has reached its target.
        let stops = &stage.load()?.stop;
        return stops.iter().find(|stop| !matches!(stop, Stop::Full(_))).cloned();
    };
    let approach = world.resource::<Approach>();
    let is_missed = approach.side != 0.0 || approach.points.iter().all(|[_, m]| m.is_nan());
    is_missed.then(|| Stop::Until(name.to_owned(), value))
}

impl Approach {
    /// Takes a reading. Returns the tolerance of the landing.
    fn see(&mut self, done: f64, now: f64, value: f64, error: f64) -> f64 {
        self.scale = self.scale.max(now.abs());
        let tolerance = error.max(TOLERANCE * self.scale.max(value.abs()));
        if self.side == 0.0 && (value - now).abs() > tolerance {
            self.side = (value - now).signum();
        }
        // States of an avalanche have the same progress; the last one counts.
        self.points.retain(|[at, _]| *at < done);
        self.points.push([done, now]);
        if self.points.len() > 2 {
            self.points.remove(0);
        }
        tolerance
    }
}
