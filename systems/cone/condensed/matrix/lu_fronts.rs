//! LU factorisation of the fronts of an unsymmetric matrix.

use pulp::Simd;

use super::factor::{Arithmetic, At};
use super::fronts::{Front, Fronts, Task};
use super::layout::Placed;
use super::lu;
use super::share::{By, Share};

/// Numbers in the block of a body and in the two blocks of a pair.
pub const BODY: usize = 9;
pub const PAIR: usize = 18;

/// Values of the matrix.
#[derive(Clone, Copy)]
pub struct Values<'a> {
    /// Blocks of bodies by place, row by row.
    pub bodies: &'a [[f64; BODY]],
    /// Blocks of pairs: rows of the first body in columns of the second, then the transposed place.
    pub pairs: &'a [[f64; PAIR]],
    /// The pairs of every front.
    pub placed: &'a [Vec<Placed>],
}

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
pub struct Lu {
    fronts: Vec<OfFront>,
    /// First of its bodies.
    first: usize,
    /// Sign of the determinant of the pivots; 0 if there is no factor.
    pub sign: f64,
    /// Numbers of its highest front.
    square: usize,
}

/// Rows of a front, three a body.
fn height(front: &Front) -> usize {
    3 * front.bodies()
}

/// Numbers in the square of a front.
fn square(front: &Front) -> usize {
    height(front) * lu::row_len(height(front))
}

impl Arithmetic for Lu {
    type Values<'a> = Values<'a>;
    /// The square.
    type Current = Vec<f64>;

    fn new(fronts: &Fronts, task: &Task) -> Self {
        let list = &fronts.list[task.fronts.clone()];
        let of_front = |front: &Front| OfFront {
            lower: vec![0.0; height(front) * front.width()],
            upper: vec![0.0; height(front) * front.width()],
            exchanged: vec![0; front.width()],
        };
        Self {
            fronts: list.iter().map(of_front).collect(),
            first: task.places.start,
            sign: 0.0,
            square: list.iter().map(square).max().unwrap_or(0),
        }
    }

    fn fit(&self, current: &mut Vec<f64>) {
        if current.len() < self.square {
            *current = vec![0.0; self.square];
        }
    }

    #[inline(always)]
    fn eliminate<'a, S: Simd>(
        &mut self,
        By(share, simd): By<impl Share, S>,
        at: At,
        values: Values,
        update_of: impl Fn(usize) -> &'a [f64],
        update: &mut [f64],
        current: &mut Vec<f64>,
    ) -> bool {
        let front = at.front;
        let (height, width) = (height(front), front.width());
        let len = lu::row_len(height);
        let square = &mut current[..height * len];
        square.fill(0.0);
        let bodies = &values.bodies[self.first..][front.pivots.clone()];
        for (k, block) in bodies.iter().enumerate() {
            add_block(square, len, [3 * k, 3 * k], block);
        }
        for Placed { pair, rows, .. } in &values.placed[at.number] {
            let [a, b] = rows.map(|row| 3 * row as usize);
            let (first, second) = values.pairs[*pair as usize].split_at(BODY);
            add_block(square, len, [a, b], first);
            add_block(square, len, [b, a], second);
        }
        for (child, _, places) in at.children().rev() {
            extend(square, len, update_of(child), places);
        }
        let OfFront { lower, upper, exchanged } = &mut self.fronts[at.within];
        let sign = lu::factorise(simd, share, square, [height, width], exchanged);
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
    fn forward(&self, At { front, within, .. }: At, local: &mut [f64]) {
        let OfFront { lower, exchanged, .. } = &self.fronts[within];
        lu::forward(lower, front.width(), exchanged, local);
    }

    #[inline(always)]
    fn backward(&self, At { front, within, .. }: At, local: &mut [f64]) {
        lu::backward(&self.fronts[within].upper, height(front), local);
    }
}

/// Adds a block of three rows at a row and a column.
#[inline(always)]
fn add_block(square: &mut [f64], len: usize, [row, column]: [usize; 2], block: &[f64]) {
    for (i, values) in block.chunks_exact(3).enumerate() {
        let start = (row + i) * len + column;
        for (x, value) in square[start..start + 3].iter_mut().zip(values) {
            *x += value;
        }
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
