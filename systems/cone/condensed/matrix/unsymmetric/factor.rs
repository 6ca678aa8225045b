//! The factor: LU factorisation of the fronts, and the solutions with it.

use pulp::{Simd, WithSimd};

use super::super::fronts::{Front, Fronts, Task};
use super::super::lu;
use super::super::share::{By, Share};
use super::super::updates;
use super::{BODY, PAIR};

/// The numbers of a task.
#[derive(Default)]
pub(super) struct Part {
    /// Columns of the pivots, row by row, of all rows of a front.
    lower: Vec<f64>,
    /// Rows of the pivots, without padding.
    upper: Vec<f64>,
    /// The row with which the row of every pivot was exchanged.
    exchanged: Vec<u32>,
    /// Start of these three and of the update, for every front.
    starts: Vec<[usize; 4]>,
    /// Sign of the determinant of the pivots; 0 if there is no factor.
    pub(super) sign: f64,
    /// Updates that wait for the parents of their fronts, lent until the task above has taken them,
    /// and their maximum length.
    updates: Vec<f64>,
    update_len: usize,
    /// Right side and solution of its bodies, then of those beyond.
    pub(super) work: Vec<[f64; 3]>,
    /// Rows of its highest front.
    highest: usize,
}

/// Numbers of the front that is being eliminated, and its right side and solution.
#[derive(Default)]
pub(super) struct Current {
    front: Vec<f64>,
    local: Vec<f64>,
}

impl Current {
    /// Makes room for all fronts of a task.
    fn fit(&mut self, highest: usize) {
        if self.local.len() < highest {
            self.front = vec![0.0; highest * lu::row_len(highest)];
            self.local = vec![0.0; highest];
        }
    }
}

/// Rows of a front, three a body.
fn height(front: &Front) -> usize {
    3 * front.bodies()
}

/// Numbers in the update of a front.
fn update_len(front: &Front) -> usize {
    9 * front.rows.len() * front.rows.len()
}

impl Part {
    /// Room for a task.
    pub(super) fn new(fronts: &Fronts, task: usize) -> Self {
        let task = &fronts.tasks[task];
        let (mut at, mut max_waiting) = ([0; 4], 0);
        let mut starts = Vec::with_capacity(task.fronts.len());
        for front in &fronts.list[task.fronts.clone()] {
            // Its children have the last updates; those of other tasks are there.
            let children = fronts.children[front.children.clone()].iter().map(|c| *c as usize);
            for child in children.filter(|child| *child >= task.fronts.start) {
                at[3] -= update_len(&fronts.list[child]);
            }
            starts.push(at);
            let (rows, width) = (height(front), front.width());
            let [lower, upper, pivots, waiting] = at;
            at = [
                lower + rows * width,
                upper + width * rows,
                pivots + width,
                waiting + update_len(front),
            ];
            max_waiting = max_waiting.max(at[3]);
        }
        Self {
            lower: vec![0.0; at[0]],
            upper: vec![0.0; at[1]],
            exchanged: vec![0; at[2]],
            starts,
            sign: 0.0,
            updates: Vec::new(),
            update_len: max_waiting,
            work: vec![[0.0; 3]; task.bodies()],
            highest: fronts.list[task.fronts.clone()].iter().map(height).max().unwrap_or(0),
        }
    }

    /// The update of a front, by its number in the task.
    fn update(&self, number: usize, front: &Front) -> &[f64] {
        &self.updates[self.starts[number][3]..][..update_len(front)]
    }
}

impl updates::Part for Part {
    fn updates(&mut self) -> &mut Vec<f64> {
        &mut self.updates
    }

    fn update_len(&self, _: &Task) -> usize {
        self.update_len
    }
}

/// Values of bodies and of pairs, and the pairs of every front.
type Values<'a> = (&'a [[f64; BODY]], &'a [[f64; PAIR]], &'a [Vec<(u32, [u32; 2])>]);

/// Factorisation of a task; whether all pivots are finite and none is zero.
pub(super) struct Eliminate<'a> {
    pub(super) fronts: &'a Fronts,
    pub(super) values: Values<'a>,
    pub(super) task: usize,
    pub(super) part: &'a mut Part,
    /// The other tasks of its subtrees.
    pub(super) below: &'a [Part],
    pub(super) current: &'a mut Current,
}

