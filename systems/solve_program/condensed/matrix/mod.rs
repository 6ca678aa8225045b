//! The condensed matrix: one symmetric positive definite block of three unknowns per body,
//! factorised by a multifrontal Cholesky method (Duff and Reid 1983; Liu 1992).
//!
//! Its pattern is the graph of bodies and interactions. The order of elimination (approximate
//! minimum degree on that graph) and the fronts live as long as the pattern does. Fronts are small,
//! a handful of bodies for most, and three unknowns a body are known when this is compiled: that is
//! what makes it three times as fast as a factorisation for any matrix (docs/benchmarks.md).

mod dense;
mod fronts;
mod ordering;

use pulp::{Arch, Simd, WithSimd};

use self::dense::Triangle;
use self::fronts::{Front, Fronts, LANES};
pub(super) use self::ordering::adjacency;

/// Numbers in a block of the diagonal (its lower triangle by columns) and of a pair.
const DIAGONAL: usize = 6;
const PAIR: usize = 9;

/// Where the block of a pair (a, b) lies in the values of the matrix.
#[derive(Clone, Copy, Debug, Default)]
struct BlockPlace {
    /// Where its three columns start, three rows each.
    start: usize,
    /// Whether columns belong to a, and rows to b.
    forward: bool,
}

/// The matrix, its factor, and what depends on its pattern only.
pub struct BodyMatrix {
    /// Blocks of the lower triangle, front by front: those of the diagonal, then those of pairs.
    values: Vec<f64>,
    /// Where the block of the diagonal of every body starts.
    diagonal: Vec<usize>,
    /// The blocks of every pair, in the order of the pairs given.
    pairs: Vec<BlockPlace>,
    fronts: Fronts,
    /// Where the block of each pair, in the order of the values, lies in the trapezoid of its front,
    /// and where those of each front end.
    targets: Vec<u32>,
    target_ends: Vec<usize>,
    /// What is kept of the trapezoids, front by front.
    factor: Vec<f64>,
    /// Its diagonal blocks, in the order of elimination.
    triangles: Vec<Triangle>,
    /// Updates that wait for the parents of their fronts, of those in even and odd depth.
    updates: [Vec<f64>; 2],
    /// The trapezoid of one front.
    panel: Vec<f64>,
    /// Right side and solution in the order of elimination, and of one front.
    work: Vec<f64>,
    front_work: Vec<f64>,
    instructions: Arch,
}

impl BodyMatrix {
    /// The pattern of `bodies` bodies coupled by `pairs`; `None` if faer finds no order for it.
    #[must_use]
    pub fn new(bodies: usize, pairs: &[(u32, u32)]) -> Option<Self> {
        let (starts, neighbours) = adjacency(bodies, pairs);
        let order = ordering::minimum_degree(&starts, &neighbours)?;
        let fronts = Fronts::new(&order, &starts, &neighbours);

        let (mut place, mut front_of) = (vec![0; bodies], vec![0; bodies]);
        for (number, front) in fronts.list.iter().enumerate() {
            for k in front.pivots.clone() {
                place[fronts.order[k]] = k;
                front_of[k] = number;
            }
        }
        let mut of_front = vec![Vec::new(); fronts.list.len()];
        for (number, &(a, b)) in pairs.iter().enumerate() {
            let (a, b) = (place[a as usize], place[b as usize]);
            of_front[front_of[a.min(b)]].push((number, a, b));
        }
        let mut diagonal = vec![0; bodies];
        let mut blocks = vec![BlockPlace::default(); pairs.len()];
        let mut targets = Vec::with_capacity(pairs.len());
        let mut target_ends = Vec::with_capacity(fronts.list.len());
        let mut start = 0;
        for (front, of_front) in fronts.list.iter().zip(of_front) {
            for k in front.pivots.clone() {
                diagonal[fronts.order[k]] = start;
                start += DIAGONAL;
            }
            for (number, a, b) in of_front {
                blocks[number] = BlockPlace { start, forward: a < b };
                start += PAIR;
                targets.push(fronts.target(front, a.min(b), a.max(b)) as u32);
            }
            target_ends.push(targets.len());
        }
        let greatest = |of: fn(&Front) -> usize| fronts.list.iter().map(of).max().unwrap_or(0);
        Some(Self {
            values: vec![0.0; start],
            diagonal,
            pairs: blocks,
            targets,
            target_ends,
            factor: vec![0.0; fronts.factor_len],
            panel: vec![0.0; greatest(Front::panel_len)],
            triangles: vec![[0.0; 6]; bodies],
            updates: fronts.update_len.map(|len| vec![0.0; len]),
            work: vec![0.0; 3 * bodies],
            front_work: vec![0.0; 3 * greatest(Front::bodies) + LANES],
            fronts,
            instructions: Arch::new(),
        })
    }

