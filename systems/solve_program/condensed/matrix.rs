//! The condensed matrix: one symmetric positive definite block of three unknowns per body,
//! factorised by faer's supernodal Cholesky.
//!
//! Its pattern is the graph of bodies and interactions. The order of elimination (approximate
//! minimum degree on that graph, expanded to three unknowns, in postorder of the elimination tree)
//! and the symbolic factorisation live as long as the pattern does.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, amd};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

/// Where the block of a pair (a, b) lies in the values of the matrix.
#[derive(Clone, Copy, Debug)]
struct BlockPlace {
    /// Where its three columns start; their rows follow.
    columns: [usize; 3],
    /// Whether columns belong to a, and rows to b.
    forward: bool,
}

/// The matrix, its factor, and what depends on its pattern only.
pub struct BodyMatrix {
    bodies: usize,
    order: Vec<usize>,
    column_starts: Vec<usize>,
    row_indices: Vec<usize>,
    /// Values of the lower triangle.
    pub values: Vec<f64>,
    /// Positions of the three diagonal entries of every body; entries below follow.
    pub diagonal: Vec<[usize; 3]>,
    /// The off-diagonal blocks of every pair, in the order of the pairs given.
    places: Vec<BlockPlace>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    memory: MemBuffer,
    work: Vec<f64>,
}

impl BodyMatrix {
    /// The pattern of `bodies` bodies coupled by `pairs`; `None` if faer refuses it.
    #[must_use]
    pub fn new(bodies: usize, pairs: &[(u32, u32)]) -> Option<Self> {
        let (starts, neighbours) = adjacency(bodies, pairs);
        let order = minimum_degree(bodies, &starts, &neighbours)?;
        let order = postorder(bodies, &order, &starts, &neighbours);
        let mut place = vec![0; bodies];
        for (k, &i) in order.iter().enumerate() {
            place[i] = k;
        }
        // Lower triangle by columns, three columns a body.
        let mut below_starts = vec![0];
        let mut below = Vec::new();
        for &i in &order {
            let mut list: Vec<usize> = neighbours[starts[i]..starts[i + 1]]
                .iter()
                .map(|j| place[*j])
                .filter(|j| *j > place[i])
                .collect();
            list.sort_unstable();
            below.extend(list);
            below_starts.push(below.len());
        }
        let mut column_starts = vec![0];
        let mut row_indices = Vec::new();
        for k in 0..bodies {
            for c in 0..3 {
                row_indices.extend((c..3).map(|r| 3 * k + r));
                for &j in &below[below_starts[k]..below_starts[k + 1]] {
                    row_indices.extend((0..3).map(|r| 3 * j + r));
                }
                column_starts.push(row_indices.len());
            }
        }
        let diagonal =
            (0..bodies).map(|i| [0, 1, 2].map(|c| column_starts[3 * place[i] + c])).collect();
        let places = pairs
            .iter()
            .map(|&(a, b)| {
                let (a, b) = (place[a as usize], place[b as usize]);
                let (low, high) = (a.min(b), a.max(b));
                let list = &below[below_starts[low]..below_starts[low + 1]];
                let k = list.partition_point(|j| *j < high);
                let columns = [0, 1, 2].map(|c| column_starts[3 * low + c] + (3 - c) + 3 * k);
                BlockPlace { columns, forward: a < b }
            })
            .collect();
        let symbolic = symbolic(3 * bodies, &column_starts, &row_indices)?;
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        Some(Self {
            bodies,
            order,
            diagonal,
            places,
            values: vec![0.0; row_indices.len()],
            factor: vec![0.0; symbolic.len_val()],
            memory: MemBuffer::new(scratch),
            work: vec![0.0; 3 * bodies],
            column_starts,
            row_indices,
            symbolic,
        })
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds `G D G'` of a pair, with `G` of `F` columns in the rows of its two bodies.
    #[inline]
    pub fn add<const F: usize>(
        &mut self,
        pair: usize,
        bodies: [usize; 2],
        rows: &[[[f64; 3]; 3]; 2],
        d: &[[f64; 3]; 3],
    ) {
        for (rows, body) in rows.iter().zip(bodies) {
            let left = times::<F>(rows, d);
            for (c, start) in self.diagonal[body].into_iter().enumerate() {
                for (r, value) in self.values[start..start + 3 - c].iter_mut().enumerate() {
                    *value += dot::<F>(&left[c], &rows[c + r]);
                }
            }
        }
        let place = self.places[pair];
        let [of_columns, of_rows] = if place.forward { [0, 1] } else { [1, 0] };
        let left = times::<F>(&rows[of_columns], d);
        for (left, start) in left.iter().zip(place.columns) {
            for (value, row) in self.values[start..start + 3].iter_mut().zip(&rows[of_rows]) {
                *value += dot::<F>(left, row);
            }
        }
    }

    /// Factorises; whether the matrix was positive definite.
    pub fn factorise(&mut self) -> bool {
        let n = 3 * self.bodies;
        let pattern = SymbolicSparseColMatRef::<usize>::new_checked(
            n,
            n,
            &self.column_starts,
            None,
            &self.row_indices,
        );
        let matrix = SparseColMatRef::new(pattern, &self.values[..]);
        let regularisation = LltRegularization {
            dynamic_regularization_delta: 0.0,
            dynamic_regularization_epsilon: 0.0,
        };
        self.symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                matrix,
                Side::Lower,
                regularisation,
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            )
            .is_ok()
    }

