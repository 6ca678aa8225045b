//! LU factorisation of the fronts of an unsymmetric matrix.
//!
//! A front is a square of `height` rows, stored row by row with room for padding to [`LANES`]. Rows
//! are exchanged among the pivots of the front only, so that the rows of a front do not depend on
//! the values. As in [`dense`](super::dense) all functions are inlined into a caller that is compiled
//! for the instructions of the machine, and every sum has one order.

use pulp::{Simd, WithSimd};

use super::assembly::{Block, add_products, times};
use super::dense::{LANES, add_block};
use super::factor::{Arithmetic, At, Values};
use super::fronts::{Front, Fronts, Task};
use super::share::{By, Share, in_pieces};

/// A pivot stays on the diagonal if it is at least this part of the maximum of its column among the
/// pivots of the front.
const THRESHOLD: f64 = 0.1;
/// Number of pivots whose rows are subtracted from the rows below in one pass.
const TOGETHER: usize = 4;

/// The factor of a front.
struct OfFront {
    /// Columns of the pivots, row by row, of all rows.
    lower: Vec<f64>,
    /// Rows of the pivots, without padding.
    upper: Vec<f64>,
    /// The row with which the row of every pivot was exchanged.
    exchanged: Vec<u32>,
}

/// The factor of a task.
pub(crate) struct Lu {
    fronts: Vec<OfFront>,
    /// Sign of the determinant of the pivots; 0 if there is no factor.
    pub sign: f64,
}

impl OfFront {
    /// Forward solve in place: `x` has the numbers of the pivots and of the rows.
    #[inline(always)]
    fn forward(&self, x: &mut [f64]) {
        let width = self.exchanged.len();
        for (k, other) in self.exchanged.iter().enumerate() {
            x.swap(k, *other as usize);
        }
        let (own, below) = x.split_at_mut(width);
        let (of_pivots, of_rows) = self.lower.split_at(width * width);
        for (i, row) in of_pivots.chunks_exact(width).enumerate() {
            own[i] = less(own[i], &row[..i], &own[..i]);
        }
        for (x, row) in below.iter_mut().zip(of_rows.chunks_exact(width)) {
            *x = less(*x, row, own);
        }
    }

    /// Backward solve in place: `x` has the numbers of the pivots and the solution of the rows.
    #[inline(always)]
    fn backward(&self, height: usize, x: &mut [f64]) {
        for (i, row) in self.upper.chunks_exact(height).enumerate().rev() {
            let (own, solved) = x.split_at_mut(i + 1);
            own[i] = less(own[i], &row[i + 1..], solved) / row[i];
        }
    }
}

/// Rows of a front, three a body.
fn height(front: &Front) -> usize {
    3 * front.bodies()
}

/// Numbers in a row with room for padding.
fn row_len(height: usize) -> usize {
    height.next_multiple_of(LANES)
}

impl Arithmetic for Lu {
    /// Rows of the body that is eliminated first in columns of the other, then the transposed place.
    type Pair = [Block; 2];

    #[inline]
    fn add_pair<const F: usize>(
        block: &mut Self::Pair,
        [first, second]: [&[[f64; F]; 3]; 2],
        d: &[[f64; F]; F],
    ) {
        let [upper, lower] = block;
        add_products(upper, &times(first, d), second);
        add_products(lower, &times(second, d), first);
    }

    fn new(fronts: &Fronts, task: &Task) -> Self {
        let list = &fronts.list[task.fronts.clone()];
        let of_front = |front: &Front| OfFront {
            lower: vec![0.0; height(front) * front.width()],
            upper: vec![0.0; height(front) * front.width()],
            exchanged: vec![0; front.width()],
        };
        Self { fronts: list.iter().map(of_front).collect(), sign: 0.0 }
    }

    /// Its square.
    fn room(front: &Front) -> [usize; 2] {
        [height(front) * row_len(height(front)), 0]
    }

