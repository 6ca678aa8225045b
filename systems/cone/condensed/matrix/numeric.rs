//! The factorisation and the solves, front by front.
//!
//! For every front: the trapezoid is assembled from the values of the matrix and the updates of its
//! children, factorised, and leaves an update for the parent. The forward solve of the first right
//! side is done front by front too, while the factor is in the cache.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::dense::{self, LANES, Triangle};
use super::fronts::{Front, Fronts, Task};
use super::packed;
use super::pattern::{DIAGONAL, PAIR, Pattern};
use super::share::{By, Share};
use super::updates;

/// The numbers of a task.
pub struct Part {
    /// Its factor, front by front.
    factor: Vec<f64>,
    /// Its diagonal blocks, in the order of elimination.
    triangles: Vec<Triangle>,
    /// Updates that wait for the parents of their fronts: of fronts in even depth, then in odd
    /// depth. Lent until the task above has taken them.
    updates: Vec<f64>,
    /// Right side and solution of its bodies, then of those beyond: the task adds to their right
    /// side and needs their solution.
    pub work: Vec<[f64; 3]>,
    /// Numbers that its fronts need in [`Current`], each at most.
    current: [usize; 3],
}

/// Numbers of the front that is being eliminated.
#[derive(Default)]
pub struct Current {
    /// Its trapezoid, and the copy of it if it is large.
    panel: Vec<f64>,
    packed: Vec<f64>,
    /// Its right side and solution.
    work: Vec<f64>,
}

impl Current {
    /// Makes room for all fronts of a task.
    fn fit(&mut self, lengths: [usize; 3]) {
        for (numbers, len) in
            [&mut self.panel, &mut self.packed, &mut self.work].into_iter().zip(lengths)
        {
            if numbers.len() < len {
                *numbers = vec![0.0; len];
            }
        }
    }
}

impl Part {
    /// Room for a task.
    pub fn new(fronts: &Fronts, task: usize) -> Self {
        let task = &fronts.tasks[task];
        let list = &fronts.list[task.fronts.clone()];
        let maximum = |of: fn(&Front) -> usize| list.iter().map(of).max().unwrap_or(0);
        Self {
            factor: vec![0.0; task.factor_len],
            triangles: vec![[0.0; 6]; task.places.len()],
            updates: Vec::new(),
            work: vec![[0.0; 3]; task.bodies()],
            current: [
                maximum(Front::panel_len),
                maximum(packed::packed_len),
                3 * maximum(Front::bodies) + LANES,
            ],
        }
    }

    fn update(&self, task: &Task, front: &Front) -> &[f64] {
        let start = front.update + if front.odd { task.update_len[0] } else { 0 };
        &self.updates[start..start + front.update_len()]
    }
}

impl updates::Part for Part {
    fn updates(&mut self) -> &mut Vec<f64> {
        &mut self.updates
    }

    fn update_len(&self, task: &Task) -> usize {
        task.update_len.iter().sum()
    }
}

/// Copies the numbers of the pivots and rows of a front to `local`.
#[inline(always)]
fn gather<'a>(
    front: &Front,
    rows: &[u32],
    work: &[[f64; 3]],
    local: &'a mut [f64],
) -> &'a mut [f64] {
    let (of_pivots, of_rows) = local.as_chunks_mut().0.split_at_mut(front.pivots.len());
    for (local, work) in of_pivots.iter_mut().zip(&work[front.pivots.clone()]) {
        *local = *work;
    }
    for (local, &row) in of_rows.iter_mut().zip(rows) {
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
fn solve_front(
    front: &Front,
    rows: &[u32],
    kept: &[f64],
    triangles: &[Triangle],
    work: &mut [[f64; 3]],
    local: &mut [f64],
) {
    let local = gather(front, rows, work, local);
    dense::forward(kept, front.bodies(), triangles, local);
    store(&mut work[front.pivots.clone()], local);
    for (&row, value) in rows.iter().zip(local[front.width()..].as_chunks().0) {
        work[row as usize] = *value;
    }
}

/// Factorisation of a task, and forward solve of its work; whether it was positive definite.
pub struct Eliminate<'a> {
    pub pattern: &'a Pattern,
    /// Values of the whole matrix.
    pub values: &'a [f64],
    pub task: usize,
    pub part: &'a mut Part,
    /// The other tasks of its subtrees.
    pub below: &'a [Part],
    pub current: &'a mut Current,
}

