//! The factorisation of the condensed matrix, against nalgebra's dense Cholesky factorisation of the
//! same matrix, set up apart, and against the definition of a solution.

use clastic::cone::condensed::matrix::BodyMatrix;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// One interaction: bodies, rows of (p, q) for both, and the 2 x 2 block between.
type Interaction = ((u32, u32), [[[f64; 2]; 3]; 2], [[f64; 2]; 2]);

/// A graph of bodies, with weights on the diagonal.
#[derive(Clone, Debug)]
struct Sample {
    weights: Vec<f64>,
    interactions: Vec<Interaction>,
}

impl Sample {
    fn matrix(&self) -> BodyMatrix {
        let pairs: Vec<_> = self.interactions.iter().map(|(pair, ..)| *pair).collect();
        let mut matrix = BodyMatrix::new(self.weights.len(), &pairs);
        matrix.clear();
        let order = matrix.order().to_vec();
        let mut values = matrix.assembly();
        for (place, body) in order.into_iter().enumerate() {
            (0..3).for_each(|k| values.add_diagonal(place, k, self.weights[body]));
        }
        for (k, (_, rows, d)) in self.interactions.iter().enumerate() {
            values.add(k, rows, d);
        }
        matrix
    }

    /// Sums of the magnitudes of the terms of every entry of the matrix, and the maximum number of
    /// interactions of a body.
    fn magnitudes(&self) -> (DMatrix<f64>, usize) {
        let mut absolute = self.clone();
        let mut interactions = vec![0; self.weights.len()];
        for ((a, b), rows, d) in &mut absolute.interactions {
            *rows = rows.map(|rows| rows.map(|row| row.map(f64::abs)));
            *d = d.map(|d| d.map(f64::abs));
            for body in [*a, *b] {
                interactions[body as usize] += 1;
            }
        }
        (absolute.dense(), interactions.into_iter().max().unwrap_or(0))
    }

    fn dense(&self) -> DMatrix<f64> {
        let n = 3 * self.weights.len();
        let mut dense = DMatrix::zeros(n, n);
        for (i, weight) in self.weights.iter().enumerate() {
            (0..3).for_each(|k| dense[(3 * i + k, 3 * i + k)] += weight);
        }
        for ((a, b), rows, d) in &self.interactions {
            let place = |k: usize| 3 * (if k < 3 { *a } else { *b }) as usize + k % 3;
            let row = |k: usize| rows[k / 3][k % 3];
            for (k, l) in (0..36).map(|k| (k / 6, k % 6)) {
                for (f, g) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    dense[(place(k), place(l))] += row(k)[f] * d[f][g] * row(l)[g];
                }
            }
        }
        dense
    }
}

/// Solves with a new factor, by body; whether there is one.
fn factorise_and_solve(matrix: &mut BodyMatrix, x: &mut [[f64; 3]]) -> bool {
    in_its_order(matrix, x, BodyMatrix::factorise_and_solve)
}

/// What the matrix does with `x` in the order of elimination.
fn in_its_order<R>(
    matrix: &mut BodyMatrix,
    x: &mut [[f64; 3]],
    f: impl FnOnce(&mut BodyMatrix, &mut [[f64; 3]]) -> R,
) -> R {
    let order = matrix.order().to_vec();
    let mut in_order: Vec<_> = order.iter().map(|i| x[*i]).collect();
    let result = f(matrix, &mut in_order);
    for (of_place, &i) in in_order.iter().zip(&order) {
        x[i] = *of_place;
    }
    result
}

/// The numbers of all bodies in one column.
fn column(x: &[[f64; 3]]) -> DVector<f64> {
    DVector::from_column_slice(x.as_flattened())
}

fn right_side(bodies: usize) -> Vec<[f64; 3]> {
    (0..bodies).map(|i| [1.0, (i % 7) as f64 - 3.0, 0.1 * (i % 11) as f64]).collect()
}

