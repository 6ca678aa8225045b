//! The arithmetic of a large front, on a copy of its columns in chunks of rows.
//!
//! In a trapezoid the numbers of a sum lie a column apart, each in a memory page of its own if a
//! column has some hundred rows. A chunk has [`CHUNK`] rows of all columns, one after the other.
//! Sums and their order are those of [`dense`](super::dense), and so are the results, byte by byte.

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
