//! The multifrontal factorisation and the solves with its factor, task by task and front by front,
//! whatever the [arithmetic](Arithmetic) of a front is.
//!
//! For every front: its numbers are assembled from the values of the matrix and the updates of its
//! children, its pivots are eliminated, and an update is left for the parent. The forward solve of
//! the first right side is done front by front too, while the factor is in the cache.

use std::mem::take;

use pulp::{Arch, Simd, WithSimd};

use super::assembly::Block;
use super::dense::LANES;
use super::fronts::{Front, Fronts, Task};
use super::share::{By, Share, dispatch};
use super::tasks::{downward, upward};
use crate::condensed::parallel::{Memory, split};
use crate::condensed::scaled::add_times;

/// The factor of a task, and the arithmetic of its fronts. All functions are inlined into a caller
/// that is compiled for the instructions of the machine.
pub trait Arithmetic: Send + Sync {
    /// Numbers of a pair in the matrix.
    type Pair: Copy + Default + Send + Sync;

    /// Adds `G D G'` to the numbers of a pair with the rows G, those of the body that is eliminated
    /// first coming first.
    fn add_pair<const F: usize>(
        block: &mut Self::Pair,
        rows: [&[[f64; F]; 3]; 2],
        d: &[[f64; F]; F],
    );

    /// Room for the factor of a task.
    fn new(fronts: &Fronts, task: &Task) -> Self;

    /// Numbers of two kinds that a front needs while it is being eliminated.
    fn room(front: &Front) -> [usize; 2];

    /// Eliminates the pivots of a front in this room, and sets its update; whether they can be
    /// eliminated. `update_of` has the updates of its children.
    fn eliminate<'a, S: Simd>(
        &mut self,
        by: By<impl Share, S>,
        at: At,
        values: Values<Self::Pair>,
        update_of: impl Fn(usize) -> &'a [f64],
        update: &mut [f64],
        room: [&mut [f64]; 2],
    ) -> bool;

    /// Forward solve of one front. `local` has the numbers of its pivots and rows, and [`LANES`]
    /// zeros.
    fn forward(&self, at: At, local: &mut [f64]);

    /// Backward solve of one front. `local` has the numbers of its pivots, the solution of its rows,
    /// and [`LANES`] zeros.
    fn backward(&self, at: At, local: &mut [f64]);
}

/// Values of the matrix: blocks of bodies in the order of elimination, and of pairs front by front.
#[derive(Clone, Copy)]
pub struct Values<'a, P> {
    pub bodies: &'a [Block],
    pub pairs: &'a [P],
}

/// A front and its place.
#[derive(Clone, Copy)]
pub struct At<'a> {
    pub fronts: &'a Fronts,
    task: &'a Task,
    /// Its number within its task.
    pub within: usize,
    pub front: &'a Front,
}

impl<'a> At<'a> {
    /// The fronts of a task.
    fn all(fronts: &'a Fronts, task: usize) -> impl DoubleEndedIterator<Item = Self> {
        let task = &fronts.tasks[task];
        let list = fronts.list[task.fronts.clone()].iter().enumerate();
        list.map(move |(within, front)| Self { fronts, task, within, front })
    }

    /// Blocks of its pivots.
    pub(crate) fn of_pivots(self, bodies: &[Block]) -> &[Block] {
        &bodies[self.task.places.start..][self.front.pivots.clone()]
    }

    /// Blocks of its pairs, each with the places of the two bodies among its pivots and rows.
    pub fn of_pairs<P>(self, pairs: &'a [P]) -> impl Iterator<Item = (&'a [u32; 2], &'a P)> {
        let starts = &self.fronts.pair_starts[self.task.fronts.start + self.within..];
        let own = starts[0]..starts[1];
        self.fronts.pairs[own.clone()].iter().zip(&pairs[own])
    }

    /// Places of its rows within the task.
    fn rows(self) -> &'a [u32] {
        &self.fronts.rows[self.front.rows.clone()]
    }

    /// The fronts whose updates it takes, each with the places of its rows in this front.
    pub fn children(self) -> impl DoubleEndedIterator<Item = (usize, &'a Front, &'a [u32])> {
        let fronts = self.fronts;
        fronts.children[self.front.children.clone()].iter().map(move |child| {
            let front = &fronts.list[*child as usize];
            (*child as usize, front, &fronts.in_parent[front.rows.clone()])
        })
    }
}

