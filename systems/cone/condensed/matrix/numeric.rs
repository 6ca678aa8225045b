//! The factorisation and the solves, front by front.
//!
//! For every front: the trapezoid is assembled from the values of the matrix and the updates of its
//! children, factorised, and leaves an update for the parent. The forward solve of the first right
//! side is done front by front too, while the factor is in the cache.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::dense::{self, LANES, Triangle};
use super::fronts::{Branch, Front, Fronts};
use super::packed;
use super::pattern::{DIAGONAL, PAIR, Pattern};

/// The numbers of a branch, or of the trunk.
pub struct Part {
    /// Its factor, front by front.
    factor: Vec<f64>,
    /// Its diagonal blocks, in the order of elimination.
    triangles: Vec<Triangle>,
    /// Updates that wait for the parents of their fronts: of fronts in even and in odd depth.
    updates: [Vec<f64>; 2],
    /// The trapezoid of one front, and its copy if it is large.
    panel: Vec<f64>,
    packed: Vec<f64>,
    /// Right side and solution of its bodies. In a branch the bodies of the trunk follow: the
    /// branch adds to their right side and needs their solution.
    pub work: Vec<[f64; 3]>,
    /// Right side and solution of one front.
    front_work: Vec<f64>,
}

impl Part {
    /// Room for a branch, with `beyond` the number of bodies in the trunk, or for the trunk, with
    /// `beyond` = 0.
    pub fn new(fronts: &Fronts, branch: &Branch, beyond: usize) -> Self {
        let list = &fronts.list[branch.fronts.clone()];
        let maximum = |of: fn(&Front) -> usize| list.iter().map(of).max().unwrap_or(0);
        Self {
            factor: vec![0.0; branch.factor_len],
            triangles: vec![[0.0; 6]; branch.places.len()],
            updates: branch.update_len.map(|len| vec![0.0; len]),
            panel: vec![0.0; maximum(Front::panel_len)],
            packed: vec![0.0; maximum(packed::packed_len)],
            work: vec![[0.0; 3]; branch.places.len() + beyond],
            front_work: vec![0.0; 3 * maximum(Front::bodies) + LANES],
        }
    }

    fn update(&self, front: &Front) -> &[f64] {
        let start = front.update;
        &self.updates[usize::from(front.odd)][start..start + front.update_len()]
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

/// Factorisation of a branch, or of the trunk with its branches, and forward solve of its work;
/// whether it was positive definite.
pub struct Eliminate<'a> {
    pub pattern: &'a Pattern,
    /// Values of the whole matrix.
    pub values: &'a [f64],
    pub branch: &'a Branch,
    pub part: &'a mut Part,
    /// The branches, if this is the trunk.
    pub branches: &'a [Part],
}

impl WithSimd for Eliminate<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Self { pattern, values, branch, part, branches } = self;
        let fronts = &pattern.fronts;
        let Part { factor, triangles, updates, panel, packed, work, front_work } = part;
        let [even, odd] = updates;
        for number in branch.fronts.clone() {
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
                if child >= branch.fronts.start {
                    return &theirs[front.update..front.update + front.update_len()];
                }
                let before = fronts.branches.partition_point(|b| b.fronts.end <= child);
                branches[before].update(front)
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
                packed::factorise(panel, height, triangles, packed)
            };
            if !definite {
                return false;
            }
            let kept = &mut factor[front.factor.clone()];
            dense::keep(panel, height, front.bodies(), kept);
            let rows = &fronts.rows[front.rows.clone()];
            solve_front(front, rows, kept, triangles, work, front_work);
            let update = &mut mine[front.update..front.update + front.update_len()];
            if packed.is_empty() {
                dense::update(panel, height, width, front.bottom(), update);
            } else {
                packed::update(packed, width, front.bottom(), update);
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

/// Forward solve of the work with the last factor.
pub struct Forward<'a>(pub &'a Fronts, pub &'a Branch, pub &'a mut Part);

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(fronts, branch, Part { factor, triangles, work, front_work, .. }) = self;
        for front in &fronts.list[branch.fronts.clone()] {
            let rows = &fronts.rows[front.rows.clone()];
            let kept = &factor[front.factor.clone()];
            solve_front(front, rows, kept, &triangles[front.pivots.clone()], work, front_work);
        }
    }
}

/// Backward solve, from the last front to the first.
pub struct Backward<'a>(pub &'a Fronts, pub &'a Branch, pub &'a mut Part);

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(fronts, branch, Part { factor, triangles, work, front_work, .. }) = self;
        for front in fronts.list[branch.fronts.clone()].iter().rev() {
            let rows = &fronts.rows[front.rows.clone()];
            let local = gather(front, rows, work, front_work);
            let triangles = &triangles[front.pivots.clone()];
            dense::backward(&factor[front.factor.clone()], front.bodies(), triangles, local);
            store(&mut work[front.pivots.clone()], local);
        }
    }
}