impl<H: Share> WithSimd for By<H, Eliminate<'_>> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self(share, Eliminate { fronts, values, task, part, below, current }) = self;
        let (bodies, pairs, in_front) = values;
        let first_below = task - below.len();
        let task = &fronts.tasks[task];
        current.fit(part.highest);
        let bodies = &bodies[task.places.clone()];
        part.sign = 0.0;
        let mut sign = 1.0;
        for number in task.fronts.clone() {
            let front = &fronts.list[number];
            let (height, width) = (height(front), front.width());
            let len = lu::row_len(height);
            let square = &mut current.front[..height * len];
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
            let children = &fronts.children[front.children.clone()];
            for child in children.iter().rev().map(|c| *c as usize) {
                let (of_child, first) = if child >= task.fronts.start {
                    (&*part, task.fronts.start)
                } else {
                    let other = fronts.task_of(child);
                    (&below[other - first_below], fronts.tasks[other].fronts.start)
                };
                let front = &fronts.list[child];
                let places = &fronts.in_parent[front.rows.clone()];
                extend(square, len, of_child.update(child - first, front), places);
            }
            let [at_lower, at_upper, at_pivots, at_update] =
                part.starts[number - task.fronts.start];
            let exchanged = &mut part.exchanged[at_pivots..at_pivots + width];
            sign *= lu::factorise(simd, share, square, [height, width], exchanged);
            if sign == 0.0 {
                return false;
            }
            let lower = &mut part.lower[at_lower..at_lower + height * width];
            for (out, row) in lower.chunks_exact_mut(width).zip(square.chunks_exact(len)) {
                out.copy_from_slice(&row[..width]);
            }
            let upper = &mut part.upper[at_upper..at_upper + width * height];
            for (out, row) in upper.chunks_exact_mut(height).zip(square.chunks_exact(len)) {
                out.copy_from_slice(&row[..height]);
            }
            let below = height - width;
            let update = &mut part.updates[at_update..at_update + below * below];
            let rows = square.chunks_exact(len).skip(width);
            for (out, row) in update.chunks_exact_mut(below.max(1)).zip(rows) {
                out.copy_from_slice(&row[width..height]);
            }
        }
        part.sign = sign;
        true
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

/// Forward solve of the work of a task.
pub(super) struct Forward<'a>(
    pub(super) &'a Fronts,
    pub(super) usize,
    pub(super) &'a mut Part,
    pub(super) &'a mut Current,
);

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(fronts, task, part, current) = self;
        current.fit(part.highest);
        let Part { lower, exchanged, starts, work, .. } = part;
        let list = &fronts.list[fronts.tasks[task].fronts.clone()];
        for (front, [at_lower, _, at_pivots, _]) in list.iter().zip(&*starts) {
            let width = front.width();
            let rows = &fronts.rows[front.rows.clone()];
            let local = gather(front, rows, work, &mut current.local);
            let lower = &lower[*at_lower..at_lower + local.len() * width];
            lu::forward(lower, width, &exchanged[*at_pivots..at_pivots + width], local);
            let (own, below) = local.as_chunks::<3>().0.split_at(front.pivots.len());
            work[front.pivots.clone()].copy_from_slice(own);
            for (row, value) in rows.iter().zip(below) {
                work[*row as usize] = *value;
            }
        }
    }
}

/// Backward solve of the work of a task.
pub(super) struct Backward<'a>(
    pub(super) &'a Fronts,
    pub(super) usize,
    pub(super) &'a mut Part,
    pub(super) &'a mut Current,
);

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(fronts, task, part, current) = self;
        current.fit(part.highest);
        let Part { upper, starts, work, .. } = part;
        let list = &fronts.list[fronts.tasks[task].fronts.clone()];
        for (front, [_, at_upper, ..]) in list.iter().zip(&*starts).rev() {
            let width = front.width();
            let rows = &fronts.rows[front.rows.clone()];
            let local = gather(front, rows, work, &mut current.local);
            let upper = &upper[*at_upper..at_upper + local.len() * width];
            lu::backward(upper, local.len(), local);
            let own = local.as_chunks::<3>().0;
            work[front.pivots.clone()].copy_from_slice(&own[..front.pivots.len()]);
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
