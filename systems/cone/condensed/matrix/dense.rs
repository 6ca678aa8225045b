//! Dense arithmetic on one front: Cholesky factorisation of its trapezoid, its update, and the
//! triangular solves.
//!
//! A trapezoid is computed column by column, with `height` numbers in each and room for padding to
//! [`LANES`]; its entries above the diagonal have no meaning. The factor is stored without that
//! room, because solves read all of it and memory bandwidth limits them: blocks of three columns,
//! each from the row below its pivots and padded at its end, and separately the triangles of the
//! pivots.
//!
//! All functions are inlined into a caller that is compiled for the instructions of the machine
//! (`pulp`): loops over constant lengths become vector instructions. The results do not depend on
//! these instructions, since the order of every sum is fixed and fused multiplications are
//! explicit. A machine without fused multiplication computes it in software, far more slowly.

use super::assembly::Block;

/// Rows are padded to a multiple of this, so that loops over them have no remainder.
pub(crate) const LANES: usize = 4;

/// Lower triangle of three, column by column, with the inverses of the numbers on its diagonal.
pub(crate) type Triangle = [f64; 6];

/// Adds a block of three lines of three numbers, from `start` on; lines are `len` apart.
#[inline(always)]
pub(crate) fn add_block(numbers: &mut [f64], len: usize, start: usize, block: &Block) {
    for (k, values) in block.as_chunks::<3>().0.iter().enumerate() {
        for (x, value) in numbers[start + k * len..][..3].iter_mut().zip(values) {
            *x += value;
        }
    }
}

/// Sum over columns of the rows `i..i + R` times each of the three rows from `b`.
#[inline(always)]
fn products<const R: usize>(columns: &[f64], height: usize, i: usize, b: usize) -> [[f64; R]; 3] {
    let mut sums = [[0.0; R]; 3];
    for column in columns.chunks_exact(height) {
        let rows = &column[i..i + R];
        for (sums, y) in sums.iter_mut().zip(&column[b..b + 3]) {
            for (sum, x) in sums.iter_mut().zip(rows) {
                *sum = x.mul_add(*y, *sum);
            }
        }
    }
    sums
}

/// Calls a function for rows `from..to`, multiples of [`LANES`], in pieces that fit into registers.
macro_rules! in_pieces {
    ($from:expr, $to:expr, $f:ident($($argument:expr),*)) => {
        let (mut i, to) = ($from, $to);
        while i + 3 * LANES <= to {
            $f::<{ 3 * LANES }>(i, $($argument),*);
            i += 3 * LANES;
        }
        if i + 2 * LANES <= to {
            $f::<{ 2 * LANES }>(i, $($argument),*);
        } else if i < to {
            $f::<LANES>(i, $($argument),*);
        }
    };
}

/// Subtracts the products of the preceding columns from rows of a block of three columns.
#[inline(always)]
fn take_away<const R: usize>(
    i: usize,
    before: &[f64],
    block: &mut [f64],
    height: usize,
    pivot: usize,
) {
    for (sums, column) in
        products::<R>(before, height, i, pivot).iter().zip(block.chunks_exact_mut(height))
    {
        for (x, sum) in column[i..i + R].iter_mut().zip(sums) {
            *x -= sum;
        }
    }
}

/// Sets rows of three columns of the update to minus the products.
#[inline(always)]
fn set_products<const R: usize>(
    i: usize,
    panel: &[f64],
    block: &mut [f64],
    [height, width, bottom]: [usize; 3],
    column: usize,
) {
    let sums = products::<R>(panel, height, width + i, column);
    for (sums, column) in sums.iter().zip(block.chunks_exact_mut(bottom)) {
        for (x, sum) in column[i..i + R].iter_mut().zip(sums) {
            *x = -sum;
        }
    }
}

/// Cholesky factorisation of a trapezoid, `A = L L'`; whether its upper part is positive definite.
#[inline(always)]
pub fn factorise(panel: &mut [f64], height: usize, triangles: &mut [Triangle]) -> bool {
    for (k, triangle) in triangles.iter_mut().enumerate() {
        let pivot = 3 * k;
        let (before, block) = panel.split_at_mut(pivot * height);
        let block = &mut block[..3 * height];
        if k > 0 {
            in_pieces!(pivot - pivot % LANES, height, take_away(before, block, height, pivot));
        }
        if !finish_block(block, height, pivot, triangle) {
            return false;
        }
    }
    true
}

/// Factorises three columns, after the products of the preceding columns have been subtracted.
#[inline(always)]
pub(crate) fn finish_block(
    block: &mut [f64],
    height: usize,
    pivot: usize,
    triangle: &mut Triangle,
) -> bool {
    let (x, rest) = block.split_at_mut(height);
    let (y, z) = rest.split_at_mut(height);
    let diagonal = [x[pivot], x[pivot + 1], x[pivot + 2], y[pivot + 1], y[pivot + 2], z[pivot + 2]];
    let Some(factor) = factor_of(diagonal) else { return false };
    *triangle = factor;
    divide([x, y, z], pivot + 3, triangle);
    true
}

/// Divides three columns, from the row `first` on, by their triangle.
#[inline(always)]
pub fn divide([x, y, z]: [&mut [f64]; 3], first: usize, triangle: &Triangle) {
    let [xx, xy, xz, yy, yz, zz] = *triangle;
    for ((x, y), z) in x[first..].iter_mut().zip(&mut y[first..]).zip(&mut z[first..]) {
        *x *= xx;
        *y = (-xy).mul_add(*x, *y) * yy;
        *z = (-yz).mul_add(*y, (-xz).mul_add(*x, *z)) * zz;
    }
}

