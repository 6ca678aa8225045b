//! The condensed matrix: one block of three unknowns per body. It is symmetric positive definite
//! under the associated law and factorised by a multifrontal Cholesky method (Duff and Reid 1983; Liu
//! 1992); under Coulomb's law it is not symmetric and the method is LU on the same fronts.
//!
//! Its pattern is the graph of bodies and interactions. The order of elimination (approximate
//! minimum degree) and the fronts are kept as long as the pattern stays. Most fronts have a handful
//! of bodies, and the three unknowns per body are known to the compiler: the factorisation is two
//! to four times as fast as one for general matrices (decision 005).

mod assembly;
mod cholesky;
mod dense;
mod factor;
mod fronts;
mod layout;
mod lu;
mod merge;
mod packed;
mod share;
mod tasks;

use std::ops::Range;

pub use self::assembly::Assembly;
use self::assembly::{Block, DIAGONAL};
pub(crate) use self::cholesky::Cholesky;
use self::factor::{Arithmetic, Factor, Values};
use self::fronts::Fronts;
use self::layout::PairPlace;
pub(super) use self::layout::places;
use self::lu::Lu;
use super::images::{self, Images};
use super::interior::max_magnitude;
use super::parallel::{in_pool, split};
use super::scaled::{Scaled, add_times};
use crate::program::ConeProgram;

/// Shifts of the diagonal, over its maximum, that make up for round-off: a hundred times the unit
/// round-off, and more where that is not enough.
const SHIFTS: [f64; 3] = [1e-14, 1e-12, 1e-10];

/// Maximum number of refinements of a linear solve.
const MAX_REFINEMENTS: usize = 8;

/// A matrix, its factor, and the data that depend on its pattern only.
pub struct Matrix<A: Arithmetic> {
    /// The pairs of bodies that it was made for.
    given: Vec<(u32, u32)>,
    fronts: Fronts,
    /// Places of the pairs, in the order given.
    places: Vec<PairPlace>,
    /// Blocks of bodies in the order of elimination, and of pairs front by front.
    bodies: Vec<Block>,
    pairs: Vec<A::Pair>,
    factor: Factor<A>,
    images: Images,
}

/// The condensed matrix.
pub type BodyMatrix = Matrix<Cholesky>;

/// An unsymmetric matrix with the same pattern, factorised by a multifrontal LU method (Davis and
/// Duff 1997) on the fronts of the symmetric pattern.
///
/// Rows are exchanged among the pivots of a front only, so that the fronts do not depend on the
/// values. This costs accuracy, which the caller recovers by iterative refinement. The sign of the
/// determinant comes with the factor.
pub(crate) type UnsymmetricMatrix = Matrix<Lu>;

impl<A: Arithmetic> Default for Matrix<A> {
    fn default() -> Self {
        Self::new(0, &[])
    }
}

impl<A: Arithmetic> Matrix<A> {
    /// The pattern of `bodies` bodies coupled by `pairs`.
    ///
    /// # Panics
    /// If a pair has a body that is not one of them.
    pub fn new(bodies: usize, pairs: &[(u32, u32)]) -> Self {
        let (fronts, places) = layout::of_pairs(bodies, pairs);
        Self {
            given: pairs.to_vec(),
            places,
            bodies: vec![Block::default(); bodies],
            pairs: vec![A::Pair::default(); pairs.len()],
            factor: Factor::new(&fronts),
            fronts,
            images: Images::default(),
        }
    }

    /// Bodies in the order of elimination. All other functions number bodies by this order.
    pub fn order(&self) -> &[usize] {
        &self.fronts.order
    }

    /// A program in the order of elimination. Its pattern is taken over, unless the matrix has it
    /// already, and its images, which [`Assembly::add`] needs for interactions with them.
    pub(crate) fn pose(&mut self, program: &ConeProgram) -> Scaled {
        let bodies = program.bodies.len();
        let pairs = images::pairs(program);
        if self.bodies.len() != bodies || !pairs.clone().eq(self.given.iter().copied()) {
            *self = Self::new(bodies, &pairs.collect::<Vec<_>>());
        }
        let scaled = Scaled::new(program, self.order());
        self.images.clone_from(&scaled.images);
        scaled
    }

    /// Whether there is work for several threads.
    pub(crate) fn is_shared(&self) -> bool {
        self.factor.is_shared()
    }

    /// Number of tasks into which the tree of fronts is cut for several threads.
    pub fn tasks(&self) -> usize {
        self.fronts.tasks.len()
    }

    /// Work of the longest path of the tree of fronts over that of the whole tree, where `threads`
    /// threads share the work on large fronts: a lower bound of the part of the time that they take.
    pub fn longest_path(&self, threads: usize) -> f64 {
        self.fronts.longest_path(threads)
    }

    /// Ranges of bodies, in the order of elimination, that no pair joins: several threads can work
    /// on them at once. Empty if the work is too small for that.
    pub fn branches(&self) -> Vec<Range<usize>> {
        self.extents().into_iter().map(|[bodies, _]| bodies).collect()
    }