fn samples() -> impl Strategy<Value = Sample> {
    let row = || prop::array::uniform3(prop::array::uniform2(-1.0..1.0_f64));
    let interaction = (any::<(u32, u32)>(), row(), row(), 0.0..1.0_f64, -1.0..1.0_f64, -3..4_i32);
    // A body that nearly all others touch, as a wall, in every other sample.
    (1..120_usize, prop::collection::vec(interaction, 0..400), 0..7_usize, any::<bool>()).prop_map(
        |(bodies, interactions, spread, wall)| {
            let n = bodies as u32;
            let mut list: Vec<Interaction> = interactions
                .into_iter()
                .map(|((a, b), first, second, shear, mixed, magnitude)| {
                    // Near in their numbers, so that fronts of all sizes come up.
                    let a = a % n;
                    let b = (a + 1 + b % (1 << spread)) % n;
                    let size = 10.0_f64.powi(magnitude);
                    let mixed = mixed * shear.sqrt();
                    ((a, b), [first, second], [[size, mixed * size], [mixed * size, shear * size]])
                })
                .filter(|((a, b), ..)| a != b)
                .collect();
            if wall {
                list.extend((1..n).map(|i| {
                    let rows = [[[1.0, 0.0], [0.0, 1.0], [0.5, 0.0]]; 2];
                    ((i, 0), rows, [[2.0, 0.0], [0.0, 1.0]])
                }));
            }
            Sample {
                weights: (0..bodies).map(|i| 0.1 + (i % 5) as f64).collect(),
                interactions: list,
            }
        },
    )
}

/// Higham's gamma_k = k u/(1 - k u), with u the unit round-off: the relative error of a number that
/// `k` operations have rounded.
fn gamma(k: usize) -> f64 {
    let rounded = k as f64 * 0.5 * f64::EPSILON;
    rounded / (1.0 - rounded)
}

/// A bound of the defect of every row of a computed solution x, of n numbers. It has three parts:
///
/// - factorisation and solves: a Cholesky factorisation solves `(A + E) x = b` exactly, with
///   `|E_ij| <= gamma_(3n+1)/(1 - gamma_(n+1)) sqrt(a_ii a_jj)` (Higham 2002, theorems 10.3
///   to 10.5);
/// - assembly: an entry is a sum of terms `r d r`, four for every interaction, and a weight. With m
///   the maximum number of interactions of a body, no term is rounded more than 4 m + 5 times, here
///   and in the dense matrix: `2 gamma_(4m+5)` times the sum of the magnitudes of the terms;
/// - the product `A x` that the defect is computed with: `gamma_(n+1) |A| |x|`.
fn defect_bound(sample: &Sample, dense: &DMatrix<f64>, x: &DVector<f64>) -> Vec<f64> {
    let n = x.nrows();
    let root = |k: usize| dense[(k, k)].sqrt();
    let sum: f64 = (0..n).map(|k| root(k) * x[(k, 0)].abs()).sum();
    let of_factor = gamma(3 * n + 1) / (1.0 - gamma(n + 1));
    let (terms, interactions) = sample.magnitudes();
    let of_terms = 2.0 * gamma(4 * interactions + 5);
    let bound = |k: usize| {
        let row = (0..n)
            .map(|l| (of_terms * terms[(k, l)] + gamma(n + 1) * dense[(k, l)].abs()) * x[l].abs());
        of_factor * root(k) * sum + row.sum::<f64>()
    };
    (0..n).map(bound).collect()
}

/// Maximum defect of a row over its bound: at most 1 for a solution.
fn relative_defect(sample: &Sample, dense: &DMatrix<f64>, x: &[[f64; 3]]) -> f64 {
    let solution = column(x);
    let product = dense * &solution;
    let right = right_side(x.len());
    let defect = |k: usize| (product[k] - right[k / 3][k % 3]).abs();
    let bounds = defect_bound(sample, dense, &solution);
    bounds.iter().enumerate().map(|(k, bound)| defect(k) / bound).fold(0.0, f64::max)
}

