//! Cuts the tree of fronts into tasks, and passes over them. A task waits for the tasks below it
//! alone, so that several threads can work on the tree at once.
//!
//! A subtree with at most a two-hundredth of the work, or with little work, is not cut; small ones
//! that hang on the same task are taken together. Above them, every chain of fronts without a fork
//! is one task. There are at most about a thousand tasks therefore, however long the chains are.
//! The cut follows from the pattern, not from the number of threads, and a task takes the results of
//! those below it in their order: any number of threads gives the same bytes.

use super::merge::Group;
use crate::condensed::parallel::join;

/// Minimum number of bodies of a matrix with more than one task: for less, a second thread gains
/// nothing.
const MIN_BODIES: usize = 1000;
/// Maximum work of a subtree that is not cut, as a part of the whole.
const GRAIN: f64 = 1.0 / 200.0;
/// A subtree with at most this work is not cut either. It lasts some three tenths of a millisecond.
/// Shorter tasks, each with memory of its own, make the solves of 2000 disks up to 6 % slower.
const MIN_WORK: f64 = 1e6;

/// A task of the cut.
#[derive(Default)]
pub(crate) struct Cut {
    /// The columns at the feet of its subtrees. The tasks below it are parts of these subtrees that
    /// do not belong to it.
    pub feet: Vec<usize>,
    /// Number of tasks in its subtrees, itself included: it comes last of them.
    pub size: usize,
}

/// A task while the tree is cut.
#[derive(Default)]
struct Node {
    feet: Vec<usize>,
    /// The tasks directly below.
    below: Vec<usize>,
    /// Columns of small subtrees that hang on it.
    small: Vec<usize>,
}

/// The tasks, each after those below it.
pub fn cut(rows: &[Vec<u32>], groups: &[Option<Group>], roots: &[usize]) -> Vec<Cut> {
    // Children come before their parents.
    let mut whole = vec![0.0; groups.len()];
    for (k, group) in groups.iter().enumerate() {
        let Some(group) = group else { continue };
        let children: f64 = group.children.iter().map(|c| whole[*c]).sum();
        whole[k] = work(group.pivots.len(), rows[k].len()) + children;
    }
    let all: f64 = roots.iter().map(|root| whole[*root]).sum();
    let grain = (GRAIN * all).max(MIN_WORK);
    if groups.len() < MIN_BODIES || all <= grain {
        return vec![Cut { feet: roots.to_vec(), size: 1 }];
    }
    let mut nodes: Vec<Node> = Vec::new();
    // The task of every front that is not in a small subtree.
    let mut task_of = vec![0; groups.len()];
    let mut add = |children: &[usize], column: Option<usize>| {
        let (small, large): (Vec<usize>, Vec<usize>) =
            children.iter().partition(|c| whole[**c] <= grain);
        let task = match (&large[..], column) {
            (&[child], Some(_)) => task_of[child],
            _ => {
                let below = large.iter().map(|c| task_of[*c]).collect();
                nodes.push(Node { below, ..Node::default() });
                nodes.len() - 1
            }
        };
        nodes[task].small.extend(small);
        if let Some(column) = column {
            nodes[task].feet = vec![column];
            task_of[column] = task;
        }
        task
    };
    for (k, group) in groups.iter().enumerate() {
        if let Some(group) = group.as_ref().filter(|_| whole[k] > grain) {
            add(&group.children, Some(k));
        }
    }
    // What everything hangs on is no task.
    let all = add(roots, None);
    for task in 0..=all {
        let small = std::mem::take(&mut nodes[task].small);
        for feet in share_out(&small, &whole, grain) {
            let new = nodes.len();
            nodes.push(Node { feet, ..Node::default() });
            nodes[task].below.push(new);
        }
    }
    let mut cuts = Vec::new();
    add_in_postorder(&mut nodes, all, &mut cuts);
    cuts.pop();
    cuts
}

/// Small subtrees in groups with at most the work `grain`, in their order.
fn share_out(feet: &[usize], whole: &[f64], grain: f64) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut work = f64::INFINITY;
    for &foot in feet {
        if work + whole[foot] > grain {
            groups.push(Vec::new());
            work = 0.0;
        }
        work += whole[foot];
        groups.last_mut().expect("a group was begun").push(foot);
    }
    groups
}

/// Adds the tasks in the subtree of one, each after those below it.
fn add_in_postorder(nodes: &mut [Node], task: usize, cuts: &mut Vec<Cut>) {
    let first = cuts.len();
    let Node { feet, below, .. } = std::mem::take(&mut nodes[task]);
    for below in below {
        add_in_postorder(nodes, below, cuts);
    }
    cuts.push(Cut { feet, size: cuts.len() + 1 - first });
}

/// Work of a front: multiplications, and four times the numbers that are moved. Moving a number
/// takes several times as long as a multiplication.
pub fn work(pivots: usize, rows: usize) -> f64 {
    let (width, below) = (3.0 * pivots as f64, 3.0 * rows as f64);
    let multiplications = width * (width * width / 3.0 + width * below + below * below);
    let numbers = width * (width + below) + below * below;
    multiplications + 4.0 * numbers
}

// Passes over the tasks of a tree. `sizes` has the number of tasks in the subtree of each, itself
// included; every task comes after the rest of its subtree. The recursion is at most as deep as
// there are tasks.

/// Calls `f` for every task of complete subtrees with the data of the other tasks in its subtree,
/// and its own: for those below a task first. Returns whether all calls returned true; a task above
/// one that did not is left out.
pub(crate) fn upward<T: Send + Sync>(
    sizes: &[usize],
    data: &mut [T],
    f: &(impl Fn(&mut [T], &mut T) -> bool + Sync),
) -> bool {
    let Some(size) = sizes.last() else { return true };
    let at = sizes.len() - size;
    let (before, subtree) = data.split_at_mut(at);
    let last = || {
        let (own, below) = subtree.split_last_mut().expect("a subtree has a task");
        upward(&sizes[at..sizes.len() - 1], below, f) && f(below, own)
    };
    let (others, last) = join(at > 0, || upward(&sizes[..at], before, f), last);
    others && last
}

/// Calls `f` for every task of complete subtrees with the data of the task `above` it, and its own:
/// for the task above first.
pub(crate) fn downward<T: Send + Sync>(
    sizes: &[usize],
    data: &mut [T],
    above: Option<&T>,
    f: &(impl Fn(Option<&T>, &mut T) + Sync),
) {
    let Some(size) = sizes.last() else { return };
    let at = sizes.len() - size;
    let (before, subtree) = data.split_at_mut(at);
    let last = || {
        let (own, below) = subtree.split_last_mut().expect("a subtree has a task");
        f(above, own);
        downward(&sizes[at..sizes.len() - 1], below, Some(own), f);
    };
    join(at > 0, || downward(&sizes[..at], before, above, f), last);
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