/// Positive and finite.
#[inline(always)]
fn is_pivot(x: f64) -> bool {
    x > 0.0 && x < f64::INFINITY
}

/// Cholesky factor of a symmetric block, whose lower triangle is given by columns.
#[inline(always)]
fn factor_of([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Option<Triangle> {
    if !is_pivot(xx) {
        return None;
    }
    let xx = 1.0 / xx.sqrt();
    let (xy, xz) = (xy * xx, xz * xx);
    let yy = yy - xy * xy;
    if !is_pivot(yy) {
        return None;
    }
    let yy = 1.0 / yy.sqrt();
    let yz = (yz - xz * xy) * yy;
    let zz = zz - xz * xz - yz * yz;
    is_pivot(zz).then(|| [xx, xy, xz, yy, yz, 1.0 / zz.sqrt()])
}

/// The update `-B B'`, with `B` the rows of the trapezoid below its first `width`.
#[inline(always)]
pub fn update(panel: &[f64], height: usize, width: usize, bottom: usize, out: &mut [f64]) {
    if bottom == 0 {
        return;
    }
    for (k, block) in out.chunks_exact_mut(3 * bottom).enumerate() {
        let from = 3 * k - 3 * k % LANES;
        let sizes = [height, width, bottom];
        in_pieces!(from, bottom, set_products(panel, block, sizes, width + 3 * k));
    }
}

/// Number of stored rows of the block of a pivot, in a front with `bodies` pivots and rows.
pub(crate) fn kept_rows(bodies: usize, pivot: usize) -> usize {
    (3 * (bodies - 1 - pivot)).next_multiple_of(LANES)
}

/// Stores the part of a trapezoid below its pivots; `bodies` is the number of its pivots and rows.
#[inline(always)]
pub fn keep(panel: &[f64], height: usize, bodies: usize, mut kept: &mut [f64]) {
    for (k, block) in panel.chunks_exact(3 * height).enumerate() {
        let rows = kept_rows(bodies, k);
        let (out, rest) = std::mem::take(&mut kept).split_at_mut(3 * rows);
        kept = rest;
        if rows == 0 {
            continue;
        }
        for (out, column) in out.chunks_exact_mut(rows).zip(block.chunks_exact(height)) {
            let column = column[3 * k + 3..].as_chunks::<LANES>().0;
            for (out, values) in out.as_chunks_mut().0.iter_mut().zip(column) {
                *out = *values;
            }
        }
    }
}

/// Forward solve of one front with `bodies` pivots and rows: `x` has its pivots, its rows, and
/// padding.
#[inline(always)]
pub fn forward(mut kept: &[f64], bodies: usize, triangles: &[Triangle], x: &mut [f64]) {
    for (k, triangle) in triangles.iter().enumerate() {
        let (own, below) = x[3 * k..].split_at_mut(3);
        let [xx, xy, xz, yy, yz, zz] = *triangle;
        let y0 = own[0] * xx;
        let y1 = (own[1] - xy * y0) * yy;
        let y2 = (own[2] - xz * y0 - yz * y1) * zz;
        own.copy_from_slice(&[y0, y1, y2]);
        let (block, rest) = kept.split_at(3 * kept_rows(bodies, k));
        kept = rest;
        for (x, [a, b, c]) in below.as_chunks_mut::<LANES>().0.iter_mut().zip(pieces(block)) {
            for l in 0..LANES {
                x[l] -= a[l].mul_add(y0, b[l].mul_add(y1, c[l] * y2));
            }
        }
    }
}

/// Backward solve of one front: `x` has its pivots, the solution of its rows, and zeros for
/// padding.
#[inline(always)]
pub(crate) fn backward(mut kept: &[f64], bodies: usize, triangles: &[Triangle], x: &mut [f64]) {
    for (k, triangle) in triangles.iter().enumerate().rev() {
        let (own, below) = x[3 * k..].split_at_mut(3);
        let (rest, block) = kept.split_at(kept.len() - 3 * kept_rows(bodies, k));
        kept = rest;
        let mut sums = [[0.0; LANES]; 3];
        for (x, columns) in below.as_chunks::<LANES>().0.iter().zip(pieces(block)) {
            for (sums, column) in sums.iter_mut().zip(columns) {
                for l in 0..LANES {
                    sums[l] = column[l].mul_add(x[l], sums[l]);
                }
            }
        }
        let sums = sums.map(|[a, b, c, d]| (a + b) + (c + d));
        let [xx, xy, xz, yy, yz, zz] = *triangle;
        let y2 = (own[2] - sums[2]) * zz;
        let y1 = (own[1] - sums[1] - yz * y2) * yy;
        let y0 = (own[0] - sums[0] - xy * y1 - xz * y2) * xx;
        own.copy_from_slice(&[y0, y1, y2]);
    }
}

/// Rows of a block, piece by piece, of its three columns.
#[inline(always)]
fn pieces(block: &[f64]) -> impl Iterator<Item = [&[f64; LANES]; 3]> {
    let (x, rest) = block.split_at(block.len() / 3);
    let (y, z) = rest.split_at(block.len() / 3);
    let [x, y, z] = [x, y, z].map(|column| column.as_chunks().0.iter());
    x.zip(y).zip(z).map(|((x, y), z)| [x, y, z])
}
