//! The factor: LU factorisation of the fronts, and the solutions with it.

use pulp::{Simd, WithSimd};

use super::super::fronts::{Front, Fronts};
use super::super::lu;
use super::{BODY, PAIR};

/// The factor, front by front.
#[derive(Default)]
pub(super) struct Factor {
    /// Columns of the pivots, row by row, of all rows of a front.
    lower: Vec<f64>,
    /// Rows of the pivots, without padding.
    upper: Vec<f64>,
    /// The row with which the row of every pivot was exchanged.
    exchanged: Vec<u32>,
    /// Start of the three in every front.
    starts: Vec<[usize; 3]>,
    /// Sign of the determinant.
    pub(super) sign: f64,
    /// The current front, and the updates that wait for their parents.
    front: Vec<f64>,
    updates: Vec<f64>,
    local: Vec<f64>,
}

/// Rows of a front, three a body.
pub(super) fn height(front: &Front) -> usize {
    3 * front.bodies()
}

impl Factor {
    /// The factor of a matrix with these fronts, without values.
    pub(super) fn new(fronts: &Fronts) -> Self {
        let mut factor = Self::default();
        let (mut at, mut waiting, mut max_waiting) = ([0; 3], 0, 0);
        for front in &fronts.list {
            factor.starts.push(at);
            let (rows, width) = (height(front), front.width());
            at = [at[0] + rows * width, at[1] + width * rows, at[2] + width];
            let square = |front: &Front| (height(front) - front.width()).pow(2);
            for child in &fronts.children[front.children.clone()] {
                waiting -= square(&fronts.list[*child as usize]);
            }
            waiting += square(front);
            max_waiting = max_waiting.max(waiting);
        }
        let highest = fronts.list.iter().map(height).max().unwrap_or(0);
        factor.lower = vec![0.0; at[0]];
        factor.upper = vec![0.0; at[1]];
        factor.exchanged = vec![0; at[2]];
        factor.front = vec![0.0; highest * lu::row_len(highest)];
        factor.updates = Vec::with_capacity(max_waiting);
        factor.local = vec![0.0; highest];
        factor
    }
}

pub(super) struct Eliminate<'a> {
    pub(super) fronts: &'a Fronts,
    pub(super) bodies: &'a [[f64; BODY]],
    pub(super) pairs: &'a [[f64; PAIR]],
    pub(super) in_front: &'a [Vec<(u32, [u32; 2])>],
    pub(super) factor: &'a mut Factor,
}

impl WithSimd for Eliminate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { fronts, bodies, pairs, in_front, factor } = self;
        let Factor { lower, upper, exchanged, starts, sign, front: square, updates, .. } = factor;
        *sign = 1.0;
        updates.clear();
        for (number, front) in fronts.list.iter().enumerate() {
            let (height, width) = (height(front), front.width());
            let len = lu::row_len(height);
            let square = &mut square[..height * len];
            square.fill(0.0);
            for (k, block) in bodies[front.pivots.clone()].iter().enumerate() {
                add_block(square, len, [3 * k, 3 * k], block);
            }
            for (pair, [a, b]) in &in_front[number] {
                let [a, b] = [*a as usize, *b as usize];
                let (first, second) = pairs[*pair as usize].split_at(BODY);
                add_block(square, len, [a, b], first);
                add_block(square, len, [b, a], second);
            }
            // The updates of its children are the last ones.
            let children = &fronts.children[front.children.clone()];
            for child in children.iter().rev().map(|c| &fronts.list[*c as usize]) {
                let places = &fronts.in_parent[child.rows.clone()];
                let start = updates.len() - 9 * places.len() * places.len();
                extend(square, len, &updates[start..], places);
                updates.truncate(start);
            }
            let [at_lower, at_upper, at_pivots] = starts[number];
            let exchanged = &mut exchanged[at_pivots..at_pivots + width];
            *sign *= lu::factorise(square, height, width, exchanged);
            if *sign == 0.0 {
                return;
            }
            let lower = &mut lower[at_lower..at_lower + height * width];
            for (out, row) in lower.chunks_exact_mut(width).zip(square.chunks_exact(len)) {
                out.copy_from_slice(&row[..width]);
            }
            let upper = &mut upper[at_upper..at_upper + width * height];
            for (out, row) in upper.chunks_exact_mut(height).zip(square.chunks_exact(len)) {
                out.copy_from_slice(&row[..height]);
            }
            for row in square.chunks_exact(len).skip(width) {
                updates.extend_from_slice(&row[width..height]);
            }
        }
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
    for (i, row) in update.chunks_exact(3 * places.len().max(1)).enumerate() {
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

pub(super) struct Solve<'a> {
    pub(super) fronts: &'a Fronts,
    pub(super) factor: &'a mut Factor,
    pub(super) x: &'a mut [[f64; 3]],
}

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { fronts, factor, x } = self;
        let Factor { lower, upper, exchanged, starts, local, .. } = factor;
        for (front, [at_lower, _, at_pivots]) in fronts.list.iter().zip(&*starts) {
            let width = front.width();
            let rows = &fronts.rows[front.rows.clone()];
            let local = gather(front, rows, x, local);
            let lower = &lower[*at_lower..at_lower + local.len() * width];
            lu::forward(lower, width, &exchanged[*at_pivots..at_pivots + width], local);
            let (own, below) = local.as_chunks::<3>().0.split_at(front.pivots.len());
            x[front.pivots.clone()].copy_from_slice(own);
            for (row, value) in rows.iter().zip(below) {
                x[*row as usize] = *value;
            }
        }
        for (front, [_, at_upper, _]) in fronts.list.iter().zip(&*starts).rev() {
            let width = front.width();
            let rows = &fronts.rows[front.rows.clone()];
            let local = gather(front, rows, x, local);
            let upper = &upper[*at_upper..at_upper + local.len() * width];
            lu::backward(upper, local.len(), local);
            let own = local.as_chunks::<3>().0;
            x[front.pivots.clone()].copy_from_slice(&own[..front.pivots.len()]);
        }
    }
}

/// Copies the numbers of the pivots and rows of a front to `local`.
#[inline(always)]
fn gather<'a>(front: &Front, rows: &[u32], x: &[[f64; 3]], local: &'a mut [f64]) -> &'a mut [f64] {
    let local = &mut local[..height(front)];
    let (own, below) = local.as_chunks_mut::<3>().0.split_at_mut(front.pivots.len());
    own.copy_from_slice(&x[front.pivots.clone()]);
    for (out, row) in below.iter_mut().zip(rows) {
        *out = x[*row as usize];
    }
    local
}
