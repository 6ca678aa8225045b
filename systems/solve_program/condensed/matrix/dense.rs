//! Dense arithmetic on one front: Cholesky factorisation of its trapezoid, its update, and the
//! triangular solves.
//!
//! A trapezoid lies column by column, `height` numbers each: rows of the pivots from the first on,
//! rows below from `top` on, both padded to [`LANES`]. What lies above the diagonal or in the
//! padding is zero, or never used. Diagonal blocks of three are kept apart. All functions are inlined into a caller that
//! is compiled for the instructions of the machine (`pulp`): loops over constant lengths become
//! vector instructions, and products and sums are fused.

use super::fronts::LANES;

/// Lower triangle of three, column by column, with the inverses of the numbers on its diagonal.
pub type Triangle = [f64; 6];

/// Sum over columns of what is in rows `i..i + R` times each of the three rows from `b` on.
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

/// Calls for rows `from..to`, multiples of [`LANES`], in pieces that fit into registers.
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

/// Takes what the columns before contribute away from rows of a block of three columns.
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
    [height, top, bottom]: [usize; 3],
    column: usize,
) {
    let sums = products::<R>(panel, height, top + i, column);
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
        let (x, rest) = block.split_at_mut(height);
        let (y, z) = rest.split_at_mut(height);
        let diagonal =
            [x[pivot], x[pivot + 1], x[pivot + 2], y[pivot + 1], y[pivot + 2], z[pivot + 2]];
        let Some(factor) = factor_of(diagonal) else { return false };
        *triangle = factor;
        let [xx, xy, xz, yy, yz, zz] = factor;
        let below = pivot + 3;
        for ((x, y), z) in x[below..].iter_mut().zip(&mut y[below..]).zip(&mut z[below..]) {
            *x *= xx;
            *y = (-xy).mul_add(*x, *y) * yy;
            *z = (-yz).mul_add(*y, (-xz).mul_add(*x, *z)) * zz;
        }
        for column in [x, y, z] {
            column[..below].fill(0.0);
        }
    }
    true
}

/// Cholesky factor of a symmetric block, whose lower triangle is given by columns.
#[inline(always)]
fn factor_of([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Option<Triangle> {
    if !(xx > 0.0) {
        return None;
    }
    let xx = 1.0 / xx.sqrt();
    let (xy, xz) = (xy * xx, xz * xx);
    let yy = yy - xy * xy;
    if !(yy > 0.0) {
        return None;
    }
    let yy = 1.0 / yy.sqrt();
    let yz = (yz - xz * xy) * yy;
    let zz = zz - xz * xz - yz * yz;
    (zz > 0.0).then(|| [xx, xy, xz, yy, yz, 1.0 / zz.sqrt()])
}

/// The update `-B B'`, with `B` the rows below the pivots.
#[inline(always)]
pub fn update(panel: &[f64], height: usize, top: usize, out: &mut [f64]) {
    let bottom = height - top;
    if bottom == 0 {
        return;
    }
    for (k, block) in out.chunks_exact_mut(3 * bottom).enumerate() {
        let from = 3 * k - 3 * k % LANES;
        let sizes = [height, top, bottom];
        in_pieces!(from, bottom, set_products(panel, block, sizes, top + 3 * k));
    }
}

/// Forward solve of one front: `x` has its pivots, and then zeros for what they take from the rows.
#[inline(always)]
pub fn forward(panel: &[f64], height: usize, triangles: &[Triangle], x: &mut [f64]) {
    for (k, (block, triangle)) in panel.chunks_exact(3 * height).zip(triangles).enumerate() {
        let pivot = 3 * k;
        let [xx, xy, xz, yy, yz, zz] = *triangle;
        let mut y = [x[pivot], x[pivot + 1], x[pivot + 2]];
        y[0] *= xx;
        y[1] = (y[1] - xy * y[0]) * yy;
        y[2] = (y[2] - xz * y[0] - yz * y[1]) * zz;
        x[pivot..pivot + 3].copy_from_slice(&y);
        for (x, columns) in rows_mut(x, pivot + 3).zip(block_rows(block, height, pivot + 3)) {
            for l in 0..LANES {
                let products = columns[1][l].mul_add(y[1], columns[2][l] * y[2]);
                x[l] -= columns[0][l].mul_add(y[0], products);
            }
        }
    }
}

/// Backward solve of one front: `x` has its pivots, and of its rows the solution.
#[inline(always)]
pub fn backward(panel: &[f64], height: usize, triangles: &[Triangle], x: &mut [f64]) {
    for (k, (block, triangle)) in panel.chunks_exact(3 * height).zip(triangles).enumerate().rev() {
        let pivot = 3 * k;
        let mut sums = [[0.0; LANES]; 3];
        for (x, columns) in rows(x, pivot + 3).zip(block_rows(block, height, pivot + 3)) {
            for (sums, column) in sums.iter_mut().zip(columns) {
                for l in 0..LANES {
                    sums[l] = column[l].mul_add(x[l], sums[l]);
                }
            }
        }
        let sums = sums.map(|[a, b, c, d]| (a + b) + (c + d));
        let [xx, xy, xz, yy, yz, zz] = *triangle;
        let mut y = [x[pivot] - sums[0], x[pivot + 1] - sums[1], x[pivot + 2] - sums[2]];
        y[2] *= zz;
        y[1] = (y[1] - yz * y[2]) * yy;
        y[0] = (y[0] - xy * y[1] - xz * y[2]) * xx;
        x[pivot..pivot + 3].copy_from_slice(&y);
    }
}

/// Rows from the piece on that `from` is in.
#[inline(always)]
fn rows(x: &[f64], from: usize) -> impl Iterator<Item = &[f64; LANES]> {
    x[from - from % LANES..].as_chunks().0.iter()
}

#[inline(always)]
fn rows_mut(x: &mut [f64], from: usize) -> impl Iterator<Item = &mut [f64; LANES]> {
    x[from - from % LANES..].as_chunks_mut().0.iter_mut()
}

/// The same of three columns.
#[inline(always)]
fn block_rows(
    block: &[f64],
    height: usize,
    from: usize,
) -> impl Iterator<Item = [&[f64; LANES]; 3]> {
    let (x, rest) = block.split_at(height);
    let (y, z) = rest.split_at(height);
    rows(x, from).zip(rows(y, from)).zip(rows(z, from)).map(|((x, y), z)| [x, y, z])
}
