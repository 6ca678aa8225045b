//! The imposed motion goes back after a rupture, with
//! [`RuptureRules::snap_back`]: an increment of a negative fraction ends at the limit of the next
//! bond ([`snap_back`](crate::snap_back)). Where no such state is found the increment seeks the
//! equilibrium at constant load, as without this option.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Effort, Verdict};
use clastic_components::findings::{EventSearch, EventTrial};
use clastic_components::increment::{Progress, RuptureRules};

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

/// Gives up the way back where it has no equilibrium nearby. The verdict on a trial at the standing
/// motion decides how the increment goes on.
pub(super) fn end_where_lost(world: &mut World) {
    let search = world.resource::<EventSearch>();
    if !search.returns || search.moved {
        return;
    }
    let stands = world.resource::<Progress>().fraction == 0.0;
    let attempt = world.resource::<Attempt>();
    let is_lost = match attempt.verdict {
        // At the standing motion all bonds hold in it: nothing has to go back.
        Verdict::TooFar(_) => !stands,
        Verdict::Impossible | Verdict::Loose | Verdict::Locked => true,
        Verdict::Unconverged { .. } => attempt.effort() == Some(Effort::Regularised),
        _ => false,
    };
    if is_lost {
        give_up(&mut world.resource_mut::<EventSearch>());
        if !stands {
            world.resource_mut::<Attempt>().verdict = Verdict::Overloaded;
        }
    }
}

/// Whether the trial is that at the standing motion, which shows how far the imposed motion goes
/// back.
pub(super) fn may_return(search: &EventSearch, progress: &Progress) -> bool {
    search.returns && !search.moved && progress.fraction == 0.0
}