    /// Solves in place with the last factor; `x` by body.
    pub fn solve(&mut self, x: &mut [[f64; 3]]) {
        for (k, &i) in self.order.iter().enumerate() {
            self.work[3 * k..3 * k + 3].copy_from_slice(&x[i]);
        }
        let n = 3 * self.bodies;
        let right = MatMut::from_column_major_slice_mut(&mut self.work[..], n, 1);
        LltRef::new(&self.symbolic, &self.factor[..]).solve_in_place_with_conj(
            Conj::No,
            right,
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
        for (k, &i) in self.order.iter().enumerate() {
            x[i].copy_from_slice(&self.work[3 * k..3 * k + 3]);
        }
    }
}

#[inline]
fn dot<const F: usize>(x: &[f64; 3], y: &[f64; 3]) -> f64 {
    let mut sum = 0.0;
    for f in 0..F {
        sum += x[f] * y[f];
    }
    sum
}

#[inline]
fn times<const F: usize>(rows: &[[f64; 3]; 3], d: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut out = [[0.0; 3]; 3];
    for (out, row) in out.iter_mut().zip(rows) {
        for f in 0..F {
            for g in 0..F {
                out[f] += row[g] * d[g][f];
            }
        }
    }
    out
}

/// Neighbours of every body in ascending order: where they start, and their list.
pub(super) fn adjacency(bodies: usize, pairs: &[(u32, u32)]) -> (Vec<usize>, Vec<usize>) {
    let mut lists = vec![Vec::new(); bodies];
    for &(a, b) in pairs {
        lists[a as usize].push(b as usize);
        lists[b as usize].push(a as usize);
    }
    let mut starts = vec![0];
    let mut neighbours = Vec::with_capacity(2 * pairs.len());
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
        neighbours.extend_from_slice(list);
        starts.push(neighbours.len());
    }
    (starts, neighbours)
}

fn minimum_degree(n: usize, starts: &[usize], neighbours: &[usize]) -> Option<Vec<usize>> {
    if n == 0 {
        return Some(Vec::new());
    }
    let pattern = SymbolicSparseColMatRef::<usize>::new_checked(n, n, starts, None, neighbours);
    let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(n, neighbours.len()));
    let stack = MemStack::new(&mut memory);
    amd::order(&mut forward, &mut inverse, pattern, amd::Control::default(), stack).ok()?;
    Some(forward)
}

/// Postorder of the elimination tree (Liu): columns of one supernode become neighbours.
fn postorder(n: usize, order: &[usize], starts: &[usize], neighbours: &[usize]) -> Vec<usize> {
    let mut place = vec![0; n];
    for (k, &i) in order.iter().enumerate() {
        place[i] = k;
    }
    let none = usize::MAX;
    let (mut parent, mut ancestor) = (vec![none; n], vec![none; n]);
    for k in 0..n {
        for &j in &neighbours[starts[order[k]]..starts[order[k] + 1]] {
            let mut i = place[j];
            while i < k {
                let next = std::mem::replace(&mut ancestor[i], k);
                if next == none {
                    parent[i] = k;
                }
                if next == none || next == k {
                    break;
                }
                i = next;
            }
        }
    }
    let mut children = vec![Vec::new(); n];
    let mut roots = Vec::new();
    for k in (0..n).rev() {
        if parent[k] == none { roots.push(k) } else { children[parent[k]].push(k) }
    }
    let mut post = Vec::with_capacity(n);
    let mut stack = Vec::new();
    while let Some(root) = roots.pop() {
        stack.push(root);
        while let Some(&top) = stack.last() {
            if let Some(child) = children[top].pop() {
                stack.push(child);
            } else {
                post.push(order[top]);
                stack.pop();
            }
        }
    }
    post
}

fn symbolic(
    n: usize,
    column_starts: &[usize],
    row_indices: &[usize],
) -> Option<SymbolicCholesky<usize>> {
    // With an identity ordering faer reads the upper triangle here and the lower one in the
    // numeric part: the transposed pattern.
    let mut starts = vec![0; n + 1];
    for &r in row_indices {
        starts[r + 1] += 1;
    }
    for i in 0..n {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut indices = vec![0; row_indices.len()];
    for c in 0..n {
        for &r in &row_indices[column_starts[c]..column_starts[c + 1]] {
            indices[next[r]] = c;
            next[r] += 1;
        }
    }
    let upper = SymbolicSparseColMatRef::<usize>::new_checked(n, n, &starts, None, &indices);
    let parameters = CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    };
    factorize_symbolic_cholesky(upper, Side::Upper, SymmetricOrdering::Identity, parameters).ok()
}