impl<H: Share> WithSimd for By<H, Eliminate<'_>> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self(share, Eliminate { pattern, values, task, part, below, current }) = self;
        let fronts = &pattern.fronts;
        let first_below = task - below.len();
        let own = fronts.tasks[task].fronts.clone();
        current.fit(part.current);
        let Current { panel, packed, work: front_work } = current;
        let Part { factor, triangles, updates, work, .. } = part;
        let (even, odd) = updates.split_at_mut(fronts.tasks[task].update_len[0]);
        for number in own.clone() {
            let front = &fronts.list[number];
            let (height, width) = (front.height(), front.width());
            let panel = &mut panel[..front.panel_len()];
            panel.fill(0.0);
            let (diagonal, blocks) =
                values[pattern.starts[number]..].split_at(DIAGONAL * front.pivots.len());
            for (k, block) in diagonal.as_chunks().0.iter().enumerate() {
                set_diagonal(panel, height, 3 * k, block);
            }
            let [first, end] = [number, number + 1].map(|k| pattern.target_starts[k]);
            let targets = &pattern.targets[first..end];
            for (&target, block) in targets.iter().zip(blocks.as_chunks().0) {
                add_block(panel, height, target as usize, block);
            }

            let (mine, theirs) = if front.odd { (&mut *odd, &*even) } else { (&mut *even, &*odd) };
            let children = &fronts.children[front.children.clone()];
            let update_of = |child: usize| {
                let front = &fronts.list[child];
                if child >= own.start {
                    return &theirs[front.update..front.update + front.update_len()];
                }
                let other = fronts.task_of(child);
                below[other - first_below].update(&fronts.tasks[other], front)
            };
            for child in children.iter().map(|c| *c as usize) {
                let (update, child) = (update_of(child), &fronts.list[child]);
                let places = &fronts.in_parent[child.rows.clone()];
                extend(panel, height, 0, update, places, 0..child.inside);
            }
            let triangles = &mut triangles[front.pivots.clone()];
            let packed = &mut packed[..packed::packed_len(front)];
            let definite = if packed.is_empty() {
                dense::factorise(panel, height, triangles)
            } else {
                packed::factorise(simd, share, panel, height, triangles, packed)
            };
            if !definite {
                return false;
            }
            let kept = &mut factor[front.factor.clone()];
            if packed.is_empty() {
                dense::keep(panel, height, front.bodies(), kept);
            } else {
                packed::keep(packed, width, front.bodies(), kept);
            }
            let rows = &fronts.rows[front.rows.clone()];
            solve_front(front, rows, kept, triangles, work, front_work);
            let update = &mut mine[front.update..front.update + front.update_len()];
            if packed.is_empty() {
                dense::update(panel, height, width, front.bottom(), update);
            } else {
                packed::update(simd, share, packed, width, front.bottom(), update);
            }
            for child in children.iter().map(|c| *c as usize) {
                let (of_child, child) = (update_of(child), &fronts.list[child]);
                let places = &fronts.in_parent[child.rows.clone()];
                extend(update, front.bottom(), width, of_child, places, child.inside..places.len());
            }
        }
        true
    }
}

#[inline(always)]
fn set_diagonal(panel: &mut [f64], height: usize, pivot: usize, block: &[f64; DIAGONAL]) {
    let columns = [&block[..3], &block[3..5], &block[5..]];
    for (c, values) in columns.into_iter().enumerate() {
        let start = (pivot + c) * height + pivot + c;
        panel[start..start + values.len()].copy_from_slice(values);
    }
}

#[inline(always)]
fn add_block(panel: &mut [f64], height: usize, target: usize, block: &[f64; PAIR]) {
    for (c, values) in block.as_chunks::<3>().0.iter().enumerate() {
        let start = target + c * height;
        for (x, value) in panel[start..start + 3].iter_mut().zip(values) {
            *x += value;
        }
    }
}

/// Adds the columns `which` of the update of a child, three each, to the trapezoid or the update of
/// its parent, whose columns have `height` rows and are counted from `first` on in `places`.
#[inline(always)]
fn extend(
    out: &mut [f64],
    height: usize,
    first: usize,
    update: &[f64],
    places: &[u32],
    which: Range<usize>,
) {
    let child_height = (3 * places.len()).next_multiple_of(LANES);
    for k in which {
        let rows = &places[k..];
        for c in 0..3 {
            let from = (3 * k + c) * child_height + 3 * k;
            let to = (places[k] as usize - first + c) * height;
            let (from, to) = (&update[from..], &mut out[to..to + height]);
            for (row, values) in rows.iter().zip(from.as_chunks::<3>().0) {
                let row = *row as usize - first;
                for (x, value) in to[row..row + 3].iter_mut().zip(values) {
                    *x += value;
                }
            }
        }
    }
}

/// Forward solve of the work of a task with the last factor.
pub struct Forward<'a>(pub &'a Fronts, pub usize, pub &'a mut Part, pub &'a mut Current);

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(fronts, task, part, current) = self;
        current.fit(part.current);
        let Part { factor, triangles, work, .. } = part;
        let list = &fronts.list[fronts.tasks[task].fronts.clone()];
        for front in list {
            let rows = &fronts.rows[front.rows.clone()];
            let kept = &factor[front.factor.clone()];
            let triangles = &triangles[front.pivots.clone()];
            solve_front(front, rows, kept, triangles, work, &mut current.work);
        }
    }
}

/// Backward solve of a task, from its last front to the first.
pub struct Backward<'a>(pub &'a Fronts, pub usize, pub &'a mut Part, pub &'a mut Current);

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(fronts, task, part, current) = self;
        current.fit(part.current);
        let Part { factor, triangles, work, .. } = part;
        let list = &fronts.list[fronts.tasks[task].fronts.clone()];
        for front in list.iter().rev() {
            let rows = &fronts.rows[front.rows.clone()];
            let local = gather(front, rows, work, &mut current.work);
            let triangles = &triangles[front.pivots.clone()];
            dense::backward(&factor[front.factor.clone()], front.bodies(), triangles, local);
            store(&mut work[front.pivots.clone()], local);
        }
    }
}
