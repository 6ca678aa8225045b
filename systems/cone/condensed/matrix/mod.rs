//! The condensed matrix: one symmetric positive definite block of three unknowns per body,
//! factorised by a multifrontal Cholesky method (Duff and Reid 1983; Liu 1992).
//!
//! Its pattern is the graph of bodies and interactions. The order of elimination (approximate
//! minimum degree on that graph) and the fronts are kept as long as the pattern stays. Most fronts
//! have a handful of bodies, and the number of three unknowns per body is known to the compiler.
//! The factorisation is therefore two to four times as fast as one for general matrices (decision
//! 005).

mod assembly;
mod cholesky;
mod dense;
mod factor;
mod fronts;
mod layout;
mod lu;
mod lu_fronts;
mod merge;
mod ordering;
mod packed;
mod schedule;
mod share;
mod tasks;
mod unsymmetric;

use std::ops::Range;

pub use self::assembly::Assembly;
use self::assembly::PairPlace;
use self::cholesky::{Cholesky, DIAGONAL, PAIR, Pattern};
use self::factor::Factor;
use self::layout::Placed;
pub(super) use self::ordering::places;
pub use self::unsymmetric::UnsymmetricMatrix;
use super::images::Images;
use super::parallel::split;

/// Shifts of the diagonal, over its maximum, that make up for round-off: a hundred times the unit
/// round-off, and more where that is not enough.
const SHIFTS: [f64; 3] = [1e-14, 1e-12, 1e-10];

/// The matrix, its factor, and the data that depend on its pattern only.
pub struct BodyMatrix {
    /// Blocks of the lower triangle, front by front: those of the diagonal, then those of pairs.
    values: Vec<f64>,
    /// Start of the diagonal block of every body in the values.
    diagonal: Vec<usize>,
    /// Places of the pairs, in the order given.
    pairs: Vec<PairPlace>,
    pattern: Pattern,
    factor: Factor<Cholesky>,
    images: Images,
}

impl BodyMatrix {
    /// The pattern of `bodies` bodies coupled by `pairs`; `None` if faer finds no order for it.
    #[must_use]
    pub fn new(bodies: usize, pairs: &[(u32, u32)]) -> Option<Self> {
        let (fronts, placed) = layout::of_pairs(bodies, pairs)?;
        let mut diagonal = Vec::with_capacity(bodies);
        let mut places = vec![PairPlace::default(); pairs.len()];
        let mut targets = Vec::with_capacity(pairs.len());
        let mut target_starts = Vec::with_capacity(fronts.list.len() + 1);
        let mut starts = Vec::with_capacity(fronts.list.len() + 1);
        let mut start = 0;
        for (front, placed) in fronts.list.iter().zip(&placed) {
            starts.push(start);
            target_starts.push(targets.len());
            for _ in front.pivots.clone() {
                diagonal.push(start);
                start += DIAGONAL;
            }
            for &Placed { pair, places: bodies, rows } in placed {
                let forward = bodies[0] < bodies[1];
                places[pair as usize] = PairPlace { start, forward, bodies };
                start += PAIR;
                let [column, row] = if forward { rows } else { [rows[1], rows[0]] };
                targets.push(3 * column * front.height() as u32 + 3 * row);
            }
        }
        starts.push(start);
        target_starts.push(targets.len());
        Some(Self {
            values: vec![0.0; start],
            diagonal,
            pairs: places,
            factor: Factor::new(&fronts),
            pattern: Pattern { fronts, starts, targets, target_starts },
            images: Images::default(),
        })
    }