proptest! {
    // Fixed seeds: a run is repeatable, and the bounds hold for any seed.
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::with_cases(300)
    })]

    #[test]
    fn solutions_are_those_of_a_dense_factorisation(sample in samples()) {
        let n = sample.weights.len();
        let dense = sample.dense();
        let right = column(&right_side(n));
        let expected = dense.clone().cholesky().expect("positive definite").solve(&right);
        let mut matrix = sample.matrix();
        let mut x = right_side(n);
        prop_assert!(factorise_and_solve(&mut matrix, &mut x));
        prop_assert!(relative_defect(&sample, &dense, &x) <= 1.0);
        // Both solutions have a defect within its bound, and the eigenvalues of the matrix are at
        // least its minimum weight: their difference is the inverse times the difference of the
        // defects.
        let solution = column(&x);
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let defects = norm(&defect_bound(&sample, &dense, &solution))
            + norm(&defect_bound(&sample, &dense, &expected));
        let weight = sample.weights.iter().copied().fold(f64::INFINITY, f64::min);
        let error = (&solution - &expected).norm();
        prop_assert!(error <= defects / weight, "{error:e} above {:e}", defects / weight);
        // The same factor once more, on its own.
        let mut again = right_side(n);
        in_its_order(&mut matrix, &mut again, BodyMatrix::solve);
        prop_assert_eq!(x, again);
    }

    /// A matrix that is not positive definite is refused, and the right side stays; with a greater
    /// diagonal it is factorised.
    #[test]
    fn what_is_not_positive_definite_is_refused(sample in samples(), which in any::<usize>()) {
        let n = sample.weights.len();
        let mut matrix = sample.matrix();
        let place = matrix.order().iter().position(|i| *i == which % n).expect("its place");
        matrix.assembly().add_diagonal(place, which % 3, -1e7);
        let mut x = right_side(n);
        prop_assert!(!factorise_and_solve(&mut matrix, &mut x));
        prop_assert_eq!(&x, &right_side(n));

        matrix.assembly().add_diagonal(place, which % 3, 2e7);
        prop_assert!(factorise_and_solve(&mut matrix, &mut x));
        let mut dense = sample.dense();
        dense[(3 * (which % n) + which % 3, 3 * (which % n) + which % 3)] += 1e7;
        // The two shifts here and the one in the dense matrix are three more roundings of a
        // diagonal of 1e7, beside the 3 n + 1 >= 10 that the bound has for it.
        prop_assert!(relative_defect(&sample, &dense, &x) <= 1.3);

        matrix.assembly().add_diagonal(place, which % 3, f64::NAN);
        let mut x = right_side(n);
        prop_assert!(!factorise_and_solve(&mut matrix, &mut x));
        prop_assert_eq!(x, right_side(n));
    }
}

/// Stiffnesses that differ by 1e16, as those of active and inactive contacts do in the
/// interior-point method.
#[test]
fn contrast_of_stiffness_does_not_cost_backward_stability() {
    let bodies: usize = 400;
    let interactions: Vec<Interaction> = (0..bodies as u32)
        .flat_map(|i| [(i, i + 1), (i, i + 20)])
        .filter(|(_, b)| *b < 400)
        .enumerate()
        .map(|(k, pair)| {
            let angle = k as f64;
            let (s, c) = angle.sin_cos();
            let rows = [[[c, -s], [s, c], [0.0, 0.5]], [[-c, s], [-s, -c], [0.0, 0.5]]];
            (pair, rows, [[10.0_f64.powi((k % 17) as i32 - 8), 0.0], [0.0, 1e-4]])
        })
        .collect();
    let sample = Sample { weights: vec![1e-6; bodies], interactions };
    let dense = sample.dense();
    let mut x = right_side(bodies);
    assert!(factorise_and_solve(&mut sample.matrix(), &mut x));
    let error = relative_defect(&sample, &dense, &x);
    assert!(error <= 1.0, "{error:e}");
    // The bound refuses a solution that is 1 % off, although the norm of the matrix is 1e8.
    let off: Vec<_> = x.iter().map(|x| x.map(|x| 1.01 * x)).collect();
    let error = relative_defect(&sample, &dense, &off);
    assert!(error > 1.0, "{error:e}");
}

