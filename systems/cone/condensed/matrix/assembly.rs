//! Adds blocks of bodies and pairs to the values of a matrix.

use super::factor::Arithmetic;
use super::layout::PairPlace;
use crate::condensed::images::Images;
use crate::condensed::scaled::Scaled;

/// Three rows of three numbers: what a body or a pair has in the matrix.
pub type Block = [f64; 9];

/// Places of the diagonal in the block of a body.
pub(super) const DIAGONAL: [usize; 3] = [0, 4, 8];

/// Values to add to: those of a branch, so that threads can add to several branches at once, or
/// all.
pub struct Assembly<'a, A: Arithmetic> {
    pub(super) bodies: &'a mut [Block],
    pub(super) pairs: &'a mut [A::Pair],
    /// Places of the first of these bodies and pairs among all.
    pub(super) first: [usize; 2],
    pub(super) places: &'a [PairPlace],
    pub(super) images: &'a Images,
}

impl<A: Arithmetic> Assembly<'_, A> {
    /// Adds to the diagonal at degree of freedom `k` of a body: 0 and 1 are translations, 2 is the
    /// rotation.
    #[inline]
    pub fn add_diagonal(&mut self, body: usize, k: usize, value: f64) {
        self.bodies[body - self.first[0]][DIAGONAL[k]] += value;
    }

    /// Adds the weights of a program and `extra` on free degrees of freedom, and 1 on fixed ones.
    pub(crate) fn add_weights(&mut self, program: &Scaled, extra: f64) {
        for (i, (free, weight)) in program.free.iter().zip(&program.weight).enumerate() {
            for k in 0..3 {
                self.add_diagonal(i, k, if free[k] { weight[k] + extra } else { 1.0 });
            }
        }
    }

    /// Adds `G D G'` of a pair. `G` has `F` columns, in the rows of its two bodies in the order of
    /// the pair in the pattern. With an image as the second body the cell takes part too.
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
        for (rows, body) in rows.iter().zip(self.places[pair].bodies) {
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
        let [a, b] = self.places[pair].bodies;
        let [_, cell] = self.places[with_cell].bodies;
        for (rows, body) in [(&rows[0], a), (&of_b, b), (&of_cell, cell)] {
            self.add_body(body, rows, d);
        }
        self.add_pair(pair, [&rows[0], &of_b], d);
        self.add_pair(with_cell, [&rows[0], &of_cell], d);
        self.add_pair(with_cell + 1, [&of_b, &of_cell], d);
    }

    #[inline]
    fn add_body<const F: usize>(&mut self, body: usize, rows: &[[f64; F]; 3], d: &[[f64; F]; F]) {
        add_products(&mut self.bodies[body - self.first[0]], &times(rows, d), rows);
    }

    #[inline]
    fn add_pair<const F: usize>(
        &mut self,
        pair: usize,
        [a, b]: [&[[f64; F]; 3]; 2],
        d: &[[f64; F]; F],
    ) {
        let PairPlace { place, bodies } = self.places[pair];
        let rows = if bodies[0] < bodies[1] { [a, b] } else { [b, a] };
        A::add_pair(&mut self.pairs[place - self.first[1]], rows, d);
    }
}

/// Adds the scalar products of the rows of two bodies to a block, row by row of the first.
#[inline]
pub(crate) fn add_products<const F: usize>(
    block: &mut Block,
    left: &[[f64; F]; 3],
    rows: &[[f64; F]; 3],
) {
    for (left, values) in left.iter().zip(block.as_chunks_mut::<3>().0) {
        for (value, row) in values.iter_mut().zip(rows) {
            *value += dot(left, row);
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

/// The rows times a matrix.
#[inline]
pub fn times<const F: usize>(rows: &[[f64; F]; 3], d: &[[f64; F]; F]) -> [[f64; F]; 3] {
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
