//! The interactions by branches of the body matrix, so that several threads pass over them at once.
//!
//! Interactions within a branch touch no body and no block of the matrix of another branch.
//! The other interactions come after all branches. Sums are over the branches in their order,
//! whatever the number of threads.

use std::ops::Range;

use super::super::matrix::{Assembly, BodyMatrix};
use super::super::parallel::{in_parallel, split};
use super::super::scaled::Scaled;
use super::super::settings::InteriorSettings;
use super::cell::{Cells, for_each};
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
            let [a, b] = local.bodies.map(|i| bodies.partition_point(|branch| branch.end <= i));
            let branch = bodies.get(a).filter(|branch| a == b && branch.contains(&local.bodies[0]));
            let is_within = branch.is_some_and(|branch| branch.contains(&local.bodies[1]));
            let cells = if is_within { &mut branches[a] } else { &mut rest };
            cells.push(number, local, u, settings);
        }
        Self { branches, bodies, rest }
    }

    /// Maximum normal force.
    pub fn max_force(&mut self) -> f64 {
        let mut maximum = 0.0_f64;
        for cells in self.all() {
            for_each!(cell of cells => maximum = maximum.max(cell.normal_force().abs()));
        }
        maximum
    }

    /// The interactions branch by branch, then the others.
    pub fn all(&mut self) -> impl Iterator<Item = &mut Cells> {
        self.branches.iter_mut().chain([&mut self.rest])
    }

    /// Calls `f` for the interactions of every group and returns the results.
    pub fn each<R: Send>(&mut self, f: impl Fn(&mut Cells) -> R + Sync + Send) -> Vec<R> {
        in_parallel(self.all(), f)
    }

    /// Calls `f` for the interactions of every group with the `rows` of their bodies.
    pub fn scatter<R: Send>(
        &mut self,
        rows: &mut [[f64; 3]],
        f: impl Fn(&mut Cells, &mut Rows) -> R + Sync + Send,
    ) -> Vec<R> {
        let mut results =
            in_parallel(self.with_rows(rows), |(cells, mut rows)| f(cells, &mut rows));
        results.push(f(&mut self.rest, &mut Rows { first: 0, rows }));
        results
    }

    /// Calls `f` for the interactions of every group with two sets of rows of their bodies and
    /// their part of the matrix.
    pub fn condense(
        &mut self,
        matrix: &mut BodyMatrix,
        [a, b]: [&mut [[f64; 3]]; 2],
        f: impl Fn(&mut Cells, &mut Assembly, &mut [Rows; 2]) + Sync + Send,
    ) {
        let pieces = |rows| split(rows, self.bodies.iter().cloned());
        let firsts = self.bodies.iter().map(|bodies| bodies.start as u32);
        let rows = firsts.zip(pieces(&mut *a).into_iter().zip(pieces(&mut *b)));
        let rows = rows.map(|(first, (a, b))| [Rows { first, rows: a }, Rows { first, rows: b }]);
        let items = self.branches.iter_mut().zip(rows).zip(matrix.assemblies());
        in_parallel(items, |((cells, mut rows), mut values)| f(cells, &mut values, &mut rows));
        let mut rows = [Rows { first: 0, rows: a }, Rows { first: 0, rows: b }];
        f(&mut self.rest, &mut matrix.assembly(), &mut rows);
    }

    /// The branches, each with the rows of its bodies.
    fn with_rows<'a>(
        &'a mut self,
        rows: &'a mut [[f64; 3]],
    ) -> impl Iterator<Item = (&'a mut Cells, Rows<'a>)> {
        let pieces = split(rows, self.bodies.iter().cloned());
        let rows = |(bodies, rows): (&Range<usize>, _)| Rows { first: bodies.start as u32, rows };
        self.branches.iter_mut().zip(self.bodies.iter().zip(pieces).map(rows))
    }
}
