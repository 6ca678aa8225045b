//! The arithmetic of a large front, on a copy of its columns in chunks of rows.
//!
//! In a trapezoid the numbers of a sum lie a column apart, and with some hundred rows each is in a
//! memory page of its own. A chunk has [`CHUNK`] rows of all columns, one after the other. Sums and
//! their order are those of [`dense`](super::dense), and the results are equal byte by byte. Below
//! the pivots of a chunk the others do not depend on each other: several threads share them.

use pulp::{Simd, WithSimd};

use super::dense::{LANES, Triangle, divide, finish_block, kept_rows};
use super::fronts::Front;
use super::share::{Share, in_pieces};

/// Rows of a chunk: a multiple of three, so that no block of three rows is in two chunks.
const CHUNK: usize = 3 * LANES;

/// Minimum numbers of rows and of columns of a trapezoid for which the copy pays.
const MIN_SIZE: [usize; 2] = [240, 24];

/// Numbers in the copy of a front; 0 if it has none.
pub(crate) fn packed_len(front: &Front) -> usize {
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

/// A trapezoid and a part of its pivots: those of one chunk.
#[derive(Clone, Copy)]
struct Pivots<'a> {
    panel: &'a [f64],
    height: usize,
    /// Column of the first of them.
    first: usize,
}

impl Pivots<'_> {
    /// Three columns from `pivot` of a chunk of rows, less the products of the columns before them.
    #[inline(always)]
    fn block(self, pivot: usize, rows: usize, chunk: &[f64], other: &[f64]) -> [[f64; CHUNK]; 3] {
        let mut block = products(chunk, other, pivot % CHUNK, pivot);
        for (block, column) in
            block.iter_mut().zip(self.panel[pivot * self.height..].chunks_exact(self.height))
        {
            let column = &column[rows..];
            if let Some(column) = column.first_chunk::<CHUNK>() {
                for (sum, x) in block.iter_mut().zip(column) {
                    *sum = x - *sum;
                }
            } else {
                for (k, sum) in block.iter_mut().enumerate() {
                    *sum = column.get(k).map_or(0.0, |x| x - *sum);
                }
            }
        }
        block
    }

    /// Factorises the chunk of the pivots; whether it is positive definite.
    #[inline(always)]
    fn factorise(self, chunk: &mut [f64], triangles: &mut [Triangle]) -> bool {
        for (k, triangle) in triangles.iter_mut().enumerate() {
            let pivot = self.first + 3 * k;
            let mut block = self.block(pivot, self.first, chunk, chunk);
            if !finish_block(block.as_flattened_mut(), CHUNK, 3 * k, triangle) {
                return false;
            }
            chunk[CHUNK * pivot..CHUNK * (pivot + 3)].copy_from_slice(block.as_flattened());
        }
        true
    }
}

/// The columns of the pivots of a chunk in consecutive chunks below it.
struct Below<'a> {
    pivots: Pivots<'a>,
    triangles: &'a [Triangle],
    /// The chunk of the pivots.
    own: &'a [f64],
    /// The chunks, and the first row of the first of them.
    chunks: &'a mut [f64],
    row: usize,
}

impl WithSimd for Below<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { pivots, triangles, own, chunks, row } = self;
        for (c, chunk) in chunks.chunks_exact_mut(own.len()).enumerate() {
            for (k, triangle) in triangles.iter().enumerate() {
                let pivot = pivots.first + 3 * k;
                let mut block = pivots.block(pivot, row + CHUNK * c, chunk, own);
                divide(block.each_mut().map(<[f64; CHUNK]>::as_mut_slice), 0, triangle);
                chunk[CHUNK * pivot..CHUNK * (pivot + 3)].copy_from_slice(block.as_flattened());
            }
        }
    }
}

/// As [`dense::factorise`](super::dense::factorise), into the copy. Threads of the pool help, as
/// `share` says.
#[inline(always)]
pub fn factorise<S: Simd>(
    simd: S,
    share: impl Share,
    panel: &[f64],
    height: usize,
    triangles: &mut [Triangle],
    packed: &mut [f64],
) -> bool {
    let chunk_len = CHUNK * 3 * triangles.len();
    for (number, triangles) in triangles.chunks_mut(CHUNK / 3).enumerate() {
        let pivots = Pivots { panel, height, first: CHUNK * number };
        let (before, below) = packed.split_at_mut((number + 1) * chunk_len);
        let own = &mut before[number * chunk_len..];
        if !pivots.factorise(own, triangles) {
            return false;
        }
        let (own, triangles) = (&*own, &*triangles);
        let work = CHUNK * CHUNK * (pivots.first + CHUNK / 2);
        in_pieces(simd, share, below, chunk_len, work, |first, chunks| {
            let row = CHUNK * (number + 1 + first);
            Below { pivots, triangles, own, chunks, row }
        });
    }
    true
}

