//! Cholesky factorisation of the fronts of a symmetric positive definite matrix.

use std::ops::Range;

use pulp::Simd;

use super::dense::{self, LANES, Triangle};
use super::factor::{Arithmetic, At};
use super::fronts::{Front, Fronts, Task};
use super::packed;
use super::share::{By, Share};

/// Numbers in a block of the diagonal (its lower triangle by columns) and of a pair.
pub const DIAGONAL: usize = 6;
pub const PAIR: usize = 9;

/// The fronts, and the places of their values.
pub struct Pattern {
    pub fronts: Fronts,
    /// Start of the values of each front.
    pub starts: Vec<usize>,
    /// Place of the block of each pair, in the order of the values, in the trapezoid of its front.
    pub targets: Vec<u32>,
    /// Start of the targets of each front.
    pub target_starts: Vec<usize>,
}

/// The factor of a task.
pub struct Cholesky {
    /// Front by front, without the triangles of the pivots.
    factor: Vec<f64>,
    /// Diagonal blocks, in the order of elimination.
    triangles: Vec<Triangle>,
    /// Numbers that its fronts need in [`Trapezoid`], each at most.
    current: [usize; 2],
}

/// Numbers of the front that is being eliminated: its trapezoid, and the copy of it if it is large.
#[derive(Default)]
pub struct Trapezoid {
    panel: Vec<f64>,
    packed: Vec<f64>,
}

impl Arithmetic for Cholesky {
    /// The places of the values, and the values.
    type Values<'a> = (&'a Pattern, &'a [f64]);
    type Current = Trapezoid;

    fn new(fronts: &Fronts, task: &Task) -> Self {
        let list = &fronts.list[task.fronts.clone()];
        let maximum = |of: fn(&Front) -> usize| list.iter().map(of).max().unwrap_or(0);
        Self {
            factor: vec![0.0; task.factor_len],
            triangles: vec![[0.0; 6]; task.places.len()],
            current: [maximum(Front::panel_len), maximum(packed::packed_len)],
        }
    }

    fn fit(&self, Trapezoid { panel, packed }: &mut Trapezoid) {
        for (numbers, len) in [panel, packed].into_iter().zip(self.current) {
            if numbers.len() < len {
                *numbers = vec![0.0; len];
            }
        }
    }

    #[inline(always)]
    fn eliminate<'a, S: Simd>(
        &mut self,
        By(share, simd): By<impl Share, S>,
        at: At,
        (pattern, values): Self::Values<'_>,
        update_of: impl Fn(usize) -> &'a [f64],
        update: &mut [f64],
        current: &mut Trapezoid,
    ) -> bool {
        let (front, number) = (at.front, at.number);
        let (height, width) = (front.height(), front.width());
        let panel = &mut current.panel[..front.panel_len()];
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
        for (child, of_child, places) in at.children() {
            extend(panel, height, 0, update_of(child), places, 0..of_child.inside);
        }
        let triangles = &mut self.triangles[front.pivots.clone()];
        let packed = &mut current.packed[..packed::packed_len(front)];
        let definite = if packed.is_empty() {
            dense::factorise(panel, height, triangles)
        } else {
            packed::factorise(simd, share, panel, height, triangles, packed)
        };
        if !definite {
            return false;
        }
        let kept = &mut self.factor[front.factor.clone()];
        if packed.is_empty() {
            dense::keep(panel, height, front.bodies(), kept);
            dense::update(panel, height, width, front.bottom(), update);
        } else {
            packed::keep(packed, width, front.bodies(), kept);
            packed::update(simd, share, packed, width, front.bottom(), update);
        }
        for (child, of_child, places) in at.children() {
            let outside = of_child.inside..places.len();
            extend(update, front.bottom(), width, update_of(child), places, outside);
        }
        true
    }

    #[inline(always)]
    fn forward(&self, At { front, .. }: At, local: &mut [f64]) {
        let (kept, triangles) =
            (&self.factor[front.factor.clone()], &self.triangles[front.pivots.clone()]);
        dense::forward(kept, front.bodies(), triangles, local);
    }

    #[inline(always)]
    fn backward(&self, At { front, .. }: At, local: &mut [f64]) {
        let (kept, triangles) =
            (&self.factor[front.factor.clone()], &self.triangles[front.pivots.clone()]);
        dense::backward(kept, front.bodies(), triangles, local);
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
