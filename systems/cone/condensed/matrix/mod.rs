//! The condensed matrix: one symmetric positive definite block of three unknowns per body,
//! factorised by a multifrontal Cholesky method (Duff and Reid 1983; Liu 1992).
//!
//! Its pattern is the graph of bodies and interactions. The order of elimination (approximate
//! minimum degree on that graph) and the fronts are kept as long as the pattern stays. Most fronts
//! have a handful of bodies, and the number of three unknowns per body is known to the compiler.
//! The factorisation is therefore two to four times as fast as one for general matrices (decision
//! 005).

mod assembly;
mod dense;
mod fronts;
mod layout;
mod lu;
mod merge;
mod numeric;
mod ordering;
mod packed;
mod pattern;
mod schedule;
mod share;
mod tasks;
mod unsymmetric;
mod updates;
mod work;

use std::ops::Range;

use pulp::Arch;

pub use self::assembly::Assembly;
use self::assembly::PairPlace;
use self::numeric::{Backward, Current, Eliminate, Forward, Part};
pub(super) use self::ordering::places;
use self::pattern::{DIAGONAL, PAIR, Pattern};
use self::schedule::{downward, upward};
use self::share::dispatch;
pub use self::unsymmetric::UnsymmetricMatrix;
use self::updates::factorise;
use self::work::{copy_from_above, gather_below};
use super::images::Images;
use super::parallel::{Lent, split};
use crate::adjacency::Adjacency;

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
    parts: Vec<Part>,
    current: Lent<Current>,
    updates: Lent<Vec<f64>>,
    images: Images,
    instructions: Arch,
}

impl BodyMatrix {
    /// The pattern of `bodies` bodies coupled by `pairs`; `None` if faer finds no order for it.
    #[must_use]
    pub fn new(bodies: usize, pairs: &[(u32, u32)]) -> Option<Self> {
        let neighbours = Adjacency::of_neighbours(bodies, pairs);
        let order = ordering::minimum_degree(&neighbours)?;
        let fronts = layout::fronts(&order, &neighbours);

        let place = places(&fronts.order);
        let mut front_of = vec![0; bodies];
        for task in &fronts.tasks {
            for number in task.fronts.clone() {
                let pivots = fronts.list[number].pivots.clone();
                front_of[task.places.start..][pivots].fill(number);
            }
        }
        let mut of_front = vec![Vec::new(); fronts.list.len()];
        for (number, &(a, b)) in pairs.iter().enumerate() {
            let (a, b) = (place[a as usize], place[b as usize]);
            of_front[front_of[a.min(b)]].push((number, a, b));
        }
        let mut diagonal = Vec::with_capacity(bodies);
        let mut places = vec![PairPlace::default(); pairs.len()];
        let mut targets = Vec::with_capacity(pairs.len());
        let mut target_starts = Vec::with_capacity(fronts.list.len() + 1);
        let mut starts = Vec::with_capacity(fronts.list.len() + 1);
        let mut start = 0;
        for task in &fronts.tasks {
            for number in task.fronts.clone() {
                let front = &fronts.list[number];
                starts.push(start);
                target_starts.push(targets.len());
                for _ in front.pivots.clone() {
                    diagonal.push(start);
                    start += DIAGONAL;
                }
                for &(pair, a, b) in &of_front[number] {
                    let bodies = [a as u32, b as u32];
                    places[pair] = PairPlace { start, forward: a < b, bodies };
                    start += PAIR;
                    let [column, row] = fronts.in_front(task, front, [a.min(b), a.max(b)]);
                    targets.push((3 * column * front.height() + 3 * row) as u32);
                }
            }
        }
        starts.push(start);
        target_starts.push(targets.len());
        Some(Self {
            values: vec![0.0; start],
            diagonal,
            pairs: places,
            parts: (0..fronts.tasks.len()).map(|task| Part::new(&fronts, task)).collect(),
            current: Lent::default(),
            updates: Lent::default(),
            pattern: Pattern { fronts, starts, targets, target_starts },
            images: Images::default(),
            instructions: Arch::new(),
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
        self.parts.len() > 1
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
        let Self { values, pattern, parts, current, updates, instructions, .. } = self;
        let fronts = &pattern.fronts;
        let (right, shared) = (&*x, parts.len() > 1);
        let definite = factorise(fronts, parts, updates, &|task, below, part| {
            let work_of = |other: usize| &below[other + below.len() - task].work[..];
            gather_below(fronts, task, right, work_of, &mut part.work);
            current.with(|current| {
                let work = Eliminate { pattern, values, task, part, below, current };
                dispatch(*instructions, shared, work)
            })
        });
        if definite {
            self.solve_backward(x);
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
        let Self { pattern: Pattern { fronts, .. }, parts, current, instructions, .. } = self;
        let right = &*x;
        upward(&fronts.sizes, parts, &|task, below, part| {
            let work_of = |other: usize| &below[other + below.len() - task].work[..];
            gather_below(fronts, task, right, work_of, &mut part.work);
            current.with(|current| instructions.dispatch(Forward(fronts, task, part, current)));
            true
        });
        self.solve_backward(x);
    }

    fn solve_backward(&mut self, x: &mut [[f64; 3]]) {
        let Self { pattern: Pattern { fronts, .. }, parts, current, instructions, .. } = self;
        let pieces = split(x, fronts.tasks.iter().map(|task| task.places.clone()));
        let mut parts: Vec<_> = parts.iter_mut().zip(pieces).collect();
        downward(&fronts.sizes, &mut parts, &|task, above, (part, x)| {
            if let Some((above, _)) = above {
                copy_from_above(fronts, task, &above.work, &mut part.work);
            }
            current.with(|current| instructions.dispatch(Backward(fronts, task, part, current)));
            x.copy_from_slice(&part.work[..x.len()]);
        });
    }
}