/// Two sets of bodies in which all touch each other share half of their bodies. This gives a front
/// that is large enough for copies in chunks, with a parent of the same size and with children.
#[test]
fn a_large_front() {
    let spring = |k: u32| {
        let (s, c) = f64::from(k).sin_cos();
        ([[[c, -s], [s, c], [0.1, 0.5]], [[-c, s], [-s, -c], [0.2, 0.5]]], [[1.0, 0.2], [0.2, 0.3]])
    };
    for crowd in [20, 100, 101, 102, 103, 130_u32] {
        let crowds =
            |shift: u32| (0..crowd).flat_map(move |a| (0..a).map(move |b| (a + shift, b + shift)));
        let end = crowd + crowd / 2;
        let hanging = (end..end + 90).map(|a| (a, a - end));
        let interactions: Vec<Interaction> = crowds(0)
            .chain(crowds(crowd / 2))
            .chain(hanging)
            .enumerate()
            .map(|(k, pair)| {
                let (rows, d) = spring(k as u32);
                (pair, rows, d)
            })
            .collect();
        let bodies = end as usize + 90;
        let sample = Sample { weights: vec![1e-3; bodies], interactions };
        let mut x = right_side(bodies);
        assert!(factorise_and_solve(&mut sample.matrix(), &mut x));
        let error = relative_defect(&sample, &sample.dense(), &x);
        assert!(error <= 1.0, "{crowd} bodies: {error:e}");
    }
}

/// A graph large enough for several threads: no pair joins two branches, and the solution is that
/// of all its rows on any number of threads, byte for byte.
#[test]
fn several_threads() {
    // A square of 72 x 72 bodies, a body that touches one side of it, and a few that touch nothing.
    let side: u32 = 72;
    let wall = side * side;
    let spring = |angle: f64, size: f64| {
        let (s, c) = angle.sin_cos();
        let rows = [[[c, -s], [s, c], [0.0, 0.5]], [[-c, s], [-s, -c], [0.0, 0.5]]];
        (rows, [[size, 0.0], [0.0, 0.3 * size]])
    };
    let interactions: Vec<Interaction> = (0..wall)
        .flat_map(|i| [(i, i + 1, i % side < side - 1), (i, i + side, i + side < wall)])
        .chain((0..side).map(|i| (i, wall, true)))
        .filter(|(.., is_pair)| *is_pair)
        .map(|(a, b, _)| {
            let (rows, d) = spring(f64::from(a + 3 * b), 10.0_f64.powi((a % 9) as i32 - 4));
            ((a, b), rows, d)
        })
        .collect();
    let bodies = wall as usize + 5;
    let sample = Sample { weights: vec![1e-3; bodies], interactions };
    let matrix = sample.matrix();
    let branches = matrix.branches();
    assert!(branches.len() > 8, "{branches:?}");
    let within: usize = branches.iter().map(ExactSizeIterator::len).sum();
    assert!(within > bodies / 2 && branches.is_sorted_by(|a, b| a.end <= b.start), "{branches:?}");
    assert!(branches.iter().all(|branch| branch.len() <= bodies / 16), "{branches:?}");
    let mut place = vec![0; bodies];
    for (k, &body) in matrix.order().iter().enumerate() {
        place[body] = k;
    }
    let branch_of = |body: u32| branches.iter().position(|b| b.contains(&place[body as usize]));
    for ((a, b), ..) in &sample.interactions {
        let [a, b] = [*a, *b].map(branch_of);
        assert!(a == b || a.is_none() || b.is_none());
    }
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut matrix = sample.matrix();
            let (mut x, mut again) = (right_side(bodies), right_side(bodies));
            assert!(factorise_and_solve(&mut matrix, &mut x));
            in_its_order(&mut matrix, &mut again, BodyMatrix::solve);
            assert_eq!(x, again);
            // Not positive definite in the first front, and in the last.
            for place in [0, bodies - 1] {
                let mut matrix = sample.matrix();
                matrix.assembly().add_diagonal(place, 1, -1e9);
                let mut right = right_side(bodies);
                assert!(!matrix.factorise_and_solve(&mut right));
                assert_eq!(right, right_side(bodies));
            }
            x
        })
    };
    let one = on(1);
    for threads in [2, 5] {
        assert_eq!(on(threads), one);
    }
    let error = relative_defect(&sample, &sample.dense(), &one);
    assert!(error <= 1.0, "{error:e}");
}