    /// Number of bodies.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.diagonal.len()
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds to the diagonal of degree of freedom `k` of a body.
    #[inline]
    pub fn add_diagonal(&mut self, body: usize, k: usize, value: f64) {
        self.values[self.diagonal[body] + [0, 3, 5][k]] += value;
    }

    /// The greatest value on the diagonal.
    #[must_use]
    pub fn greatest_diagonal(&self) -> f64 {
        let on_diagonal = self.diagonal.iter().flat_map(|start| [0, 3, 5].map(|k| start + k));
        on_diagonal.map(|k| self.values[k]).fold(0.0, f64::max)
    }

    /// Adds `G D G'` of a pair, with `G` of `F` columns in the rows of its two bodies.
    #[inline]
    pub fn add<const F: usize>(
        &mut self,
        pair: usize,
        bodies: [u32; 2],
        rows: &[[[f64; F]; 3]; 2],
        d: &[[f64; F]; F],
    ) {
        for (rows, body) in rows.iter().zip(bodies) {
            let left = times(rows, d);
            let start = self.diagonal[body as usize];
            let block = &mut self.values[start..start + DIAGONAL];
            for (k, (c, r)) in
                [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate()
            {
                block[k] += dot(&left[c], &rows[r]);
            }
        }
        let BlockPlace { start, forward } = self.pairs[pair];
        let [of_columns, of_rows] = if forward { [0, 1] } else { [1, 0] };
        let left = times(&rows[of_columns], d);
        let block = &mut self.values[start..start + PAIR];
        for (left, column) in left.iter().zip(block.chunks_exact_mut(3)) {
            for (value, row) in column.iter_mut().zip(&rows[of_rows]) {
                *value += dot(left, row);
            }
        }
    }

    /// Factorises, and solves in place; whether the matrix was positive definite. `x` by body, left
    /// as it was if not.
    pub fn factorise_and_solve(&mut self, x: &mut [[f64; 3]]) -> bool {
        self.instructions.dispatch(FactoriseAndSolve(self, x))
    }

    /// Solves in place with the last factor; `x` by body.
    pub fn solve(&mut self, x: &mut [[f64; 3]]) {
        self.instructions.dispatch(Solve(self, x));
    }

    /// Puts the right side into the order of elimination.
    fn take(&mut self, x: &[[f64; 3]]) {
        for (work, &body) in self.work.chunks_exact_mut(3).zip(&self.fronts.order) {
            work.copy_from_slice(&x[body]);
        }
    }

    /// Solves from the last front to the first, and puts the solution where it belongs.
    #[inline(always)]
    fn solve_backward(&mut self, x: &mut [[f64; 3]]) {
        let Self { fronts, factor, triangles, work, front_work, .. } = self;
        for front in fronts.list.iter().rev() {
            let width = front.width();
            let pivots = 3 * front.pivots.start..3 * front.pivots.end;
            let local = &mut front_work[..3 * front.bodies() + LANES];
            local[..width].copy_from_slice(&work[pivots.clone()]);
            let rows = &fronts.rows[front.rows.clone()];
            for (&row, values) in rows.iter().zip(local[width..].chunks_exact_mut(3)) {
                let row = 3 * row as usize;
                values.copy_from_slice(&work[row..row + 3]);
            }
            local[3 * front.bodies()..].fill(0.0);
            let kept = &factor[front.factor..front.factor + front.factor_len()];
            dense::backward(kept, front.bodies(), &triangles[front.pivots.clone()], local);
            work[pivots].copy_from_slice(&local[..width]);
        }
        for (work, &body) in work.chunks_exact(3).zip(&fronts.order) {
            x[body].copy_from_slice(work);
        }
    }
}

/// Solves for the pivots of one front, and takes what they contribute away from its rows.
#[inline(always)]
fn solve_front(
    front: &Front,
    rows: &[u32],
    kept: &[f64],
    triangles: &[Triangle],
    work: &mut [f64],
    local: &mut [f64],
) {
    let width = front.width();
    let pivots = 3 * front.pivots.start..3 * front.pivots.end;
    let local = &mut local[..3 * front.bodies() + LANES];
    local[..width].copy_from_slice(&work[pivots.clone()]);
    local[width..].fill(0.0);
    dense::forward(kept, front.bodies(), triangles, local);
    work[pivots].copy_from_slice(&local[..width]);
    for (&row, values) in rows.iter().zip(local[width..].chunks_exact(3)) {
        let row = 3 * row as usize;
        for (x, value) in work[row..row + 3].iter_mut().zip(values) {
            *x += value;
        }
    }
}

struct FactoriseAndSolve<'a>(&'a mut BodyMatrix, &'a mut [[f64; 3]]);

impl WithSimd for FactoriseAndSolve<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Self(matrix, x) = self;
        matrix.take(x);
        let BodyMatrix {
            values,
            targets,
            target_ends,
            fronts,
            factor,
            triangles,
            updates,
            panel,
            work,
            front_work,
            ..
        } = &mut *matrix;
        let mut values = &values[..];
        let mut first_target = 0;
        let [even, odd] = updates;
        for (front, &target_end) in fronts.list.iter().zip(&*target_ends) {
            let (height, top) = (front.height(), front.top());
            let panel = &mut panel[..front.panel_len()];
            panel.fill(0.0);
            let (diagonal, rest) = values.split_at(DIAGONAL * front.pivots.len());
            for (k, block) in diagonal.as_chunks().0.iter().enumerate() {
                set_diagonal(panel, height, 3 * k, block);
            }
            let targets = &targets[std::mem::replace(&mut first_target, target_end)..target_end];
            let (blocks, rest) = rest.split_at(PAIR * targets.len());
            for (&target, block) in targets.iter().zip(blocks.as_chunks().0) {
                add_block(panel, height, target as usize, block);
            }
            values = rest;

            let (mine, theirs) = if front.odd { (&mut *odd, &*even) } else { (&mut *even, &*odd) };
            let children = &fronts.children[front.children.clone()];
            for child in children.iter().map(|c| &fronts.list[*c as usize]) {
                let update = &theirs[child.update..child.update + child.update_len()];
                let places = &fronts.in_parent[child.rows.clone()];
                extend(panel, height, 0, update, places, 0..child.inside);
            }
            let triangles = &mut triangles[front.pivots.clone()];
            if !dense::factorise(panel, height, triangles) {
                return false;
            }
            let kept = &mut factor[front.factor..front.factor + front.factor_len()];
            dense::keep(panel, [height, top], front.pivots.len(), front.rows.len(), kept);
            let rows = &fronts.rows[front.rows.clone()];
            solve_front(front, rows, kept, triangles, work, front_work);
            let update = &mut mine[front.update..front.update + front.update_len()];
            dense::update(panel, height, top, update);
            for child in children.iter().map(|c| &fronts.list[*c as usize]) {
                let of_child = &theirs[child.update..child.update + child.update_len()];
                let places = &fronts.in_parent[child.rows.clone()];
                extend(update, front.bottom(), top, of_child, places, child.inside..places.len());
            }
        }
        matrix.solve_backward(x);
        true
    }
}

