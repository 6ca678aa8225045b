//! The interactions by branches of the body matrix, so that several threads pass over them at once.
//!
//! Interactions within a branch touch no body and no block of the matrix of another branch.
//! The other interactions come after all branches. Sums are over the branches in their order,
//! whatever the number of threads.

use std::ops::{Add, Range};

use super::super::matrix::{Assembly, BodyMatrix, Cholesky};
use super::super::parallel::{in_parallel, split};
use super::super::scaled::Scaled;
use super::super::settings::InteriorSettings;
use super::cell::Cells;
use super::law::Rows;

/// Interactions by branch.
pub struct Groups {
    branches: Vec<Cells>,
    /// Bodies of each branch.
    bodies: Vec<Range<usize>>,
    /// Interactions that touch a body outside of the branches.
    rest: Cells,
}

impl Groups {
    /// All interactions, near the elastic trial at the starting displacements.
    pub fn new(
        program: &Scaled,
        matrix: &BodyMatrix,
        u: &[[f64; 3]],
        settings: &InteriorSettings,
    ) -> Self {
        let bodies = matrix.branches();
        let mut branches: Vec<Cells> = bodies.iter().map(|_| Cells::default()).collect();
        let mut rest = Cells::default();
        for (number, local) in program.locals.iter().enumerate() {
            let [a, b] = local.arms.bodies.map(|i| i as usize);
            let branch = bodies.partition_point(|branch| branch.end <= a);
            let holds = |bodies: &Range<usize>| bodies.contains(&a) && bodies.contains(&b);
            let is_within = bodies.get(branch).is_some_and(holds);
            let cells = if is_within { &mut branches[branch] } else { &mut rest };
            cells.push(number, local, u, settings);
        }
        Self { branches, bodies, rest }
    }

    /// The interactions branch by branch, then the others.
    pub fn all(&mut self) -> impl Iterator<Item = &mut Cells> {
        self.branches.iter_mut().chain([&mut self.rest])
    }

    /// Calls `f` for the interactions of every group with a sum of its own, and adds the sums to
    /// `start`.
    pub fn sum<R: Default + Add<Output = R> + Send>(
        &mut self,
        start: R,
        f: impl Fn(&mut Cells, &mut R) + Sync + Send,
    ) -> R {
        let sums = in_parallel(self.all(), |cells| {
            let mut sum = R::default();
            f(cells, &mut sum);
            sum
        });
        sums.into_iter().fold(start, R::add)
    }

    /// Calls `f` for the interactions of every group with the `rows` of their bodies.
    pub fn scatter<R: Send>(
        &mut self,
        rows: &mut [[f64; 3]],
        f: impl Fn(&mut Cells, &mut Rows) -> R + Sync + Send,
    ) -> Vec<R> {
        let items = self.branches.iter_mut().zip(pieces(&self.bodies, rows));
        let mut results = in_parallel(items, |(cells, mut rows)| f(cells, &mut rows));
        results.push(f(&mut self.rest, &mut Rows { first: 0, rows }));
        results
    }

    /// Calls `f` for the interactions of every group with two sets of rows of their bodies and
    /// their part of the matrix.
    pub(crate) fn condense(
        &mut self,
        matrix: &mut BodyMatrix,
        [a, b]: [&mut [[f64; 3]]; 2],
        f: impl Fn(&mut Cells, &mut Assembly<Cholesky>, &mut [Rows; 2]) + Sync + Send,
    ) {
        let rows = pieces(&self.bodies, a).into_iter().zip(pieces(&self.bodies, b));
        let items = self.branches.iter_mut().zip(rows).zip(matrix.assemblies());
        in_parallel(items, |((cells, (a, b)), mut values)| f(cells, &mut values, &mut [a, b]));
        let mut rows = [a, b].map(|rows| Rows { first: 0, rows });
        f(&mut self.rest, &mut matrix.assembly(), &mut rows);
    }
}

/// The rows of the bodies of each branch.
fn pieces<'a>(bodies: &[Range<usize>], rows: &'a mut [[f64; 3]]) -> Vec<Rows<'a>> {
    let firsts = bodies.iter().map(|bodies| bodies.start as u32);
    let pieces = firsts.zip(split(rows, bodies.iter().cloned()));
    pieces.map(|(first, rows)| Rows { first, rows }).collect()
}
