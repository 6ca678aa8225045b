//! The imposed motion goes back after a rupture, with
//! [`RuptureRules::snap_back`]: an increment of a negative fraction ends at the limit of the next
//! bond ([`snap_back`](crate::snap_back)). Where no such state is found the increment seeks the
//! equilibrium at constant load, as without this option.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Effort, Verdict};
use clastic_components::findings::{EventSearch, EventTrial, Sliding};
use clastic_components::increment::{Progress, RuptureRules};
use clastic_cone::program::{ConeSolution, SolveStatus};

use super::events;

use crate::event_search::maximum;
use crate::snap_back::{Return, decide};

/// The consequence of a trial on the way back.
pub(super) enum Next {
    /// It is committed, and the bonds with these indices break.
    Stands(Vec<usize>),
    /// Solve at this fraction.
    Try(f64),
}

/// Takes a trial on the way back. The motion goes back to the start of the stage at most.
pub(super) fn next(
    rules: &RuptureRules,
    trial: EventTrial,
    progress: &Progress,
    search: &mut EventSearch,
) -> Next {
    let (above, holding) = (search.above.as_ref(), search.below.as_ref());
    match decide(above, holding, &trial, search.trials, progress.done, rules.tolerance) {
        Return::Holds => Next::Stands(Vec::new()),
        Return::Root(bond) => Next::Stands(vec![bond]),
        Return::Try(fraction) => {
            let side = if maximum(&trial) > 1.0 { &mut search.above } else { &mut search.below };
            *side = Some(trial);
            Next::Try(fraction)
        }
        Return::NoRoot => {
            give_up(search);
            Next::Try(0.0)
        }
    }
}

/// Goes on at constant load.
fn give_up(search: &mut EventSearch) {
    *search = EventSearch { active: search.active, no_root: true, ..EventSearch::default() };
}

/// Decides on a trial without an equilibrium nearby. At the standing motion such a trial may still
/// show how far the imposed motion goes back; elsewhere the way back is given up.
pub(super) fn judge_where_lost(world: &mut World) {
    let search = world.resource::<EventSearch>();
    if !search.returns || search.moved {
        return;
    }
    let attempt = world.resource::<Attempt>();
    let is_lost = match attempt.verdict {
        Verdict::TooFar(_) | Verdict::Impossible | Verdict::Loose | Verdict::Locked => true,
        Verdict::Unconverged(_) => attempt.effort() == Some(Effort::Regularised),
        _ => false,
    };
    if !is_lost {
        return;
    }
    if world.resource::<Progress>().fraction < 0.0 {
        give_up(&mut world.resource_mut::<EventSearch>());
        world.resource_mut::<Attempt>().verdict = Verdict::Overloaded;
        return;
    }
    let is_far = matches!(attempt.verdict, Verdict::TooFar(_));
    if !is_far || world.resource::<Sliding>().lost {
        // The verdict decides how the increment goes on at the standing motion.
        give_up(&mut world.resource_mut::<EventSearch>());
        return;
    }
    // A solution that is far without an error of the regularisation was judged: its bonds hold.
    if world.resource::<ConeSolution>().status == SolveStatus::Solved {
        return;
    }
    // The part that broke off springs away. The trial is not committed, and its overloads show
    // where the next one is made.
    let trial = events::trial_of(world);
    let (rules, progress) = (*world.resource::<RuptureRules>(), world.resource::<Progress>());
    let progress = progress.clone();
    let mut search = world.resource_mut::<EventSearch>();
    if let Next::Try(fraction) = next(&rules, trial, &progress, &mut search)
        && fraction < 0.0
    {
        search.trials += 1;
        search.target = fraction;
        world.resource_mut::<Attempt>().verdict = Verdict::Overloaded;
    }
}
