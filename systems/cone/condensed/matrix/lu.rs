//! Dense arithmetic on one unsymmetric front: LU factorisation of its first columns, its update,
//! and the triangular solves.
//!
//! A front is a square of `height` rows, stored row by row with room for padding to [`LANES`]. Rows
//! are exchanged among the pivots of the front only, so that the rows of a front do not depend on
//! the values.
//!
//! All functions are inlined into a caller that is compiled for the instructions of the machine
//! (`pulp`). The order of every sum is fixed, and fused multiplications are explicit.

use pulp::{Simd, WithSimd};

use super::dense::LANES;
use super::share::{Share, in_pieces};

/// A pivot stays on the diagonal if it is at least this part of the maximum of its column among the
/// pivots of the front.
const THRESHOLD: f64 = 0.1;
/// Number of pivots whose rows are subtracted from the rows below in one pass.
const TOGETHER: usize = 4;

/// Numbers in a row with room for padding.
pub fn row_len(height: usize) -> usize {
    height.next_multiple_of(LANES)
}

/// Subtracts `factor` times a row from another.
#[inline(always)]
fn take_away(row: &mut [f64], other: &[f64], factor: f64) {
    for (x, y) in row.iter_mut().zip(other) {
        *x = (-factor).mul_add(*y, *x);
    }
}

/// Two different rows.
#[inline(always)]
fn two_rows(front: &mut [f64], len: usize, upper: usize, lower: usize) -> (&mut [f64], &mut [f64]) {
    let (before, after) = front.split_at_mut(lower * len);
    (&mut before[upper * len..(upper + 1) * len], &mut after[..len])
}

/// Factorises the first `width` columns, `P A = L U` with a unit diagonal in L, and leaves the
/// update in the remaining square. `exchanged[k]` is the row with which row k was exchanged.
/// Returns the sign of the determinant of the pivots, or 0 if a pivot is zero or not finite. Threads
/// of the pool help below the pivots, as `share` says.
#[inline(always)]
pub fn factorise<S: Simd>(
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
            let (upper, lower) = two_rows(front, len, k, best.1);
            upper.swap_with_slice(lower);
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

/// Forward solve in place: `x` has the numbers of the pivots and of the rows.
#[inline(always)]
pub fn forward(lower: &[f64], width: usize, exchanged: &[u32], x: &mut [f64]) {
    for (k, other) in exchanged.iter().enumerate() {
        x.swap(k, *other as usize);
    }
    let (own, below) = x.split_at_mut(width);
    for (i, row) in lower.chunks_exact(width).take(width).enumerate() {
        let mut sum = own[i];
        for (l, y) in row[..i].iter().zip(&own[..i]) {
            sum = (-l).mul_add(*y, sum);
        }
        own[i] = sum;
    }
    for (x, row) in below.iter_mut().zip(lower[width * width..].chunks_exact(width)) {
        let mut sum = *x;
        for (l, y) in row.iter().zip(&*own) {
            sum = (-l).mul_add(*y, sum);
        }
        *x = sum;
    }
}

/// Backward solve in place: `x` has the numbers of the pivots and the solution of the rows.
#[inline(always)]
pub fn backward(upper: &[f64], height: usize, x: &mut [f64]) {
    for (i, row) in upper.chunks_exact(height).enumerate().rev() {
        let (own, solved) = x.split_at_mut(i + 1);
        let mut sum = own[i];
        for (u, y) in row[i + 1..].iter().zip(&*solved) {
            sum = (-u).mul_add(*y, sum);
        }
        own[i] = sum / row[i];
    }
}

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::super::share::Alone;
    use super::*;

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
        forward(&square, 3, &exchanged, &mut x);
        backward(&square, 3, &mut x);
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