    #[inline(always)]
    fn eliminate<'a, S: Simd>(
        &mut self,
        By(share, simd): By<impl Share, S>,
        at: At,
        values: Values<Self::Pair>,
        update_of: impl Fn(usize) -> &'a [f64],
        update: &mut [f64],
        [square, _]: [&mut [f64]; 2],
    ) -> bool {
        let front = at.front;
        let (height, width) = (height(front), front.width());
        let len = row_len(height);
        square.fill(0.0);
        for (k, block) in at.of_pivots(values.bodies).iter().enumerate() {
            add_block(square, len, 3 * k * len + 3 * k, block);
        }
        for (rows, [upper, lower]) in at.of_pairs(values.pairs) {
            let [a, b] = rows.map(|row| 3 * row as usize);
            add_block(square, len, a * len + b, upper);
            add_block(square, len, b * len + a, lower);
        }
        for (child, _, places) in at.children().rev() {
            extend(square, len, update_of(child), places);
        }
        let OfFront { lower, upper, exchanged } = &mut self.fronts[at.within];
        let sign = factorise(simd, share, square, [height, width], exchanged);
        self.sign = if at.within == 0 { sign } else { self.sign * sign };
        if sign == 0.0 {
            return false;
        }
        for (out, row) in lower.chunks_exact_mut(width).zip(square.chunks_exact(len)) {
            out.copy_from_slice(&row[..width]);
        }
        for (out, row) in upper.chunks_exact_mut(height).zip(square.chunks_exact(len)) {
            out.copy_from_slice(&row[..height]);
        }
        let rows = square.chunks_exact(len).skip(width);
        for (out, row) in update.chunks_exact_mut((height - width).max(1)).zip(rows) {
            out.copy_from_slice(&row[width..height]);
        }
        true
    }

    #[inline(always)]
    fn forward(&self, at: At, local: &mut [f64]) {
        self.fronts[at.within].forward(local);
    }

    #[inline(always)]
    fn backward(&self, at: At, local: &mut [f64]) {
        self.fronts[at.within].backward(height(at.front), local);
    }
}

/// Adds the update of a child, whose bodies start at these `places`.
#[inline(always)]
fn extend(square: &mut [f64], len: usize, update: &[f64], places: &[u32]) {
    let rows = 3 * places.len();
    for (i, row) in update.chunks_exact(rows.max(1)).take(rows).enumerate() {
        let start = (places[i / 3] as usize + i % 3) * len;
        let out = &mut square[start..start + len];
        for (place, values) in places.iter().zip(row.as_chunks::<3>().0) {
            let place = *place as usize;
            for (x, value) in out[place..place + 3].iter_mut().zip(values) {
                *x += value;
            }
        }
    }
}

/// A number less the products of a row with what has been solved, one after the other.
#[inline(always)]
fn less(mut x: f64, row: &[f64], solved: &[f64]) -> f64 {
    for (l, y) in row.iter().zip(solved) {
        x = (-l).mul_add(*y, x);
    }
    x
}

/// Subtracts `factor` times a row from another.
#[inline(always)]
fn take_away(row: &mut [f64], other: &[f64], factor: f64) {
    for (x, y) in row.iter_mut().zip(other) {
        *x = (-factor).mul_add(*y, *x);
    }
}

/// Factorises the first `width` columns, `P A = L U` with a unit diagonal in L, and leaves the
/// update in the remaining square. `exchanged[k]` is the row with which row k was exchanged.
/// Returns the sign of the determinant of the pivots, or 0 if a pivot is zero or not finite. Threads
/// of the pool help below the pivots, as `share` says.
#[inline(always)]
fn factorise<S: Simd>(
    simd: S,
    share: impl Share,
    front: &mut [f64],
    [height, width]: [usize; 2],
    exchanged: &mut [u32],
) -> f64 {
    let len = row_len(height);
    let mut sign = 1.0;
    for k in 0..width {
        let mut best = (front[k * len + k].abs(), k);
        for i in k + 1..width {
            let size = front[i * len + k].abs();
            if size * THRESHOLD > best.0 || (best.1 != k && size > best.0) {
                best = (size, i);
            }
        }
        if !(best.0 > 0.0 && best.0 < f64::INFINITY) {
            return 0.0;
        }
        exchanged[k] = best.1 as u32;
        if best.1 != k {
            let (before, after) = front.split_at_mut(best.1 * len);
            before[k * len..(k + 1) * len].swap_with_slice(&mut after[..len]);
            sign = -sign;
        }
        let pivot = front[k * len + k];
        if pivot < 0.0 {
            sign = -sign;
        }
        let (before, after) = front.split_at_mut((k + 1) * len);
        let own = &before[k * len..];
        for row in after.chunks_exact_mut(len).take(width - k - 1) {
            let factor = row[k] / pivot;
            row[k] = factor;
            take_away(&mut row[k + 1..], &own[k + 1..], factor);
        }
    }
    let (pivots, rows) = front.split_at_mut(width * len);
    in_pieces(simd, share, rows, len, width * (height - width / 2), |_, rows| Below {
        pivots: &*pivots,
        rows,
        len,
        width,
    });
    sign
}

/// Rows below the pivots.
struct Below<'a> {
    pivots: &'a [f64],
    rows: &'a mut [f64],
    len: usize,
    width: usize,
}