/// The numbers of a task.
struct Part<A> {
    /// Its number.
    task: usize,
    factor: A,
    /// Updates that wait for the parents of their fronts: of fronts in even depth, then in odd
    /// depth. Lent until the task above has taken them.
    updates: Vec<f64>,
    /// Right side and solution of its bodies, then of those beyond: the task adds to the right side
    /// of those, and needs their solution.
    work: Vec<[f64; 3]>,
    /// Numbers of two kinds that its largest fronts need, and for the right side of a front.
    room: [usize; 3],
}

/// The factor of a matrix.
pub struct Factor<A: Arithmetic> {
    parts: Vec<Part<A>>,
    /// For updates and for the numbers of fronts.
    memory: Memory,
    instructions: Arch,
}

impl<A: Arithmetic> Factor<A> {
    /// Room for the factor of a matrix with these fronts.
    pub fn new(fronts: &Fronts) -> Self {
        let part = |(number, task): (usize, &Task)| {
            let mut room = [0; 3];
            for front in &fronts.list[task.fronts.clone()] {
                let [a, b] = A::room(front);
                let own = [a, b, 3 * front.bodies() + LANES];
                room = [0, 1, 2].map(|k| own[k].max(room[k]));
            }
            let work = vec![[0.0; 3]; task.places.len() + task.beyond.len()];
            let factor = A::new(fronts, task);
            Part { task: number, factor, updates: Vec::new(), work, room }
        };
        let parts = fronts.tasks.iter().enumerate().map(part).collect();
        Self { parts, memory: Memory::default(), instructions: Arch::new() }
    }

    /// Whether there is work for several threads.
    pub(crate) fn is_shared(&self) -> bool {
        self.parts.len() > 1
    }

    /// The factors of the tasks.
    pub fn parts(&self) -> impl Iterator<Item = &A> {
        self.parts.iter().map(|part| &part.factor)
    }

    /// Factorises, with the forward solve of a right side; whether all pivots can be eliminated.
    pub fn factorise(
        &mut self,
        fronts: &Fronts,
        values: Values<A::Pair>,
        right: Option<&[[f64; 3]]>,
    ) -> bool {
        let Self { parts, memory, instructions } = self;
        let shared = parts.len() > 1;
        let has_factor = upward(&fronts.sizes, parts, &|below, part| {
            let task = part.task;
            part.updates = memory.take(fronts.tasks[task].update_len.iter().sum());
            if let Some(right) = right {
                gather_below(fronts, right, below, part);
            }
            let solves = right.is_some();
            let mut room = memory.take(part.room.iter().sum());
            let work = Eliminate { fronts, values, part, below, room: &mut room, solves };
            let has_factor = dispatch(*instructions, shared, work);
            memory.give(room);
            let first_below = task - below.len();
            for other in &fronts.below[task] {
                memory.give(take(&mut below[other - first_below].updates));
            }
            has_factor
        });
        // Those of the roots, and of all tasks below one without a factor.
        for part in parts {
            memory.give(take(&mut part.updates));
        }
        has_factor
    }

    /// Forward solve with the last factor.
    pub fn forward(&mut self, fronts: &Fronts, right: &[[f64; 3]]) {
        let Self { parts, memory, instructions } = self;
        upward(&fronts.sizes, parts, &|below, part| {
            gather_below(fronts, right, below, part);
            instructions.dispatch(Solve { fronts, part, memory, backward: false });
            true
        });
    }

    /// Backward solve with the last factor, after the forward solve.
    pub(crate) fn backward(&mut self, fronts: &Fronts, x: &mut [[f64; 3]]) {
        let Self { parts, memory, instructions } = self;
        let pieces = split(x, fronts.tasks.iter().map(|task| task.places.clone()));
        let mut parts: Vec<_> = parts.iter_mut().zip(pieces).collect();
        downward(&fronts.sizes, &mut parts, None, &|above, (part, x)| {
            if let Some((above, _)) = above {
                let task = &fronts.tasks[part.task];
                let places = &fronts.beyond_above[task.beyond.clone()];
                for (x, place) in part.work[task.places.len()..].iter_mut().zip(places) {
                    *x = above.work[*place as usize];
                }
            }
            instructions.dispatch(Solve { fronts, part, memory, backward: true });
            x.copy_from_slice(&part.work[..x.len()]);
        });
    }
}