/// Trees of fronts that are as deep as there are bodies, or as wide, solved on two threads, whose
/// stacks are small. The graphs are a chain of bodies, a chain of small squares, and a body with
/// many chains.
#[test]
fn long_chains_of_fronts_do_not_overflow_the_stack() {
    let count: u32 = 60_000;
    let chain: Vec<(u32, u32)> = (0..count - 1).map(|i| (i, i + 1)).collect();
    let squares = (0..count - 3).step_by(3);
    let squares = squares.flat_map(|i| [(i, i + 1), (i, i + 2), (i + 1, i + 3), (i + 2, i + 3)]);
    let star = (1..count).map(|i| (if i % 60 == 1 { 0 } else { i - 1 }, i));
    let (rows, d) = ([[[1.0, 0.0], [0.0, 1.0], [0.5, 0.0]]; 2], [[2.0, 0.0], [0.0, 1.0]]);
    for pairs in [chain, squares.collect(), star.collect()] {
        let on = |threads: usize| {
            let stack = 256 << 10;
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(stack);
            pool.build().unwrap().install(|| {
                let mut matrix = BodyMatrix::new(count as usize, &pairs);
                let mut values = matrix.assembly();
                (0..count as usize)
                    .for_each(|i| (0..3).for_each(|k| values.add_diagonal(i, k, 1.0)));
                (0..pairs.len()).for_each(|k| values.add(k, &rows, &d));
                let mut x = right_side(count as usize);
                assert!(factorise_and_solve(&mut matrix, &mut x));
                x
            })
        };
        assert!(on(2) == on(1));
    }
}

/// Bodies that touch nothing are in subtrees of their own, and a pair that is there twice counts
/// twice.
#[test]
fn bodies_that_touch_little() {
    let (rows, d) = ([[[1.0, 0.0], [0.0, 1.0], [0.5, 0.0]]; 2], [[2.0, 0.0], [0.0, 1.0]]);
    for interactions in [vec![], vec![((0, 1199), rows, d), ((1199, 0), rows, d)]] {
        let sample = Sample { weights: vec![4.0; 1200], interactions };
        let mut x = right_side(1200);
        assert!(factorise_and_solve(&mut sample.matrix(), &mut x));
        let error = relative_defect(&sample, &sample.dense(), &x);
        assert!(error <= 1.0, "{error:e}");
        assert_eq!(x[7], right_side(1200)[7].map(|b| b / 4.0));
    }
}

/// A scene of one body has one front without rows.
#[test]
fn one_body() {
    let sample = Sample { weights: vec![4.0], interactions: Vec::new() };
    let mut x = vec![[8.0, -2.0, 1.0]];
    assert!(factorise_and_solve(&mut sample.matrix(), &mut x));
    assert_eq!(x, [[2.0, -0.5, 0.25]]);
}

/// Neither does one without bodies fail.
#[test]
fn no_body() {
    let mut none: Vec<[f64; 3]> = Vec::new();
    let sample = Sample { weights: Vec::new(), interactions: Vec::new() };
    assert!(factorise_and_solve(&mut sample.matrix(), &mut none));
}
