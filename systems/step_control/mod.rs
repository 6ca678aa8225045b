//! Increments of a static stage that are chosen by their error ([`StepControl`]).
//!
//! The normals of the start of an increment hold until its end. The stress at its end therefore has
//! an error in proportion to the increment, which later increments do not inherit. Two increments
//! are solved in one as well: the difference of the mean stresses at the end is the error of the
//! two. The two are committed. The solution in one is made on the tables and leaves nothing behind
//! but the starting point of the solver.

pub mod control;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::attempt::Attempt;
use clastic_components::contact::BodyTable;
use clastic_components::contact_history::DraftHistory;
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_components::step_control::{StepControl, Whole};

use crate::attempt::run_attempts;
use crate::measures::stress::average_stress;
use crate::schedule::{Increment, IncrementSystems};
use crate::solved::Solved;
use crate::state::RegisterState;
use control::{Part, part, see};

/// Name of [`StepControl`] in a state.
pub const STEP_CONTROL: &str = "step_control";

/// Adds [`attempt_by_error`].
pub struct StepControlPlugin;

impl Plugin for StepControlPlugin {
    fn build(&self, app: &mut App) {
        app.register_resource::<StepControl>(STEP_CONTROL).add_systems(
            Increment,
            attempt_by_error
                .in_set(IncrementSystems::Attempts)
                .after(run_attempts)
                .run_if(resource_exists::<StepControl>),
        );
    }
}

/// Makes the attempts at an increment whose fraction the error chooses. In dynamic analysis, and
/// where there are bonds, the stage chooses it. Exclusive, because it runs attempts.
pub fn attempt_by_error(world: &mut World) {
    let is_static = world.resource::<ClasticAnalysis>().kind == AnalysisKind::Static;
    if !is_static || !world.resource::<BodyTable>().bonds.is_empty() {
        return run_attempts(world);
    }
    let mut control = world.resource::<StepControl>().clone();
    let progress = world.resource::<ClasticProgress>();
    let done = progress.done;
    // A stop at a value may have shortened the increment, or it may have been halved.
    let left = (1.0 - done.fract()).min(2.0 * progress.tried);
    if let Some(whole) = control.whole.take() {
        attempt(world, (whole.end - done).min(left));
        if is_at(world, whole.end) {
            let fraction = world.resource::<ClasticProgress>().fraction;
            see(&mut control, &whole, moment(world), fraction);
        }
    } else {
        let finest = 0.5_f64.powf(f64::from(world.resource::<Acceptance>().halvings));
        let Part { fraction, is_checked } = part(&control, left, finest);
        let whole = if is_checked { try_whole(world, 2.0 * fraction) } else { None };
        attempt(world, whole.as_ref().map_or(fraction, |tried| 0.5 * tried.fraction));
        control.unchecked += 1;
        if let Some(tried) = whole {
            let mut now = world.resource_mut::<Attempt>();
            now.solves += tried.attempt.solves;
            now.iterations += tried.attempt.iterations;
            now.motion_steps += tried.attempt.motion_steps;
            if is_at(world, done + 0.5 * tried.fraction) {
                control.whole = Some(Whole { end: done + tried.fraction, moment: tried.moment });
            }
        }
    }
    // An undecided increment is tried again from the state before it.
    if is_committed(world) {
        world.insert_resource(control);
    }
}

/// Runs the attempts at an increment of at most this fraction. Where it was not halved the next one
/// may be whole.
fn attempt(world: &mut World, fraction: f64) {
    // Attempts begin with twice the last fraction.
    world.resource_mut::<ClasticProgress>().tried = 0.5 * fraction;
    run_attempts(world);
    let mut progress = world.resource_mut::<ClasticProgress>();
    if progress.fraction >= fraction * (1.0 - 1e-9) {
        progress.tried = 1.0;
    }
}

/// Whether an increment is committed that ends here.
fn is_at(world: &World, end: f64) -> bool {
    let progress = world.resource::<ClasticProgress>();
    is_committed(world) && (progress.done + progress.fraction - end).abs() < 1e-9
}

/// Whether the attempts ended in a state that is committed.
fn is_committed(world: &World) -> bool {
    world.resource::<Attempt>().status.is_committed()
}

/// Sum of f (x) l over the contacts (xx, xy, yx, yy), N m: the mean stress times the volume.
fn moment(world: &World) -> [f64; 4] {
    let [[xx, xy], [yx, yy]] = average_stress(Solved::of(world), 1.0, 1.0);
    [xx, xy, yx, yy]
}

/// A solution that is not committed.
struct Tried {
    fraction: f64,
    moment: [f64; 4],
    attempt: Attempt,
}

/// Solves an increment and restores the tables. `None` if it has no solution.
fn try_whole(world: &mut World, fraction: f64) -> Option<Tried> {
    let progress = world.resource::<ClasticProgress>().clone();
    let (bodies, draft) =
        (world.resource::<BodyTable>().clone(), world.resource::<DraftHistory>().clone());
    attempt(world, fraction);
    let tried = is_committed(world).then(|| Tried {
        fraction: world.resource::<ClasticProgress>().fraction,
        moment: moment(world),
        attempt: world.resource::<Attempt>().clone(),
    });
    *world.resource_mut::<ClasticProgress>() = progress;
    *world.resource_mut::<BodyTable>() = bodies;
    *world.resource_mut::<DraftHistory>() = draft;
    tried
}
