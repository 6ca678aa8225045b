//! The multifrontal factorisation and the solves with its factor, task by task and front by front,
//! whatever the [arithmetic](Arithmetic) of a front is.
//!
//! For every front: its numbers are assembled from the values of the matrix and the updates of its
//! children, its pivots are eliminated, and an update is left for the parent. The forward solve of
//! the first right side is done front by front too, while the factor is in the cache.

use std::mem::take;

use pulp::{Arch, Simd, WithSimd};

use super::dense::LANES;
use super::fronts::{Front, Fronts, Task};
use super::schedule::{downward, upward};
use super::share::{By, Share, dispatch};
use crate::condensed::parallel::{Lent, split};

/// The factor of a task, and the arithmetic of its fronts. All functions are inlined into a caller
/// that is compiled for the instructions of the machine.
pub trait Arithmetic: Send + Sync {
    /// Values of the matrix, by front.
    type Values<'a>: Copy + Sync;
    /// Numbers of the front that is being eliminated.
    type Current: Default + Send;

    /// Room for the factor of a task.
    fn new(fronts: &Fronts, task: &Task) -> Self;

    /// Makes room for all fronts of the task.
    fn fit(&self, current: &mut Self::Current);

    /// Eliminates the pivots of a front, and sets its update; whether they can be eliminated.
    /// `update_of` has the updates of its children.
    fn eliminate<'a, S: Simd>(
        &mut self,
        by: By<impl Share, S>,
        at: At,
        values: Self::Values<'_>,
        update_of: impl Fn(usize) -> &'a [f64],
        update: &mut [f64],
        current: &mut Self::Current,
    ) -> bool;

    /// Forward solve of one front. `local` has the numbers of its pivots and rows, and [`LANES`]
    /// zeros.
    fn forward(&self, at: At, local: &mut [f64]);

    /// Backward solve of one front. `local` has the numbers of its pivots, the solution of its rows,
    /// and [`LANES`] zeros.
    fn backward(&self, at: At, local: &mut [f64]);
}

/// A front and its place.
#[derive(Clone, Copy)]
pub struct At<'a> {
    pub fronts: &'a Fronts,
    /// Its number among all, and within its task.
    pub number: usize,
    pub within: usize,
    pub front: &'a Front,
}

impl<'a> At<'a> {
    /// The fronts of a task.
    fn all(fronts: &'a Fronts, task: usize) -> impl DoubleEndedIterator<Item = Self> {
        let own = &fronts.tasks[task].fronts;
        let first = own.start;
        let list = fronts.list[own.clone()].iter().enumerate();
        list.map(move |(within, front)| Self { fronts, number: first + within, within, front })
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
    factor: A,
    /// Updates that wait for the parents of their fronts: of fronts in even depth, then in odd
    /// depth. Lent until the task above has taken them.
    updates: Vec<f64>,
    /// Right side and solution of its bodies, then of those beyond: the task adds to the right side
    /// of those, and needs their solution.
    work: Vec<[f64; 3]>,
    /// Length of the numbers of its largest front in a solve.
    local: usize,
}

/// Numbers of the front that is being eliminated, and its right side and solution.
#[derive(Default)]
struct Current<C> {
    numbers: C,
    local: Vec<f64>,
}

impl<C> Current<C> {
    fn fit(&mut self, local: usize) {
        if self.local.len() < local {
            self.local = vec![0.0; local];
        }
    }
}

/// The factor of a matrix.
pub struct Factor<A: Arithmetic> {
    parts: Vec<Part<A>>,
    current: Lent<Current<A::Current>>,
    updates: Lent<Vec<f64>>,
    instructions: Arch,
}

impl<A: Arithmetic> Factor<A> {
    /// Room for the factor of a matrix with these fronts.
    pub fn new(fronts: &Fronts) -> Self {
        let part = |task: &Task| {
            let bodies = fronts.list[task.fronts.clone()].iter().map(Front::bodies).max();
            Part {
                factor: A::new(fronts, task),
                updates: Vec::new(),
                work: vec![[0.0; 3]; task.bodies()],
                local: 3 * bodies.unwrap_or(0) + LANES,
            }
        };
        Self {
            parts: fronts.tasks.iter().map(part).collect(),
            current: Lent::default(),
            updates: Lent::default(),
            instructions: Arch::new(),
        }
    }

