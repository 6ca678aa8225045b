//! The arithmetic of a large front, on a copy of its columns in chunks of rows.
//!
//! In a trapezoid the numbers of a sum lie a column apart, and with some hundred rows each is in a
//! memory page of its own. A chunk has [`CHUNK`] rows of all columns, one after the other. Sums and
//! their order are those of [`dense`](super::dense), and the results are equal byte by byte.

use super::dense::{LANES, Triangle, finish_block};
use super::fronts::Front;

/// Rows of a chunk: a multiple of three, so that no block of three rows is in two chunks.
const CHUNK: usize = 3 * LANES;

/// Minimum numbers of rows and of columns of a trapezoid for which the copy pays.
const MIN_SIZE: [usize; 2] = [240, 24];

/// Numbers in the copy of a front; 0 if it has none.
pub fn packed_len(front: &Front) -> usize {
    let large = front.height() >= MIN_SIZE[0] && front.width() >= MIN_SIZE[1];
    if large { front.height().next_multiple_of(CHUNK) * front.width() } else { 0 }
}

/// Sum over the first columns of a chunk times three rows, from `row`, of another chunk.
#[inline(always)]
fn products(chunk: &[f64], other: &[f64], row: usize, columns: usize) -> [[f64; CHUNK]; 3] {
    let mut sums = [[0.0; CHUNK]; 3];
    let both = chunk.chunks_exact(CHUNK).zip(other.chunks_exact(CHUNK)).take(columns);
    for (rows, other) in both {
        for (sums, y) in sums.iter_mut().zip(&other[row..row + 3]) {
            for (sum, x) in sums.iter_mut().zip(rows) {
                *sum = x.mul_add(*y, *sum);
            }
        }
    }
    sums
}

/// As [`dense::factorise`](super::dense::factorise); also fills the copy.
#[inline(always)]
pub fn factorise(
    panel: &mut [f64],
    height: usize,
    triangles: &mut [Triangle],
    packed: &mut [f64],
) -> bool {
    let chunk_len = CHUNK * 3 * triangles.len();
    for ((k, block), triangle) in panel.chunks_exact_mut(3 * height).enumerate().zip(triangles) {
        let pivot = 3 * k;
        let first = pivot / CHUNK;
        let other = &packed[first * chunk_len..];
        for (c, chunk) in packed.chunks_exact(chunk_len).enumerate().skip(first) {
            let sums = products(chunk, other, pivot % CHUNK, pivot);
            for (sums, column) in sums.iter().zip(block.chunks_exact_mut(height)) {
                for (x, sum) in column[CHUNK * c..].iter_mut().zip(sums) {
                    *x -= sum;
                }
            }
        }
        if !finish_block(block, height, pivot, triangle) {
            return false;
        }
        for (c, chunk) in packed.chunks_exact_mut(chunk_len).enumerate().skip(first) {
            let columns = chunk[CHUNK * pivot..].chunks_exact_mut(CHUNK);
            for (copy, column) in columns.zip(block.chunks_exact(height)) {
                for (copy, x) in copy.iter_mut().zip(&column[CHUNK * c..]) {
                    *copy = *x;
                }
            }
        }
    }
    true
}