/// As [`dense::keep`](super::dense::keep), from the copy.
#[inline(always)]
pub fn keep(packed: &[f64], width: usize, bodies: usize, mut kept: &mut [f64]) {
    for column in 0..width {
        let rows = kept_rows(bodies, column / 3);
        let (mut out, rest) = std::mem::take(&mut kept).split_at_mut(rows);
        kept = rest;
        let mut row = column - column % 3 + 3;
        while !out.is_empty() {
            let start = row / CHUNK * CHUNK * width + CHUNK * column + row % CHUNK;
            let len = (CHUNK - row % CHUNK).min(out.len());
            let (piece, rest) = out.split_at_mut(len);
            piece.copy_from_slice(&packed[start..start + len]);
            (out, row) = (rest, row + len);
        }
    }
}

/// Consecutive blocks of three columns of an update.
struct Update<'a> {
    packed: &'a [f64],
    width: usize,
    bottom: usize,
    first: usize,
    blocks: &'a mut [f64],
}

impl WithSimd for Update<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { packed, width, bottom, first, blocks } = self;
        let chunk_len = CHUNK * width;
        let first_chunk = (width + 3 * first) / CHUNK;
        for (c, chunk) in packed.chunks_exact(chunk_len).enumerate().skip(first_chunk) {
            let from = (CHUNK * c).saturating_sub(width);
            let skipped = (width + from) - CHUNK * c;
            let to = (CHUNK * (c + 1) - width).min(bottom);
            let within = blocks.chunks_exact_mut(3 * bottom);
            for (k, block) in within.take(to.div_ceil(3).saturating_sub(first)).enumerate() {
                let row = width + 3 * (first + k);
                let sums = products(chunk, &packed[row / CHUNK * chunk_len..], row % CHUNK, width);
                for (sums, column) in sums.iter().zip(block.chunks_exact_mut(bottom)) {
                    for (x, sum) in column[from..to].iter_mut().zip(&sums[skipped..]) {
                        *x = -sum;
                    }
                }
            }
        }
    }
}

/// As [`dense::update`](super::dense::update), from the copy of `width` columns.
#[inline(always)]
pub fn update<S: Simd>(
    simd: S,
    share: impl Share,
    packed: &[f64],
    width: usize,
    bottom: usize,
    out: &mut [f64],
) {
    if bottom == 0 {
        return;
    }
    // A block has half of its rows on average.
    let work = 3 * width * bottom / 2;
    in_pieces(simd, share, out, 3 * bottom, work, |first, blocks| Update {
        packed,
        width,
        bottom,
        first,
        blocks,
    });
}

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::super::dense;
    use super::super::share::Alone;
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

            let mut kept = vec![0.0; (0..pivots).map(|k| 3 * kept_rows(pivots + rows, k)).sum()];
            dense::keep(&panel, height, pivots + rows, &mut kept);
            for shared in [false, true] {
                let mut other_triangles = vec![[0.0; 6]; pivots];
                let mut copy = vec![f64::NAN; height.next_multiple_of(CHUNK) * width];
                let mut chunked = vec![0.0; bottom * 3 * rows];
                let (triangles_of_copy, simd) = (&mut other_triangles, pulp::Scalar::new());
                if shared {
                    let share = Arch::new();
                    assert!(factorise(simd, share, &matrix, height, triangles_of_copy, &mut copy));
                    update(simd, share, &copy, width, bottom, &mut chunked);
                } else {
                    assert!(factorise(simd, Alone, &matrix, height, triangles_of_copy, &mut copy));
                    update(simd, Alone, &copy, width, bottom, &mut chunked);
                }
                assert_eq!(triangles, other_triangles);
                let mut kept_of_copy = vec![0.0; kept.len()];
                keep(&copy, width, pivots + rows, &mut kept_of_copy);
                assert_eq!(kept, kept_of_copy);
                for j in 0..3 * rows {
                    let lower = j * bottom + j..j * bottom + 3 * rows;
                    assert_eq!(plain[lower.clone()], chunked[lower]);
                }
            }
        }
    }
}