    /// Whether there is work for several threads.
    pub fn is_shared(&self) -> bool {
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
        values: A::Values<'_>,
        right: Option<&[[f64; 3]]>,
    ) -> bool {
        let Self { parts, current, updates, instructions } = self;
        let shared = parts.len() > 1;
        let has_factor = upward(&fronts.sizes, parts, &|task, below, part| {
            let of_task = &fronts.tasks[task];
            part.updates = updates.take(of_task.update_len.iter().sum());
            if let Some(right) = right {
                gather_below(fronts, task, right, below, &mut part.work);
            }
            let solves = right.is_some();
            let has_factor = current.with(|current| {
                let below = &*below;
                let work = Eliminate { fronts, values, task, part, below, current, solves };
                dispatch(*instructions, shared, work)
            });
            let first_below = task - below.len();
            for other in &fronts.below[task] {
                updates.give(take(&mut below[other - first_below].updates));
            }
            has_factor
        });
        // Those of the roots, and of all tasks below one without a factor.
        for part in parts {
            updates.give(take(&mut part.updates));
        }
        has_factor
    }

    /// Forward solve with the last factor.
    pub fn forward(&mut self, fronts: &Fronts, right: &[[f64; 3]]) {
        let Self { parts, current, instructions, .. } = self;
        upward(&fronts.sizes, parts, &|task, below, part| {
            gather_below(fronts, task, right, below, &mut part.work);
            current.with(|current| {
                instructions.dispatch(Solve { fronts, task, part, current, backward: false });
            });
            true
        });
    }

    /// Backward solve with the last factor, after the forward solve.
    pub fn backward(&mut self, fronts: &Fronts, x: &mut [[f64; 3]]) {
        let Self { parts, current, instructions, .. } = self;
        let pieces = split(x, fronts.tasks.iter().map(|task| task.places.clone()));
        let mut parts: Vec<_> = parts.iter_mut().zip(pieces).collect();
        downward(&fronts.sizes, &mut parts, &|task, above, (part, x)| {
            if let Some((above, _)) = above {
                let task = &fronts.tasks[task];
                let places = &fronts.beyond_above[task.beyond.clone()];
                for (x, place) in part.work[task.places.len()..].iter_mut().zip(places) {
                    *x = above.work[*place as usize];
                }
            }
            current.with(|current| {
                instructions.dispatch(Solve { fronts, task, part, current, backward: true });
            });
            x.copy_from_slice(&part.work[..x.len()]);
        });
    }
}

/// Sets the work of a task to the right side, with the contributions of the tasks below it one
/// after the other.
fn gather_below<A>(
    fronts: &Fronts,
    task: usize,
    right: &[[f64; 3]],
    below: &[Part<A>],
    work: &mut [[f64; 3]],
) {
    let first_below = task - below.len();
    let places = &fronts.tasks[task].places;
    let (own, beyond) = work.split_at_mut(places.len());
    own.copy_from_slice(&right[places.clone()]);
    beyond.fill([0.0; 3]);
    for &other in &fronts.below[task] {
        let of_other = &fronts.tasks[other];
        let contributions = &below[other - first_below].work[of_other.places.len()..];
        let at = &fronts.beyond_above[of_other.beyond.clone()];
        for (place, contribution) in at.iter().zip(contributions) {
            for (x, y) in work[*place as usize].iter_mut().zip(contribution) {
                *x += y;
            }
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
    values: A::Values<'v>,
    task: usize,
    part: &'a mut Part<A>,
    /// The other tasks of its subtrees.
    below: &'a [Part<A>],
    current: &'a mut Current<A::Current>,
    /// Whether a forward solve goes with it.
    solves: bool,
}

impl<H: Share, A: Arithmetic> WithSimd for By<H, Eliminate<'_, '_, A>> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self(share, Eliminate { fronts, values, task, part, below, current, solves }) = self;
        let first_below = task - below.len();
        let of_task = &fronts.tasks[task];
        current.fit(part.local);
        let Part { factor, updates, work, .. } = part;
        factor.fit(&mut current.numbers);
        let (even, odd) = updates.split_at_mut(of_task.update_len[0]);
        for at in At::all(fronts, task) {
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
            let by = By(share, simd);
            if !factor.eliminate(by, at, values, update_of, update, &mut current.numbers) {
                return false;
            }
            if solves {
                solve_front(factor, at, work, &mut current.local);
            }
        }
        true
    }
}

/// Forward or backward solve of the work of a task.
struct Solve<'a, A: Arithmetic> {
    fronts: &'a Fronts,
    task: usize,
    part: &'a mut Part<A>,
    current: &'a mut Current<A::Current>,
    backward: bool,
}

impl<A: Arithmetic> WithSimd for Solve<'_, A> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { fronts, task, part, current, backward } = self;
        current.fit(part.local);
        if !backward {
            for at in At::all(fronts, task) {
                solve_front(&part.factor, at, &mut part.work, &mut current.local);
            }
            return;
        }
        for at in At::all(fronts, task).rev() {
            let local = gather(at, &part.work, &mut current.local);
            part.factor.backward(at, local);
            store(&mut part.work[at.front.pivots.clone()], local);
        }
    }
}