/// As [`dense::update`](super::dense::update), from the copy of `width` columns.
#[inline(always)]
pub fn update(packed: &[f64], width: usize, bottom: usize, out: &mut [f64]) {
    if bottom == 0 {
        return;
    }
    let chunk_len = CHUNK * width;
    for (c, chunk) in packed.chunks_exact(chunk_len).enumerate().skip(width / CHUNK) {
        let from = (CHUNK * c).saturating_sub(width);
        let skipped = (width + from) - CHUNK * c;
        let to = (CHUNK * (c + 1) - width).min(bottom);
        for (k, block) in out.chunks_exact_mut(3 * bottom).take(to.div_ceil(3)).enumerate() {
            let row = width + 3 * k;
            let sums = products(chunk, &packed[row / CHUNK * chunk_len..], row % CHUNK, width);
            for (sums, column) in sums.iter().zip(block.chunks_exact_mut(bottom)) {
                for (x, sum) in column[from..to].iter_mut().zip(&sums[skipped..]) {
                    *x = -sum;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::dense;
    use super::*;

    /// A trapezoid that is diagonally dominant, of a number of pivots and rows.
    fn trapezoid(pivots: usize, bodies: usize) -> (usize, Vec<f64>) {
        let height = (3 * bodies + LANES - 1).next_multiple_of(LANES);
        let mut panel = vec![0.0; 3 * pivots * height];
        for (k, column) in panel.chunks_exact_mut(height).enumerate() {
            for (i, x) in column.iter_mut().take(3 * bodies).enumerate() {
                *x = if i == k {
                    3.0 * bodies as f64
                } else {
                    ((i * i + k * k + i * k) as f64).sin()
                };
            }
        }
        (height, panel)
    }

    /// Entry of the factor: in the triangle of its pivot, or below it in the panel.
    fn entry(panel: &[f64], triangles: &[Triangle], height: usize, i: usize, j: usize) -> f64 {
        let triangle = &triangles[j / 3];
        match (i - 3 * (j / 3), j % 3) {
            (0, 0) => 1.0 / triangle[0],
            (1, 0) => triangle[1],
            (2, 0) => triangle[2],
            (1, 1) => 1.0 / triangle[3],
            (2, 1) => triangle[4],
            (2, 2) => 1.0 / triangle[5],
            (0..3, _) => 0.0,
            _ => panel[j * height + i],
        }
    }

    /// The factor times its transpose is the matrix: every entry is within gamma_(n+1) of its exact
    /// sum (Higham 2002, theorem 10.3).
    #[test]
    fn the_factor_of_a_trapezoid() {
        for (pivots, bodies) in [(1, 1), (1, 4), (2, 3), (5, 5), (4, 11)] {
            let (height, matrix) = trapezoid(pivots, bodies);
            let (mut panel, mut triangles) = (matrix.clone(), vec![[0.0; 6]; pivots]);
            assert!(dense::factorise(&mut panel, height, &mut triangles));
            for j in 0..3 * pivots {
                for i in j..3 * bodies {
                    let terms = (0..=j).map(|k| {
                        entry(&panel, &triangles, height, i, k)
                            * entry(&panel, &triangles, height, j, k)
                    });
                    let size: f64 = terms.clone().map(f64::abs).sum();
                    let sum: f64 = terms.sum();
                    // A few roundings more than the theorem: inverses of the diagonal, and this
                    // sum.
                    let bound = (2 * j + 8) as f64 * 0.5 * f64::EPSILON * size;
                    assert!(
                        (sum - matrix[j * height + i]).abs() <= bound,
                        "{pivots} {bodies} {i} {j}"
                    );
                }
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        let (height, mut panel) = trapezoid(3, 5);
        panel[4 * height + 4] = -1.0;
        assert!(!dense::factorise(&mut panel, height, &mut [[0.0; 6]; 3]));
    }

    /// Factor and update of a front that is copied into chunks are the same bytes as without the
    /// copy.
    #[test]
    fn a_copy_in_chunks_changes_no_byte() {
        for (pivots, rows) in [(8, 75), (9, 80), (21, 90)] {
            let (height, matrix) = trapezoid(pivots, pivots + rows);
            let (width, bottom) = (3 * pivots, (3 * rows).next_multiple_of(LANES));
            let (mut panel, mut triangles) = (matrix.clone(), vec![[0.0; 6]; pivots]);
            assert!(dense::factorise(&mut panel, height, &mut triangles));
            let mut plain = vec![0.0; bottom * 3 * rows];
            dense::update(&panel, height, width, bottom, &mut plain);

            let (mut other, mut other_triangles) = (matrix, vec![[0.0; 6]; pivots]);
            let mut copy = vec![0.0; height.next_multiple_of(CHUNK) * width];
            assert!(factorise(&mut other, height, &mut other_triangles, &mut copy));
            let mut chunked = vec![0.0; bottom * 3 * rows];
            update(&copy, width, bottom, &mut chunked);
            assert_eq!(triangles, other_triangles);
            for j in 0..width {
                let below = j * height + 3 * (j / 3) + 3..(j * height + 3 * (pivots + rows));
                assert_eq!(panel[below.clone()], other[below]);
            }
            for j in 0..3 * rows {
                let lower = j * bottom + j..j * bottom + 3 * rows;
                assert_eq!(plain[lower.clone()], chunked[lower]);
            }
        }
    }
}
