//! Passes over the tasks of a tree, on several threads where the pool has some.
//!
//! `sizes` has the number of tasks in the subtree of each, itself included; every task comes after
//! the rest of its subtree. The recursion is at most as deep as there are tasks, about a
//! thousand.

use super::super::parallel::is_alone;

/// Calls `f` for every task with its number, the data of the other tasks in its subtree, and its
/// own: for those below a task first. Returns whether all calls returned true; a task above one
/// that did not is left out.
pub fn upward<T: Send + Sync>(
    sizes: &[usize],
    data: &mut [T],
    f: &(impl Fn(usize, &mut [T], &mut T) -> bool + Sync),
) -> bool {
    if sizes.len() > 1 && !is_alone() {
        return upward_in_parallel(sizes, 0, data, f);
    }
    (0..sizes.len()).all(|k| {
        let (below, own) = data[k + 1 - sizes[k]..=k].split_at_mut(sizes[k] - 1);
        f(k, below, &mut own[0])
    })
}

/// As [`upward`], for complete subtrees whose tasks are counted from `first`.
fn upward_in_parallel<T: Send + Sync>(
    sizes: &[usize],
    first: usize,
    data: &mut [T],
    f: &(impl Fn(usize, &mut [T], &mut T) -> bool + Sync),
) -> bool {
    let Some(size) = sizes.last() else { return true };
    let at = sizes.len() - size;
    let (before, subtree) = data.split_at_mut(at);
    let others = || upward_in_parallel(&sizes[..at], first, before, f);
    let mut last = || {
        let (own, below) = subtree.split_last_mut().expect("a subtree has a task");
        let first = first + at;
        upward_in_parallel(&sizes[at..sizes.len() - 1], first, below, f)
            && f(first + below.len(), below, own)
    };
    if at == 0 {
        return last();
    }
    let (others, last) = rayon::join(others, last);
    others && last
}

/// Calls `f` for every task with its number, the data of the task above it, and its own: for the
/// task above first.
pub fn downward<T: Send + Sync>(
    sizes: &[usize],
    data: &mut [T],
    f: &(impl Fn(usize, Option<&T>, &mut T) + Sync),
) {
    if sizes.len() > 1 && !is_alone() {
        downward_in_parallel(sizes, 0, data, None, f);
        return;
    }
    let above = parents(sizes);
    for k in (0..sizes.len()).rev() {
        let (own, after) = data[k..].split_at_mut(1);
        f(k, above[k].map(|above| &after[above - k - 1]), &mut own[0]);
    }
}

/// As [`downward`], for complete subtrees below one task.
fn downward_in_parallel<T: Send + Sync>(
    sizes: &[usize],
    first: usize,
    data: &mut [T],
    above: Option<&T>,
    f: &(impl Fn(usize, Option<&T>, &mut T) + Sync),
) {
    let Some(size) = sizes.last() else { return };
    let at = sizes.len() - size;
    let (before, subtree) = data.split_at_mut(at);
    let others = || downward_in_parallel(&sizes[..at], first, before, above, f);
    let mut last = || {
        let (own, below) = subtree.split_last_mut().expect("a subtree has a task");
        let first = first + at;
        f(first + below.len(), above, own);
        downward_in_parallel(&sizes[at..sizes.len() - 1], first, below, Some(own), f);
    };
    if at == 0 {
        last();
    } else {
        rayon::join(others, last);
    }
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
