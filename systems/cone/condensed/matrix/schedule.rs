//! Passes over the tasks of a tree, on several threads where the pool has some.
//!
//! `sizes` has the number of tasks in the subtree of each, itself included; every task comes after
//! the rest of its subtree. The recursion is at most as deep as there are tasks, about a thousand.

use super::super::parallel::join;

/// Calls `f` for every task of complete subtrees, whose tasks are counted from `first`, with its
/// number, the data of the other tasks in its subtree, and its own: for those below a task first.
/// Returns whether all calls returned true; a task above one that did not is left out.
pub fn upward<T: Send + Sync>(
    first: usize,
    sizes: &[usize],
    data: &mut [T],
    f: &(impl Fn(usize, &mut [T], &mut T) -> bool + Sync),
) -> bool {
    let Some(size) = sizes.last() else { return true };
    let at = sizes.len() - size;
    let (before, subtree) = data.split_at_mut(at);
    let others = || upward(first, &sizes[..at], before, f);
    let last = || {
        let (own, below) = subtree.split_last_mut().expect("a subtree has a task");
        let first = first + at;
        upward(first, &sizes[at..sizes.len() - 1], below, f) && f(first + below.len(), below, own)
    };
    let (others, last) = join(at > 0, others, last);
    others && last
}

/// Calls `f` for every task of complete subtrees, whose tasks are counted from `first`, with its
/// number, the data of the task `above` it, and its own: for the task above first.
pub fn downward<T: Send + Sync>(
    first: usize,
    sizes: &[usize],
    data: &mut [T],
    above: Option<&T>,
    f: &(impl Fn(usize, Option<&T>, &mut T) + Sync),
) {
    let Some(size) = sizes.last() else { return };
    let at = sizes.len() - size;
    let (before, subtree) = data.split_at_mut(at);
    let others = || downward(first, &sizes[..at], before, above, f);
    let last = || {
        let (own, below) = subtree.split_last_mut().expect("a subtree has a task");
        let first = first + at;
        f(first + below.len(), above, own);
        downward(first, &sizes[at..sizes.len() - 1], below, Some(own), f);
    };
    join(at > 0, others, last);
}

/// The task above every task.
pub fn parents(sizes: &[usize]) -> Vec<Option<usize>> {
    let mut parents = vec![None; sizes.len()];
    let mut open: Vec<usize> = Vec::new();
    for k in (0..sizes.len()).rev() {
        while open.last().is_some_and(|above| k + sizes[*above] <= *above) {
            open.pop();
        }
        parents[k] = open.last().copied();
        open.push(k);
    }
    parents
}