impl WithSimd for Below<'_> {
    type Output = ();

    /// Eliminates the pivots in the rows.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { pivots, rows, len, width } = self;
        let inverse = |k: usize| 1.0 / pivots[k * len + k];
        for row in rows.chunks_exact_mut(len) {
            let (factors, row) = row.split_at_mut(width);
            for k in 0..width {
                let factor = factors[k] * inverse(k);
                factors[k] = factor;
                let of_pivot = &pivots[k * len + k + 1..k * len + width];
                take_away(&mut factors[k + 1..], of_pivot, factor);
            }
            let mut k = 0;
            while k + TOGETHER <= width {
                let of = |j: usize| &pivots[(k + j) * len + width..(k + j + 1) * len];
                let [a, b, c, d] = [factors[k], factors[k + 1], factors[k + 2], factors[k + 3]];
                let rows = of(0).iter().zip(of(1)).zip(of(2)).zip(of(3));
                for (x, (((p, q), r), s)) in row.iter_mut().zip(rows) {
                    *x -= a.mul_add(*p, b.mul_add(*q, c.mul_add(*r, d * *s)));
                }
                k += TOGETHER;
            }
            for k in k..width {
                take_away(row, &pivots[k * len + width..(k + 1) * len], factors[k]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use pulp::Arch;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::super::share::Alone;
    use super::super::{PairPlace, UnsymmetricMatrix};
    use super::*;

    /// On a random unsymmetric matrix of a random graph, solution and sign of the determinant are
    /// those of a dense LU factorisation with pivoting.
    #[test]
    fn solves_as_a_dense_factorisation_does() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut uniform = move || random.next_u32() as f64 / f64::from(u32::MAX) - 0.5;
        for bodies in [1, 2, 7, 40] {
            let mut pairs = Vec::new();
            for a in 0..bodies {
                for b in a + 1..bodies {
                    if b == a + 1 || uniform() > 0.4 {
                        pairs.push((a as u32, b as u32));
                    }
                }
            }
            for _ in 0..20 {
                let mut matrix = UnsymmetricMatrix::new(bodies, &pairs);
                let order = matrix.order().to_vec();
                let n = 3 * bodies;
                let mut dense = DMatrix::<f64>::zeros(n, n);
                for (place, body) in order.iter().enumerate() {
                    for k in 0..3 {
                        let value = 0.1 * uniform();
                        matrix.assembly().add_diagonal(place, k, value);
                        dense[(3 * body + k, 3 * body + k)] += value;
                    }
                }
                for (number, (a, b)) in pairs.iter().enumerate() {
                    let mut block = || [0; 3].map(|_| [0; 3].map(|_| uniform()));
                    let (rows, t) = ([block(), block()], block());
                    matrix.assembly().add(number, &rows, &t);
                    let sides = [(*a as usize, rows[0]), (*b as usize, rows[1])];
                    for (x, of_x) in &sides {
                        for (y, of_y) in &sides {
                            for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                                for (f, g) in (0..9).map(|k| (k / 3, k % 3)) {
                                    dense[(3 * x + i, 3 * y + j)] +=
                                        of_x[i][f] * t[f][g] * of_y[j][g];
                                }
                            }
                        }
                    }
                }
                assert!(matrix.factorise());
                let factor = dense.lu();
                assert_eq!(matrix.sign(), factor.determinant().signum());
                let right: Vec<[f64; 3]> = (0..bodies).map(|_| [0; 3].map(|_| uniform())).collect();
                let column = DVector::from_column_slice(right.as_flattened());
                let expected = factor.solve(&column).expect("regular");
                let mut x: Vec<[f64; 3]> = order.iter().map(|body| right[*body]).collect();
                matrix.solve(&mut x);
                let scale = expected.amax();
                for (x, body) in x.iter().zip(&order) {
                    for k in 0..3 {
                        let difference = (x[k] - expected[3 * body + k]).abs();
                        assert!(difference <= 1e-7 * scale, "{difference:e} of {scale:e}");
                    }
                }
            }
        }
    }

    /// A graph with many tasks: solution and sign are the same bytes on any number of threads, and
    /// the residual is small.
    #[test]
    fn threads_change_no_byte() {
        let side = 60_u32;
        let bodies = (side * side) as usize;
        let pairs: Vec<(u32, u32)> = (0..side * side)
            .flat_map(|i| [(i, i + 1, i % side < side - 1), (i, i + side, i + side < side * side)])
            .filter_map(|(a, b, is_pair)| is_pair.then_some((a, b)))
            .collect();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut random = ChaCha8Rng::seed_from_u64(1);
                let mut uniform = move || random.next_u32() as f64 / f64::from(u32::MAX) - 0.5;
                let mut matrix = UnsymmetricMatrix::new(bodies, &pairs);
                assert!(matrix.fronts.tasks.len() > 20);
                for place in 0..bodies {
                    let mut values = matrix.assembly();
                    (0..3).for_each(|k| values.add_diagonal(place, k, 0.1 * uniform()));
                }
                for pair in 0..pairs.len() {
                    let mut block = || [0; 3].map(|_| [0; 3].map(|_| uniform()));
                    matrix.assembly().add(pair, &[block(), block()], &block());
                }
                assert!(matrix.factorise());
                let right: Vec<[f64; 3]> = (0..bodies).map(|_| [0; 3].map(|_| uniform())).collect();
                let mut x = right.clone();
                matrix.solve(&mut x);
                // The residual of the solution.
                let mut left = right;
                for (left, (x, block)) in left.iter_mut().zip(x.iter().zip(&matrix.bodies)) {
                    take_away(left, block, x);
                }
                for PairPlace { place, bodies: [a, b] } in &matrix.places {
                    let (a, b, blocks) = (*a.min(b), *a.max(b), &matrix.pairs[*place]);
                    take_away(&mut left[a], &blocks[0], &x[b]);
                    take_away(&mut left[b], &blocks[1], &x[a]);
                }
                let worst = left.as_flattened().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
                let size = x.as_flattened().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
                assert!(worst <= 1e-10 * size, "{worst:e} of {size:e}");
                // A matrix of zeros has no factor.
                let sign = matrix.sign();
                matrix.clear();
                assert!(!matrix.factorise() && matrix.sign() == 0.0);
                (x, sign)
            })
        };
        let one = on(1);
        assert!(one.1.abs() == 1.0);
        assert!(on(2) == one && on(5) == one);
    }

    fn take_away(left: &mut [f64; 3], block: &[f64], x: &[f64; 3]) {
        for (left, row) in left.iter_mut().zip(block.as_chunks::<3>().0) {
            *left -= row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
        }
    }

    /// A front without rows whose first pivot is zero: rows are exchanged, and the solution of
    /// `A x = b` and the sign of the determinant are those of the matrix.
    #[test]
    fn a_front_with_a_zero_pivot() {
        let matrix = [[0.0, 2.0, 1.0], [4.0, 1.0, 0.0], [2.0, 0.0, 3.0]];
        // Along the first row: -2 (4 * 3 - 0 * 2) + 1 (4 * 0 - 1 * 2) = -26.
        let mut front = vec![0.0; 3 * row_len(3)];
        for (row, values) in front.chunks_exact_mut(row_len(3)).zip(matrix) {
            row[..3].copy_from_slice(&values);
        }
        let mut exchanged = [0; 3];
        assert_eq!(factorise(pulp::Scalar::new(), Alone, &mut front, [3, 3], &mut exchanged), -1.0);
        let square: Vec<f64> =
            front.chunks_exact(row_len(3)).flat_map(|row| row[..3].to_vec()).collect();
        let expected = [1.0, -2.0, 3.0];
        let mut x = matrix.map(|row| (0..3).map(|k| row[k] * expected[k]).sum::<f64>());
        let front = OfFront { lower: square.clone(), upper: square, exchanged: exchanged.to_vec() };
        front.forward(&mut x);
        front.backward(3, &mut x);
        for (x, expected) in x.iter().zip(expected) {
            assert!((x - expected).abs() < 1e-14, "{x} {expected}");
        }
    }

    #[test]
    fn a_singular_front_has_no_sign() {
        let mut front = vec![1.0; 2 * row_len(2)];
        assert_eq!(factorise(pulp::Scalar::new(), Alone, &mut front, [2, 2], &mut [0; 2]), 0.0);
    }

    /// A front so large that threads share it has the same bytes as on one thread.
    #[test]
    fn a_shared_front_has_the_same_bytes() {
        let (height, width) = (300, 45);
        let len = row_len(height);
        let matrix: Vec<f64> = (0..height * len)
            .map(|k| if k / len == k % len { 300.0 } else { ((k * k) as f64).sin() })
            .collect();
        fn on(share: impl Share, matrix: &[f64], size: [usize; 2]) -> (f64, Vec<f64>, Vec<u32>) {
            let (mut front, mut exchanged) = (matrix.to_vec(), vec![0; size[1]]);
            let sign = factorise(pulp::Scalar::new(), share, &mut front, size, &mut exchanged);
            (sign, front, exchanged)
        }
        let size = [height, width];
        assert!(on(Arch::new(), &matrix, size) == on(Alone, &matrix, size));
    }
}
