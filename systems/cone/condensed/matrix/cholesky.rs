//! Cholesky factorisation of the fronts of a symmetric positive definite matrix.

use std::ops::Range;

use pulp::Simd;

use super::assembly::{Block, add_products, times};
use super::dense::{self, LANES, Triangle};
use super::factor::{Arithmetic, At, Values};
use super::fronts::{Front, Fronts, Task};
use super::packed;
use super::share::{By, Share};

/// The factor of a task.
pub struct Cholesky {
    /// Front by front, without the triangles of the pivots.
    factor: Vec<f64>,
    /// Diagonal blocks, in the order of elimination.
    triangles: Vec<Triangle>,
}

impl Arithmetic for Cholesky {
    /// Three columns of the body that is eliminated first.
    type Pair = Block;

    #[inline]
    fn add_pair<const F: usize>(
        block: &mut Self::Pair,
        [of_columns, of_rows]: [&[[f64; F]; 3]; 2],
        d: &[[f64; F]; F],
    ) {
        add_products(block, &times(of_columns, d), of_rows);
    }

    fn new(_: &Fronts, task: &Task) -> Self {
        let triangles = vec![[0.0; 6]; task.places.len()];
        Self { factor: vec![0.0; task.factor_len], triangles }
    }

    /// Its trapezoid, and the copy of it if it is large.
    fn room(front: &Front) -> [usize; 2] {
        [front.height() * front.width(), packed::packed_len(front)]
    }

    #[inline(always)]
    fn eliminate<'a, S: Simd>(
        &mut self,
        By(share, simd): By<impl Share, S>,
        at: At,
        values: Values<Self::Pair>,
        update_of: impl Fn(usize) -> &'a [f64],
        update: &mut [f64],
        [panel, packed]: [&mut [f64]; 2],
    ) -> bool {
        let front = at.front;
        let (height, width) = (front.height(), front.width());
        panel.fill(0.0);
        for (k, block) in at.of_pivots(values.bodies).iter().enumerate() {
            dense::add_block(panel, height, 3 * k * height + 3 * k, block);
        }
        for ([column, row], block) in at.of_pairs(values.pairs) {
            let start = 3 * *column as usize * height + 3 * *row as usize;
            dense::add_block(panel, height, start, block);
        }
        for (child, of_child, places) in at.children() {
            extend(panel, height, 0, update_of(child), places, 0..of_child.inside);
        }
        let triangles = &mut self.triangles[front.pivots.clone()];
        let kept = &mut self.factor[front.factor.clone()];
        if packed.is_empty() {
            if !dense::factorise(panel, height, triangles) {
                return false;
            }
            dense::keep(panel, height, front.bodies(), kept);
            dense::update(panel, height, width, front.bottom(), update);
        } else {
            if !packed::factorise(simd, share, panel, height, triangles, packed) {
                return false;
            }
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
