//! Factorisation task by task, with the memory of updates lent to the tasks that need it.

use std::mem::take;

use super::super::parallel::Lent;
use super::fronts::{Fronts, Task};
use super::schedule::upward;

/// The numbers of a task with its updates, which are lent from its beginning until the task above
/// has taken them.
pub trait Part: Send + Sync {
    fn updates(&mut self) -> &mut Vec<f64>;
    /// Length that the updates of the task need.
    fn update_len(&self, task: &Task) -> usize;
}

/// Calls `f` for every task with its number, the parts of the other tasks in its subtree, and its
/// own, as [`upward`] does. Returns whether all calls returned true.
pub fn factorise<P: Part>(
    fronts: &Fronts,
    parts: &mut [P],
    updates: &Lent<Vec<f64>>,
    f: &(impl Fn(usize, &[P], &mut P) -> bool + Sync),
) -> bool {
    let has_factor = upward(&fronts.sizes, parts, &|task, below, part| {
        *part.updates() = updates.take(part.update_len(&fronts.tasks[task]));
        let has_factor = f(task, below, part);
        let first_below = task - below.len();
        for other in &fronts.below[task] {
            updates.give(take(below[other - first_below].updates()));
        }
        has_factor
    });
    // Those of the roots, and of all tasks below one without a factor.
    for part in parts {
        updates.give(take(part.updates()));
    }
    has_factor
}