/// Sets the work of a task to the right side, with the contributions of the tasks below it one
/// after the other.
fn gather_below<A>(
    fronts: &Fronts,
    right: &[[f64; 3]],
    below: &[Part<A>],
    Part { task, work, .. }: &mut Part<A>,
) {
    let first_below = *task - below.len();
    let places = &fronts.tasks[*task].places;
    let (own, beyond) = work.split_at_mut(places.len());
    own.copy_from_slice(&right[places.clone()]);
    beyond.fill([0.0; 3]);
    for &other in &fronts.below[*task] {
        let of_other = &fronts.tasks[other];
        let contributions = &below[other - first_below].work[of_other.places.len()..];
        let at = &fronts.beyond_above[of_other.beyond.clone()];
        for (place, contribution) in at.iter().zip(contributions) {
            add_times(&mut work[*place as usize], 1.0, contribution);
        }
    }
}

/// Copies the numbers of the pivots and rows of a front to `local`.
#[inline(always)]
fn gather<'a>(at: At, work: &[[f64; 3]], local: &'a mut [f64]) -> &'a mut [f64] {
    let front = at.front;
    let (of_pivots, of_rows) = local.as_chunks_mut().0.split_at_mut(front.pivots.len());
    for (local, work) in of_pivots.iter_mut().zip(&work[front.pivots.clone()]) {
        *local = *work;
    }
    for (local, &row) in of_rows.iter_mut().zip(at.rows()) {
        *local = work[row as usize];
    }
    let padding = 3 * front.bodies();
    local[padding..padding + LANES].fill(0.0);
    &mut local[..padding + LANES]
}

/// Copies the first numbers of `local` to the work.
#[inline(always)]
fn store(work: &mut [[f64; 3]], local: &[f64]) {
    for (work, local) in work.iter_mut().zip(local.as_chunks().0) {
        *work = *local;
    }
}

/// Solves for the pivots of one front, and subtracts their contribution from its rows.
#[inline(always)]
fn solve_front<A: Arithmetic>(factor: &A, at: At, work: &mut [[f64; 3]], local: &mut [f64]) {
    let local = gather(at, work, local);
    factor.forward(at, local);
    store(&mut work[at.front.pivots.clone()], local);
    for (&row, value) in at.rows().iter().zip(local[at.front.width()..].as_chunks().0) {
        work[row as usize] = *value;
    }
}

/// Factorisation of a task.
struct Eliminate<'a, 'v, A: Arithmetic> {
    fronts: &'a Fronts,
    values: Values<'v, A::Pair>,
    part: &'a mut Part<A>,
    /// The other tasks of its subtrees.
    below: &'a [Part<A>],
    room: &'a mut [f64],
    /// Whether a forward solve goes with it.
    solves: bool,
}

impl<H: Share, A: Arithmetic> WithSimd for By<H, Eliminate<'_, '_, A>> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self(share, Eliminate { fronts, values, part, below, room, solves }) = self;
        let first_below = part.task - below.len();
        let of_task = &fronts.tasks[part.task];
        let (first, rest) = room.split_at_mut(part.room[0]);
        let (second, local) = rest.split_at_mut(part.room[1]);
        let Part { task, factor, updates, work, .. } = part;
        let (even, odd) = updates.split_at_mut(of_task.update_len[0]);
        for at in At::all(fronts, *task) {
            let front = at.front;
            let (mine, theirs) = if front.odd { (&mut *odd, &*even) } else { (&mut *even, &*odd) };
            let update_of = |child: usize| {
                let front = &fronts.list[child];
                if child >= of_task.fronts.start {
                    return &theirs[front.update..front.update + front.update_len()];
                }
                let other = fronts.task_of(child);
                let start =
                    front.update + if front.odd { fronts.tasks[other].update_len[0] } else { 0 };
                &below[other - first_below].updates[start..start + front.update_len()]
            };
            let update = &mut mine[front.update..front.update + front.update_len()];
            let [a, b] = A::room(front);
            let room = [&mut first[..a], &mut second[..b]];
            if !factor.eliminate(By(share, simd), at, values, update_of, update, room) {
                return false;
            }
            if solves {
                solve_front(factor, at, work, local);
            }
        }
        true
    }
}

/// Forward or backward solve of the work of a task.
struct Solve<'a, A> {
    fronts: &'a Fronts,
    part: &'a mut Part<A>,
    memory: &'a Memory,
    backward: bool,
}

impl<A: Arithmetic> WithSimd for Solve<'_, A> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { fronts, part, memory, backward } = self;
        let mut local = memory.take(part.room[2]);
        if backward {
            for at in At::all(fronts, part.task).rev() {
                let local = gather(at, &part.work, &mut local);
                part.factor.backward(at, local);
                store(&mut part.work[at.front.pivots.clone()], local);
            }
        } else {
            for at in At::all(fronts, part.task) {
                solve_front(&part.factor, at, &mut part.work, &mut local);
            }
        }
        memory.give(local);
    }
}
