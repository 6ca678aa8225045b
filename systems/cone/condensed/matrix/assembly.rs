//! Adds blocks of bodies and pairs to the values of the matrix.

use super::cholesky::{DIAGONAL, PAIR};
use crate::condensed::images::Images;

/// Place of a pair (a, b) in the values of the matrix.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairPlace {
    /// Start of its block: three columns of three rows.
    pub start: usize,
    /// Whether columns belong to a, and rows to b.
    pub forward: bool,
    /// The places of its bodies.
    pub bodies: [u32; 2],
}

/// Values to add to: those of a branch, so that threads can add to several branches at once, or
/// all.
pub struct Assembly<'a> {
    pub(super) values: &'a mut [f64],
    /// Start of these values among all.
    pub(super) first: usize,
    pub(super) diagonal: &'a [usize],
    pub(super) pairs: &'a [PairPlace],
    pub(super) images: &'a Images,
}

impl Assembly<'_> {
    /// Adds to the diagonal at degree of freedom `k` of a body: 0 and 1 are translations, 2 is the
    /// rotation.
    #[inline]
    pub fn add_diagonal(&mut self, body: usize, k: usize, value: f64) {
        self.values[self.diagonal[body] - self.first + [0, 3, 5][k]] += value;
    }

    /// Adds `G D G'` of a pair. `G` has `F` columns, in the rows of its two bodies in the order of
    /// the pair in the pattern. `D` is symmetric. With an image as the second body the cell takes
    /// part too.
    #[inline]
    pub fn add<const F: usize>(
        &mut self,
        pair: usize,
        rows: &[[[f64; F]; 3]; 2],
        d: &[[f64; F]; F],
    ) {
        if let Some((image, with_cell)) = self.images.at(pair) {
            self.add_with_cell(pair, with_cell, image, rows, d);
            return;
        }
        for (rows, body) in rows.iter().zip(self.pairs[pair].bodies) {
            self.add_body(body, rows, d);
        }
        self.add_pair(pair, [&rows[0], &rows[1]], d);
    }

    #[cold]
    fn add_with_cell<const F: usize>(
        &mut self,
        pair: usize,
        with_cell: usize,
        image: usize,
        rows: &[[[f64; F]; 3]; 2],
        d: &[[f64; F]; F],
    ) {
        let (of_b, of_cell) = self.images.rows(image, &rows[1]);
        let [a, b] = self.pairs[pair].bodies;
        let [_, cell] = self.pairs[with_cell].bodies;
        for (rows, body) in [(&rows[0], a), (&of_b, b), (&of_cell, cell)] {
            self.add_body(body, rows, d);
        }
        self.add_pair(pair, [&rows[0], &of_b], d);
        self.add_pair(with_cell, [&rows[0], &of_cell], d);
        self.add_pair(with_cell + 1, [&of_b, &of_cell], d);
    }

    #[inline]
    fn add_body<const F: usize>(&mut self, body: u32, rows: &[[f64; F]; 3], d: &[[f64; F]; F]) {
        let left = times(rows, d);
        let start = self.diagonal[body as usize] - self.first;
        let block = &mut self.values[start..start + DIAGONAL];
        for (k, (c, r)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate()
        {
            block[k] += dot(&left[c], &rows[r]);
        }
    }

    #[inline]
    fn add_pair<const F: usize>(
        &mut self,
        pair: usize,
        rows: [&[[f64; F]; 3]; 2],
        d: &[[f64; F]; F],
    ) {
        let PairPlace { start, forward, .. } = self.pairs[pair];
        let [of_columns, of_rows] = if forward { [0, 1] } else { [1, 0] };
        let left = times(rows[of_columns], d);
        let start = start - self.first;
        let block = &mut self.values[start..start + PAIR];
        for (left, column) in left.iter().zip(block.chunks_exact_mut(3)) {
            for (value, row) in column.iter_mut().zip(rows[of_rows]) {
                *value += dot(left, row);
            }
        }
    }
}

#[inline]
fn dot<const F: usize>(x: &[f64; F], y: &[f64; F]) -> f64 {
    let mut sum = 0.0;
    for f in 0..F {
        sum += x[f] * y[f];
    }
    sum
}

#[inline]
fn times<const F: usize>(rows: &[[f64; F]; 3], d: &[[f64; F]; F]) -> [[f64; F]; 3] {
    let mut out = [[0.0; F]; 3];
    for (out, row) in out.iter_mut().zip(rows) {
        for f in 0..F {
            for g in 0..F {
                out[f] += row[g] * d[g][f];
            }
        }
    }
    out
}