    /// Number of bodies.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.diagonal.len()
    }

    /// Bodies in the order of elimination. All other functions number bodies by this order.
    #[must_use]
    pub fn order(&self) -> &[usize] {
        &self.pattern.fronts.order
    }

    /// Whether there is work for several threads.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        self.factor.is_shared()
    }

    /// Number of tasks into which the tree of fronts is cut for several threads.
    #[must_use]
    pub fn tasks(&self) -> usize {
        self.pattern.fronts.tasks.len()
    }

    /// Work of the longest path of the tree of fronts over that of the whole tree, where `threads`
    /// threads share the work on large fronts: a lower bound of the part of the time that they take.
    #[must_use]
    pub fn longest_path(&self, threads: usize) -> f64 {
        self.pattern.fronts.longest_path(threads)
    }

    /// Ranges of bodies, in the order of elimination, that no pair joins: several threads can work
    /// on them at once. Empty if the work is too small for that.
    #[must_use]
    pub fn branches(&self) -> Vec<Range<usize>> {
        let tasks = &self.pattern.fronts.tasks;
        let branches = self.pattern.fronts.branches();
        let places = |b: Range<usize>| tasks[b.start].places.start..tasks[b.end - 1].places.end;
        branches.into_iter().map(places).collect()
    }

    /// Takes over the images of a program, which [`Assembly::add`] needs for interactions with
    /// them.
    pub fn set_images(&mut self, images: &Images) {
        self.images.clone_from(images);
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Access to all values, to add to them.
    pub fn assembly(&mut self) -> Assembly<'_> {
        let Self { values, diagonal, pairs, images, .. } = self;
        Assembly { values, first: 0, diagonal, pairs, images }
    }

    /// Access to the values of each of the [branches](Self::branches), to add to them.
    pub fn assemblies(&mut self) -> Vec<Assembly<'_>> {
        let Self { values, pattern, diagonal, pairs, images, .. } = self;
        let branches = pattern.fronts.branches();
        let fronts = |task: usize| &pattern.fronts.tasks[task].fronts;
        let ranges = branches.iter().map(|branch| {
            pattern.starts[fronts(branch.start).start]..pattern.starts[fronts(branch.end - 1).end]
        });
        let pieces = split(values, ranges.clone()).into_iter().zip(ranges);
        let assembly = |(values, range): (_, Range<_>)| Assembly {
            values,
            first: range.start,
            diagonal,
            pairs,
            images,
        };
        pieces.map(assembly).collect()
    }

    /// Maximum value on the diagonal.
    #[must_use]
    pub fn max_diagonal(&self) -> f64 {
        let on_diagonal = self.diagonal.iter().flat_map(|start| [0, 3, 5].map(|k| start + k));
        on_diagonal.map(|k| self.values[k]).fold(0.0, f64::max)
    }

    /// Factorises, and solves in place; whether the matrix was positive definite. If not, `x` stays
    /// as it was. `x` is in the order of elimination.
    #[must_use = "without a factor the right side is where the solution would be"]
    pub fn factorise_and_solve(&mut self, x: &mut [[f64; 3]]) -> bool {
        let Self { values, pattern, factor, .. } = self;
        let definite = factor.factorise(&pattern.fronts, (pattern, values), Some(x));
        if definite {
            factor.backward(&pattern.fronts, x);
        }
        definite
    }

    /// As [`factorise_and_solve`](Self::factorise_and_solve), with a larger diagonal where
    /// round-off has cost the matrix its positive definiteness.
    #[must_use = "without a factor the right side is where the solution would be"]
    pub fn factorise_shifted_and_solve(&mut self, x: &mut [[f64; 3]]) -> bool {
        if self.factorise_and_solve(x) {
            return true;
        }
        let maximum = self.max_diagonal();
        for shift in SHIFTS {
            let bodies = self.bodies();
            let mut values = self.assembly();
            for body in 0..bodies {
                for k in 0..3 {
                    values.add_diagonal(body, k, shift * maximum);
                }
            }
            if self.factorise_and_solve(x) {
                return true;
            }
        }
        false
    }

    /// Solves in place with the last factor, after `factorise_and_solve` has returned true. `x` is
    /// in the order of elimination.
    pub fn solve(&mut self, x: &mut [[f64; 3]]) {
        let Self { pattern: Pattern { fronts, .. }, factor, .. } = self;
        factor.forward(fronts, x);
        factor.backward(fronts, x);
    }
}
