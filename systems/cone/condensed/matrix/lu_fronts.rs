//! LU factorisation of the fronts of an unsymmetric matrix.

use pulp::Simd;

use super::assembly::{add_products, times};
use super::dense::add_block;
use super::factor::{Arithmetic, At, Values};
use super::fronts::{Front, Fronts, Task};
use super::lu;
use super::share::{By, Share};

/// Numbers in the block of a body, row by row, and in each block of a pair: rows of the body that
/// is eliminated first in columns of the other, then the transposed place.
const BODY: usize = 9;

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
    /// Sign of the determinant of the pivots; 0 if there is no factor.
    pub sign: f64,
}

/// Rows of a front, three a body.
fn height(front: &Front) -> usize {
    3 * front.bodies()
}

impl Arithmetic for Lu {
    type Body = [f64; BODY];
    type Pair = [[f64; BODY]; 2];

    const DIAGONAL: [usize; 3] = [0, 4, 8];

    #[inline]
    fn add_body<const F: usize>(block: &mut Self::Body, rows: &[[f64; F]; 3], d: &[[f64; F]; F]) {
        add_products(block, &times(rows, d), rows);
    }

    #[inline]
    fn add_pair<const F: usize>(
        block: &mut Self::Pair,
        [first, second]: [&[[f64; F]; 3]; 2],
        d: &[[f64; F]; F],
    ) {
        let [upper, lower] = block;
        add_products(upper, &times(first, d), second);
        add_products(lower, &times(second, d), first);
    }

    fn new(fronts: &Fronts, task: &Task) -> Self {
        let list = &fronts.list[task.fronts.clone()];
        let of_front = |front: &Front| OfFront {
            lower: vec![0.0; height(front) * front.width()],
            upper: vec![0.0; height(front) * front.width()],
            exchanged: vec![0; front.width()],
        };
        Self { fronts: list.iter().map(of_front).collect(), sign: 0.0 }
    }

    /// Its square.
    fn room(front: &Front) -> [usize; 2] {
        [height(front) * lu::row_len(height(front)), 0]
    }