    /// Ranges of bodies and of pairs of every branch.
    fn extents(&self) -> Vec<[Range<usize>; 2]> {
        let Fronts { tasks, pair_starts, .. } = &self.fronts;
        let of = |branch: Range<usize>| {
            let (first, last) = (&tasks[branch.start], &tasks[branch.end - 1]);
            [
                first.places.start..last.places.end,
                pair_starts[first.fronts.start]..pair_starts[last.fronts.end],
            ]
        };
        self.fronts.branches().into_iter().map(of).collect()
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.bodies.fill(Block::default());
        self.pairs.fill(A::Pair::default());
    }

    /// Access to all values, to add to them.
    pub fn assembly(&mut self) -> Assembly<'_, A> {
        let Self { bodies, pairs, places, images, .. } = self;
        Assembly { bodies, pairs, first: [0; 2], places, images }
    }

    /// Access to the values of each of the [branches](Self::branches), to add to them.
    pub fn assemblies(&mut self) -> Vec<Assembly<'_, A>> {
        let extents = self.extents();
        let Self { bodies, pairs, places, images, .. } = self;
        let bodies = split(bodies, extents.iter().map(|[bodies, _]| bodies.clone()));
        let pairs = split(pairs, extents.iter().map(|[_, pairs]| pairs.clone()));
        let assembly = |((bodies, pairs), [b, p]): (_, &[Range<usize>; 2])| Assembly {
            bodies,
            pairs,
            first: [b.start, p.start],
            places,
            images,
        };
        bodies.into_iter().zip(pairs).zip(&extents).map(assembly).collect()
    }

    /// Factorises, with the forward solve of a right side; whether there is a factor.
    fn factorise_with(&mut self, right: Option<&[[f64; 3]]>) -> bool {
        let Self { fronts, bodies, pairs, factor, .. } = self;
        factor.factorise(fronts, Values { bodies, pairs }, right)
    }

    /// Solves in place with the last factor, after the factorisation has returned true. `x` has the
    /// bodies in the order of elimination, and then the images of the program.
    pub fn solve(&mut self, x: &mut [[f64; 3]]) {
        let Self { fronts, factor, .. } = self;
        in_pool(factor.is_shared(), || {
            factor.forward(fronts, x);
            factor.backward(fronts, x);
        });
        self.images.spread(x);
    }

    /// Refines a solution until its defect is at most `enough` or a refinement does not halve it:
    /// round-off of the factor must not become an error of the step. `set` sets the defect of a
    /// solution, in the rows of bodies and images.
    pub(crate) fn refine(
        &mut self,
        enough: f64,
        x: &mut [[f64; 3]],
        defect: &mut [[f64; 3]],
        mut set: impl FnMut(&[[f64; 3]], &mut [[f64; 3]]),
    ) {
        let mut last = f64::INFINITY;
        for _ in 0..MAX_REFINEMENTS {
            set(x, defect);
            self.images.fold(defect);
            let now = max_magnitude(&defect[..self.bodies.len()]);
            if now <= enough || !(now <= 0.5 * last) {
                return;
            }
            last = now;
            self.solve(defect);
            add_times(x.as_flattened_mut(), 1.0, defect.as_flattened());
        }
    }
}

impl BodyMatrix {
    /// Maximum value on the diagonal.
    pub(crate) fn max_diagonal(&self) -> f64 {
        let on_diagonal = |block: &Block| DIAGONAL.map(|k| block[k]);
        self.bodies.iter().flat_map(on_diagonal).fold(0.0, f64::max)
    }

    /// Factorises, and solves in place as [`solve`](Self::solve); whether the matrix was positive
    /// definite. If not, `x` stays as it was.
    #[must_use = "without a factor the right side is where the solution would be"]
    pub fn factorise_and_solve(&mut self, x: &mut [[f64; 3]]) -> bool {
        let definite = self.factorise_with(Some(x));
        if definite {
            self.factor.backward(&self.fronts, x);
            self.images.spread(x);
        }
        definite
    }

    /// As [`factorise_and_solve`](Self::factorise_and_solve), with a larger diagonal where
    /// round-off has cost the matrix its positive definiteness.
    #[must_use = "without a factor the right side is where the solution would be"]
    pub(crate) fn factorise_shifted_and_solve(&mut self, x: &mut [[f64; 3]]) -> bool {
        let maximum = self.max_diagonal();
        let mut shifts = SHIFTS.into_iter();
        while !self.factorise_and_solve(x) {
            let Some(shift) = shifts.next() else { return false };
            for block in &mut self.bodies {
                for k in DIAGONAL {
                    block[k] += shift * maximum;
                }
            }
        }
        true
    }
}

impl UnsymmetricMatrix {
    /// Factorises; whether all pivots are finite and none is zero.
    pub fn factorise(&mut self) -> bool {
        in_pool(self.is_shared(), || self.factorise_with(None))
    }

    /// Sign of the determinant of the matrix that was factorised last.
    pub fn sign(&self) -> f64 {
        self.factor.parts().map(|part| part.sign).product()
    }
}
