//! The condensed matrix: one symmetric positive definite block of three unknowns per body,
//! factorised by a multifrontal Cholesky method (Duff and Reid 1983; Liu 1992).
//!
//! Its pattern is the graph of bodies and interactions. The order of elimination (approximate
//! minimum degree on that graph) and the fronts live as long as the pattern does. Fronts are small,
//! a handful of bodies for most, and three unknowns a body are known when this is compiled: that is
//! what makes it three times as fast as a factorisation for any matrix (docs/benchmarks.md).

mod dense;
mod fronts;
mod numeric;
mod ordering;
mod packed;

use pulp::Arch;

use self::dense::{LANES, Triangle};
use self::fronts::{Front, Fronts};
use self::numeric::{FactoriseAndSolve, Solve};
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
    /// The trapezoid of one front, and its copy if it is large.
    panel: Vec<f64>,
    packed: Vec<f64>,
    /// Right side and solution in the order of elimination, and of one front.
    work: Vec<[f64; 3]>,
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
            packed: vec![0.0; greatest(packed::packed_len)],
            triangles: vec![[0.0; 6]; bodies],
            updates: fronts.update_len.map(|len| vec![0.0; len]),
            work: vec![[0.0; 3]; bodies],
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

    /// Adds to the diagonal of degree of freedom `k` of a body: 0 and 1 translations, 2 the rotation.
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

    /// Adds `G D G'` of a pair, with `G` of `F` columns in the rows of its two bodies, which are those
    /// that the pattern was made of, in that order. `D` is symmetric.
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
    #[must_use = "a matrix that is not positive definite leaves the right side where the solution would be"]
    pub fn factorise_and_solve(&mut self, x: &mut [[f64; 3]]) -> bool {
        self.instructions.dispatch(FactoriseAndSolve(self, x))
    }

    /// Solves in place with the last factor; `x` by body. Only after `factorise_and_solve` has
    /// returned true.
    pub fn solve(&mut self, x: &mut [[f64; 3]]) {
        self.instructions.dispatch(Solve(self, x));
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
