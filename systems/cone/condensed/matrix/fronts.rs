//! The data of a factorisation that depend on the pattern only: fronts, their order, and the places
//! of their numbers.
//!
//! A front has pivots, a group of bodies that are eliminated together, and rows, the bodies that
//! are coupled with them. Its numbers are a dense trapezoid, the columns of the factor at its
//! pivots, and an update, which the elimination of the pivots adds to the rows. Fronts form a tree:
//! all rows of a front are pivots or rows of its parent (Duff and Reid 1983; Liu 1992).

use std::ops::Range;

use super::dense::LANES;
use super::packed::packed_len;
use super::tasks::{parents, work};

/// Number of branches in which passes over the interactions are divided, as far as the tree allows.
const BRANCHES: usize = 16;

/// One front. Places of bodies are those within its task: see [`Fronts::within`].
pub struct Front {
    /// Places of the pivots.
    pub pivots: Range<usize>,
    /// Range of its rows in [`Fronts::rows`] and [`Fronts::in_parent`].
    pub rows: Range<usize>,
    /// Number of its rows that are pivots of its parent: its first rows.
    pub inside: usize,
    /// Range of its children in [`Fronts::children`].
    pub children: Range<usize>,
    /// Range of its trapezoid in the factor of its task.
    pub factor: Range<usize>,
    /// Start of its update in a stack of its task; `odd` selects one of the two stacks.
    pub update: usize,
    /// Whether its depth in the tree is odd, so that parent and child use different stacks.
    pub odd: bool,
}

impl Front {
    /// Columns of the trapezoid, three a pivot.
    pub fn width(&self) -> usize {
        3 * self.pivots.len()
    }

    /// Rows of a column of the update, with padding.
    pub fn bottom(&self) -> usize {
        (3 * self.rows.len()).next_multiple_of(LANES)
    }

    /// Rows of a column of the trapezoid, with padding for pieces of [`LANES`] that begin anywhere.
    pub fn height(&self) -> usize {
        (3 * self.bodies() + LANES - 1).next_multiple_of(LANES)
    }

    pub fn bodies(&self) -> usize {
        self.pivots.len() + self.rows.len()
    }

    /// Numbers in the update: a square, whose lower triangle is used.
    pub(crate) fn update_len(&self) -> usize {
        self.bottom() * 3 * self.rows.len()
    }
}

/// Some subtrees of the tree, without the parts of them that are tasks of their own.
#[derive(Default)]
pub struct Task {
    pub fronts: Range<usize>,
    /// Its bodies in the order of elimination.
    pub places: Range<usize>,
    /// Range of the rows of its subtrees in [`Fronts::beyond`] and [`Fronts::beyond_above`].
    pub beyond: Range<usize>,
    /// Numbers in its factor, without the triangles of the pivots.
    pub factor_len: usize,
    /// Maximum number of numbers in each of its two stacks of updates.
    pub update_len: [usize; 2],
}

/// All fronts, children before their parents.
#[derive(Default)]
pub struct Fronts {
    /// Bodies in the order of their elimination.
    pub order: Vec<usize>,
    pub list: Vec<Front>,
    /// The tasks, in the order of elimination.
    pub tasks: Vec<Task>,
    /// Number of tasks in the subtrees of every task, itself included.
    pub sizes: Vec<usize>,
    /// The tasks directly below each.
    pub below: Vec<Vec<usize>>,
    /// For every task the bodies that are rows of its subtrees and are eliminated after them: their
    /// places in [`order`](Self::order), ascending, and those within the task above.
    pub beyond: Vec<u32>,
    pub beyond_above: Vec<u32>,
    /// Places of the rows of all fronts within their task, ascending for each front.
    pub rows: Vec<u32>,
    /// For every row, the start of its three numbers in a column of the parent's trapezoid.
    pub in_parent: Vec<u32>,
    /// The children of all fronts: the fronts whose updates a front takes.
    pub children: Vec<u32>,
    /// The pairs front by front, those whose first body is a pivot of it: the places of their bodies
    /// among its pivots and rows, ascending.
    pub pairs: Vec<[u32; 2]>,
    /// Start of the pairs of every front, and the end of the last.
    pub pair_starts: Vec<usize>,
}

impl Fronts {
    /// The place of a body within a task: its own bodies come first, then those beyond.
    pub fn within(&self, task: &Task, place: usize) -> usize {
        if place < task.places.end {
            return place - task.places.start;
        }
        let beyond = &self.beyond[task.beyond.clone()];
        task.places.len() + beyond.partition_point(|other| (*other as usize) < place)
    }

    /// Place of a pivot and of a body that is eliminated later among the pivots and rows of the
    /// front of the pivot. The arguments are places in [`order`](Self::order).
    pub(crate) fn in_front(&self, front: usize, bodies: [usize; 2]) -> [usize; 2] {
        let (task, front) = (&self.tasks[self.task_of(front)], &self.list[front]);
        bodies.map(|place| {
            let place = self.within(task, place);
            if place < front.pivots.end {
                return place - front.pivots.start;
            }
            let rows = &self.rows[front.rows.clone()];
            front.pivots.len() + rows.partition_point(|row| (*row as usize) < place)
        })
    }

    /// The task of a front.
    pub(crate) fn task_of(&self, front: usize) -> usize {
        self.tasks.partition_point(|task| task.fronts.end <= front)
    }

    /// Ranges of tasks whose bodies no pair joins: complete subtrees with at most a sixteenth of
    /// the bodies, next to each other.
    pub fn branches(&self) -> Vec<Range<usize>> {
        let bodies = |tasks: &Range<usize>| {
            self.tasks[tasks.end - 1].places.end - self.tasks[tasks.start].places.start
        };
        let maximum = self.order.len() / BRANCHES;
        let mut branches: Vec<Range<usize>> = Vec::new();
        if self.tasks.len() < 2 {
            return branches;
        }
        let mut end = self.tasks.len();
        while end > 0 {
            let subtree = end - self.sizes[end - 1]..end;
            if bodies(&subtree) > maximum {
                end -= 1;
                continue;
            }
            end = subtree.start;
            match branches.last_mut() {
                Some(last) if last.start == subtree.end && bodies(&(end..last.end)) <= maximum => {
                    last.start = end;
                }
                _ => branches.push(subtree),
            }
        }
        branches.reverse();
        branches
    }

    /// Work of the longest path over that of the whole tree, where `threads` threads share the work
    /// on large fronts.
    pub fn longest_path(&self, threads: usize) -> f64 {
        let (mut total, mut longest) = (0.0, 0.0_f64);
        let mut below = vec![0.0_f64; self.tasks.len()];
        for (k, (task, above)) in self.tasks.iter().zip(parents(&self.sizes)).enumerate() {
            for front in &self.list[task.fronts.clone()] {
                let work = work(front.pivots.len(), front.rows.len());
                total += work;
                below[k] += if packed_len(front) > 0 { work / threads as f64 } else { work };
            }
            longest = longest.max(below[k]);
            if let Some(above) = above {
                // The work of the task above is added when its turn comes.
                below[above] = below[above].max(below[k]);
            }
        }
        if total > 0.0 { longest / total } else { 1.0 }
    }
}
