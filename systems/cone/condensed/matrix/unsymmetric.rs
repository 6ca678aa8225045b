//! An unsymmetric matrix with the pattern of the condensed matrix, factorised by a multifrontal LU
//! method (Davis and Duff 1997) on the fronts of the symmetric pattern.
//!
//! Fronts and tasks are those of the Cholesky method. Rows are exchanged among the pivots of a front
//! only, so that the fronts do not depend on the values. This costs accuracy, which the caller
//! recovers by iterative refinement. The sign of the determinant comes with the factor.

use super::factor::Factor;
use super::fronts::Fronts;
use super::layout::{self, Placed};
use super::lu_fronts::{BODY, Lu, PAIR, Values};
use crate::condensed::images::Images;
use crate::condensed::parallel::in_pool;

/// The matrix, its factor, and the data that depend on its pattern only.
pub struct UnsymmetricMatrix {
    fronts: Fronts,
    /// Blocks of bodies by place.
    bodies: Vec<[f64; BODY]>,
    /// Blocks of pairs.
    pairs: Vec<[f64; PAIR]>,
    /// Places of the bodies of every pair.
    of_pair: Vec<[u32; 2]>,
    /// The pairs of every front.
    placed: Vec<Vec<Placed>>,
    factor: Factor<Lu>,
    images: Images,
}

impl UnsymmetricMatrix {
    /// The pattern of `bodies` bodies coupled by `pairs`; `None` if faer finds no order for it.
    #[must_use]
    pub fn new(bodies: usize, pairs: &[(u32, u32)]) -> Option<Self> {
        let (fronts, placed) = layout::of_pairs(bodies, pairs)?;
        let mut of_pair = vec![[0; 2]; pairs.len()];
        for Placed { pair, places, .. } in placed.iter().flatten() {
            of_pair[*pair as usize] = *places;
        }
        Some(Self {
            bodies: vec![[0.0; BODY]; bodies],
            pairs: vec![[0.0; PAIR]; pairs.len()],
            of_pair,
            placed,
            factor: Factor::new(&fronts),
            fronts,
            images: Images::default(),
        })
    }

    /// Bodies in the order of elimination. All other functions number bodies by this order.
    #[must_use]
    pub fn order(&self) -> &[usize] {
        &self.fronts.order
    }

    /// Takes over the images of a program, which [`add`](Self::add) needs for interactions with
    /// them.
    pub fn set_images(&mut self, images: &Images) {
        self.images.clone_from(images);
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.bodies.fill([0.0; BODY]);
        self.pairs.fill([0.0; PAIR]);
    }

    /// Adds to the diagonal at degree of freedom `k` of a body: 0 and 1 are translations, 2 is the
    /// rotation.
    pub fn add_diagonal(&mut self, body: usize, k: usize, value: f64) {
        self.bodies[body][4 * k] += value;
    }

    /// Adds `G T G'` of a pair, with `G` in the rows of its two bodies in the order of the pair in
    /// the pattern. With an image as the second body the cell takes part too.
    pub fn add(&mut self, pair: usize, rows: &[[[f64; 3]; 3]; 2], t: &[[f64; 3]; 3]) {
        let Some((image, with_cell)) = self.images.at(pair) else {
            self.add_blocks(pair, rows, t, [true, true]);
            return;
        };
        let (of_b, of_cell) = self.images.rows(image, &rows[1]);
        self.add_blocks(pair, &[rows[0], of_b], t, [true, true]);
        self.add_blocks(with_cell, &[rows[0], of_cell], t, [false, true]);
        self.add_blocks(with_cell + 1, &[of_b, of_cell], t, [false, false]);
    }

    /// Adds the blocks of a pair, and those of its bodies where `with_own` says so.
    fn add_blocks(
        &mut self,
        pair: usize,
        rows: &[[[f64; 3]; 3]; 2],
        t: &[[f64; 3]; 3],
        with_own: [bool; 2],
    ) {
        let times = |rows: &[[f64; 3]; 3]| {
            rows.map(|row| {
                std::array::from_fn::<f64, 3, _>(|g| (0..3).map(|f| row[f] * t[f][g]).sum())
            })
        };
        let dot = |x: &[f64; 3], y: &[f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
        let left = [times(&rows[0]), times(&rows[1])];
        for (side, body) in self.of_pair[pair].into_iter().enumerate() {
            let own = &mut self.bodies[body as usize];
            let both = &mut self.pairs[pair][9 * side..9 * side + 9];
            for i in 0..3 {
                for j in 0..3 {
                    if with_own[side] {
                        own[3 * i + j] += dot(&left[side][i], &rows[side][j]);
                    }
                    both[3 * i + j] += dot(&left[side][i], &rows[1 - side][j]);
                }
            }
        }
    }

    /// Factorises; whether all pivots are finite and none is zero.
    #[must_use]
    pub fn factorise(&mut self) -> bool {
        let Self { fronts, bodies, pairs, placed, factor, .. } = self;
        let values = Values { bodies, pairs, placed };
        in_pool(factor.is_shared(), || factor.factorise(fronts, values, None))
    }

    /// Sign of the determinant of the matrix that was factorised last.
    #[must_use]
    pub fn sign(&self) -> f64 {
        self.factor.parts().map(|part| part.sign).product()
    }

    /// Solves in place with the last factor; `x` is in the order of elimination.
    pub fn solve(&mut self, x: &mut [[f64; 3]]) {
        let Self { fronts, factor, .. } = self;
        in_pool(factor.is_shared(), || {
            factor.forward(fronts, x);
            factor.backward(fronts, x);
        });
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use faer::linalg::solvers::Solve as _;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;

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
                        matrix.add_diagonal(place, k, value);
                        dense[(3 * body + k, 3 * body + k)] += value;
                    }
                }
                for (number, (a, b)) in pairs.iter().enumerate() {
                    let mut block = || [0; 3].map(|_| [0; 3].map(|_| uniform()));
                    let (rows, t) = ([block(), block()], block());
                    matrix.add(number, &rows, &t);
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
                    (0..3).for_each(|k| matrix.add_diagonal(place, k, 0.1 * uniform()));
                }
                for pair in 0..pairs.len() {
                    let mut block = || [0; 3].map(|_| [0; 3].map(|_| uniform()));
                    matrix.add(pair, &[block(), block()], &block());
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
                for ([a, b], blocks) in matrix.of_pair.iter().zip(&matrix.pairs) {
                    let [a, b] = [*a as usize, *b as usize];
                    take_away(&mut left[a], &blocks[..BODY], &x[b]);
                    take_away(&mut left[b], &blocks[BODY..], &x[a]);
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