    #[inline(always)]
    fn eliminate<'a, S: Simd>(
        &mut self,
        By(share, simd): By<impl Share, S>,
        at: At,
        values: Values<Self::Body, Self::Pair>,
        update_of: impl Fn(usize) -> &'a [f64],
        update: &mut [f64],
        [square, _]: [&mut [f64]; 2],
    ) -> bool {
        let front = at.front;
        let (height, width) = (height(front), front.width());
        let len = lu::row_len(height);
        square.fill(0.0);
        for (k, block) in at.of_pivots(values.bodies).iter().enumerate() {
            add_block(square, len, 3 * k * len + 3 * k, block);
        }
        for (rows, [upper, lower]) in at.of_pairs(values.pairs) {
            let [a, b] = rows.map(|row| 3 * row as usize);
            add_block(square, len, a * len + b, upper);
            add_block(square, len, b * len + a, lower);
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

#[cfg(test)]
mod tests {
    use faer::Mat;
    use faer::linalg::solvers::Solve as _;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::super::{PairPlace, UnsymmetricMatrix};

    /// On a random unsymmetric matrix of a random graph, solution and sign of the determinant are
    /// those of a dense LU factorisation with pivoting.
    #[test]
    fn solves_as_a_dense_factorisation_does() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut uniform = move || random.next_u32() as f64 / f64::from(u32::MAX) - 0.5;
        for bodies in [1, 2, 7, 40] {
            let mut pairs = Vec::new();
            for a in 0..bodies {
                for b in a + 1..bodies {
                    if b == a + 1 || uniform() > 0.4 {
                        pairs.push((a as u32, b as u32));
                    }
                }
            }
            for _ in 0..20 {
                let mut matrix = UnsymmetricMatrix::new(bodies, &pairs).unwrap();
                let order = matrix.order().to_vec();
                let n = 3 * bodies;
                let mut dense = Mat::<f64>::zeros(n, n);
                for (place, body) in order.iter().enumerate() {
                    for k in 0..3 {
                        let value = 0.1 * uniform();
                        matrix.assembly().add_diagonal(place, k, value);
                        dense[(3 * body + k, 3 * body + k)] += value;
                    }
                }
                for (number, (a, b)) in pairs.iter().enumerate() {
                    let mut block = || [0; 3].map(|_| [0; 3].map(|_| uniform()));
                    let (rows, t) = ([block(), block()], block());
                    matrix.assembly().add(number, &rows, &t);
                    let sides = [(*a as usize, rows[0]), (*b as usize, rows[1])];
                    for (x, of_x) in &sides {
                        for (y, of_y) in &sides {
                            for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                                for (f, g) in (0..9).map(|k| (k / 3, k % 3)) {
                                    dense[(3 * x + i, 3 * y + j)] +=
                                        of_x[i][f] * t[f][g] * of_y[j][g];
                                }
                            }
                        }
                    }
                }
                assert!(matrix.factorise());
                let factor = dense.partial_piv_lu();
                assert_eq!(matrix.sign(), dense.determinant().signum());
                let right: Vec<[f64; 3]> = (0..bodies).map(|_| [0; 3].map(|_| uniform())).collect();
                let column = Mat::from_fn(n, 1, |i, _| right[i / 3][i % 3]);
                let expected = factor.solve(&column);
                let mut x: Vec<[f64; 3]> = order.iter().map(|body| right[*body]).collect();
                matrix.solve(&mut x);
                let scale = expected.norm_max();
                for (x, body) in x.iter().zip(&order) {
                    for k in 0..3 {
                        let difference = (x[k] - expected[(3 * body + k, 0)]).abs();
                        assert!(difference <= 1e-7 * scale, "{difference:e} of {scale:e}");
                    }
                }
            }
        }
    }

    /// A graph with many tasks: solution and sign are the same bytes on any number of threads, and
    /// the residual is small.
    #[test]
    fn threads_change_no_byte() {
        let side = 60_u32;
        let bodies = (side * side) as usize;
        let pairs: Vec<(u32, u32)> = (0..side * side)
            .flat_map(|i| [(i, i + 1, i % side < side - 1), (i, i + side, i + side < side * side)])
            .filter_map(|(a, b, is_pair)| is_pair.then_some((a, b)))
            .collect();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut random = ChaCha8Rng::seed_from_u64(1);
                let mut uniform = move || random.next_u32() as f64 / f64::from(u32::MAX) - 0.5;
                let mut matrix = UnsymmetricMatrix::new(bodies, &pairs).unwrap();
                assert!(matrix.fronts.tasks.len() > 20);
                for place in 0..bodies {
                    let mut values = matrix.assembly();
                    (0..3).for_each(|k| values.add_diagonal(place, k, 0.1 * uniform()));
                }
                for pair in 0..pairs.len() {
                    let mut block = || [0; 3].map(|_| [0; 3].map(|_| uniform()));
                    matrix.assembly().add(pair, &[block(), block()], &block());
                }
                assert!(matrix.factorise());
                let right: Vec<[f64; 3]> = (0..bodies).map(|_| [0; 3].map(|_| uniform())).collect();
                let mut x = right.clone();
                matrix.solve(&mut x);
                // The residual of the solution.
                let mut left = right;
                for (left, (x, block)) in left.iter_mut().zip(x.iter().zip(&matrix.bodies)) {
                    take_away(left, block, x);
                }
                for PairPlace { place, bodies: [a, b] } in &matrix.places {
                    let (a, b, blocks) = (*a.min(b), *a.max(b), &matrix.pairs[*place]);
                    take_away(&mut left[a], &blocks[0], &x[b]);
                    take_away(&mut left[b], &blocks[1], &x[a]);
                }
                let worst = left.as_flattened().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
                let size = x.as_flattened().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
                assert!(worst <= 1e-10 * size, "{worst:e} of {size:e}");
                // A matrix of zeros has no factor.
                let sign = matrix.sign();
                matrix.clear();
                assert!(!matrix.factorise() && matrix.sign() == 0.0);
                (x, sign)
            })
        };
        let one = on(1);
        assert!(one.1.abs() == 1.0);
        assert!(on(2) == one && on(5) == one);
    }

    fn take_away(left: &mut [f64; 3], block: &[f64], x: &[f64; 3]) {
        for (left, row) in left.iter_mut().zip(block.as_chunks::<3>().0) {
            *left -= row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
        }
    }
}