#[inline(always)]
fn set_diagonal(panel: &mut [f64], height: usize, pivot: usize, block: &[f64; DIAGONAL]) {
    let columns = [&block[..3], &block[3..5], &block[5..]];
    for (c, values) in columns.into_iter().enumerate() {
        let start = (pivot + c) * height + pivot + c;
        panel[start..start + values.len()].copy_from_slice(values);
    }
}

#[inline(always)]
fn add_block(panel: &mut [f64], height: usize, target: usize, block: &[f64; PAIR]) {
    for (c, values) in block.as_chunks::<3>().0.iter().enumerate() {
        let start = target + c * height;
        for (x, value) in panel[start..start + 3].iter_mut().zip(values) {
            *x += value;
        }
    }
}

/// Adds the columns `which` of the update of a child, three each, to the trapezoid or the update of
/// its parent, whose columns have `height` rows and are counted from `first` on in `places`.
#[inline(always)]
fn extend(
    out: &mut [f64],
    height: usize,
    first: usize,
    update: &[f64],
    places: &[u32],
    which: std::ops::Range<usize>,
) {
    let child_height = (3 * places.len()).next_multiple_of(LANES);
    for k in which {
        let rows = &places[k..];
        for c in 0..3 {
            let from = (3 * k + c) * child_height + 3 * k;
            let to = (places[k] as usize - first + c) * height;
            let (from, to) = (&update[from..], &mut out[to..to + height]);
            for (row, values) in rows.iter().zip(from.as_chunks::<3>().0) {
                let row = *row as usize - first;
                for (x, value) in to[row..row + 3].iter_mut().zip(values) {
                    *x += value;
                }
            }
        }
    }
}

struct Solve<'a>(&'a mut BodyMatrix, &'a mut [[f64; 3]]);

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self(matrix, x) = self;
        matrix.take(x);
        let BodyMatrix { fronts, factor, triangles, work, front_work, .. } = &mut *matrix;
        for front in &fronts.list {
            let rows = &fronts.rows[front.rows.clone()];
            let kept = &factor[front.factor..front.factor + front.factor_len()];
            solve_front(front, rows, kept, &triangles[front.pivots.clone()], work, front_work);
        }
        matrix.solve_backward(x);
    }
}

#[inline]
fn dot<const F: usize>(x: &[f64; F], y: &[f64; F]) -> f64 {
    let mut sum = 0.0;
    for f in 0..F {
        sum += x[f] * y[f];
    }
    sum
}

#[inline]
fn times<const F: usize>(rows: &[[f64; F]; 3], d: &[[f64; F]; F]) -> [[f64; F]; 3] {
    let mut out = [[0.0; F]; 3];
    for (out, row) in out.iter_mut().zip(rows) {
        for f in 0..F {
            for g in 0..F {
                out[f] += row[g] * d[g][f];
            }
        }
    }
    out
}
