//! Polish of an interior-point solution: guess the active limits, solve the linear equations that
//! remain, correct the guess.
//!
//! At an interior point the *product* of slack and multiplier is small. Where both are small (a
//! force that just reaches its limit) each is accurate to the square root of the product only. With
//! the active limits known, the optimality conditions are linear,
//!
//! ```text
//! [ P    A_e'  A_a' ] [ x   ]   [ -q  ]
//! [ A_e             ] [ y_e ] = [ b_e ]
//! [ A_a             ] [ y_a ]   [ b_a ]
//! ```
//!
//! and are solved by a factorisation of the matrix with `+d`, `-d` added to its diagonal and
//! iterative refinement with the matrix itself. The refinement is a proximal-point iteration: if
//! the system is singular, it converges to a solution near its start.

use clarabel::algebra::CscMatrix;
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettings};
use clastic_cone::program::{ConeProgram, ConeSolution};
use clastic_cone::residuals::regularised_residuals;

use crate::standard_form::{Lowered, sparse};

/// Defect that no refinement can lower: round-off of rows whose entries are of the order of 1.
const ROUND_OFF: f64 = 1e-15;

/// Settings of the polish. Residuals are those of the program, without dimension.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolishSettings {
    /// Maximum number of guesses of the active limits.
    /// 8: a cap. Inert in decision 001, where the guess settles earlier.
    pub max_passes: usize,
    /// Residual at which polishing ends. A polished solution within it replaces any solution without
    /// polish, even one with a smaller residual: slack and multiplier of a limit that is just reached
    /// are accurate to the square root of the residual only.
    /// 1e-11: decision 001.
    pub residual: f64,
    /// Regularisation on the diagonal of the factorised matrix, in scaled units.
    /// 1e-8: about the root of the round-off, so that the factor exists and the refinement
    /// converges. Decision 001.
    pub regularisation: f64,
    /// Ratio of the defects of two refinements above which the refinement ends.
    /// 0.9: decision 001.
    pub progress: f64,
}

impl Default for PolishSettings {
    fn default() -> Self {
        Self { max_passes: 8, residual: 1e-11, regularisation: 1e-8, progress: 0.9 }
    }
}

/// A primal and dual point: the variables x and the multipliers of the rows.
#[derive(Clone)]
pub(crate) struct Point {
    pub(crate) x: Vec<f64>,
    pub(crate) z: Vec<f64>,
}

/// Polishes a solution until its residual is at its goal or the guess of the active limits stays.
pub(crate) fn polish(
    program: &ConeProgram,
    low: &Lowered,
    start: &Point,
    settings: &PolishSettings,
    solution: &mut ConeSolution,
) {
    let worst = |s: &ConeSolution| regularised_residuals(program, s).worst();
    let mut best = worst(solution);
    let mut active = low.active(start);
    for pass in 0..settings.max_passes {
        let Some(point) = low.solve_active(&active, start, settings) else { return };
        let forces = low.forces(program, &point.x);
        let displacements = low.displacements(program, &point.z);
        let polished = ConeSolution { forces, displacements, ..Default::default() };
        let now = worst(&polished);
        // The negation also replaces a solution whose residual is NaN.
        if now <= settings.residual || !(best <= now) {
            best = now;
            solution.forces = polished.forces;
            solution.displacements = polished.displacements;
            let message = solution.message.split(',').next().unwrap_or_default();
            solution.message = format!("{message}, polished {}", pass + 1);
        }
        if best <= settings.residual {
            return;
        }
        let Some(next) = low.corrected(&active, &point) else { return };
        active = next;
    }
}

impl Lowered {
    /// Slacks `b - A x`.
    fn slacks(&self, x: &[f64]) -> Vec<f64> {
        let mut s = self.right.clone();
        for (row, column, value) in entries(&self.matrix) {
            s[row] -= value * x[column];
        }
        s
    }

    /// The active limits of a point: those whose multiplier exceeds their slack.
    fn active(&self, point: &Point) -> Vec<bool> {
        let s = self.slacks(&point.x);
        let both = s.iter().zip(&point.z).enumerate();
        both.map(|(i, (s, z))| i < self.balance_rows || z > s).collect()
    }

    /// Solves with the given rows as equalities and all others absent, from `start`. `None` if
    /// the factorisation or the refinement fails.
    fn solve_active(
        &self,
        active: &[bool],
        start: &Point,
        settings: &PolishSettings,
    ) -> Option<Point> {
        let n = self.linear.len();
        let rows: Vec<usize> = (0..active.len()).filter(|i| active[*i]).collect();
        let upper = self.equations(&rows);
        let mut factor = factorise(&upper, n, settings.regularisation)?;
        let right: Vec<f64> =
            self.linear.iter().map(|q| -q).chain(rows.iter().map(|i| self.right[*i])).collect();

        let mut y = start.x.clone();
        y.extend(rows.iter().map(|i| start.z[*i]));
        let (mut defect, mut error) = defect(&upper, &right, &y);
        while error > ROUND_OFF {
            let mut step = defect;
            factor.solve(&mut step);
            let next: Vec<f64> = y.iter().zip(&step).map(|(y, d)| y + d).collect();
            let (next_defect, next_error) = self::defect(&upper, &right, &next);
            if !next_error.is_finite() || next_error > settings.progress * error {
                // No further progress: round-off, or a guess without a solution.
                if next_error < error {
                    y = next;
                }
                break;
            }
            (y, defect, error) = (next, next_defect, next_error);
        }
        let mut z = vec![0.0; self.right.len()];
        for (i, y) in rows.iter().zip(&y[n..]) {
            z[*i] = *y;
        }
        y.truncate(n);
        y.iter().chain(&z).all(|v| v.is_finite()).then_some(Point { x: y, z })
    }

    /// The upper triangle of the matrix of the equations, with these rows. It has a whole diagonal.
    fn equations(&self, rows: &[usize]) -> CscMatrix<f64> {
        let n = self.linear.len();
        let mut row_of = vec![None; self.right.len()];
        let diagonal = self.quadratic.iter().enumerate();
        let mut all: Vec<_> = diagonal.map(|(column, p)| (column, column, *p)).collect();
        for (place, row) in (n..).zip(rows) {
            row_of[*row] = Some(place);
            all.push((place, place, 0.0));
        }
        for (row, column, value) in entries(&self.matrix) {
            if let Some(place) = row_of[row] {
                all.push((column, place, value));
            }
        }
        sparse([n + rows.len(); 2], &all)
    }

    /// The guess corrected by a point: limits whose multiplier has the wrong sign leave, limits
    /// that are violated enter. `None` if nothing changes.
    fn corrected(&self, active: &[bool], point: &Point) -> Option<Vec<bool>> {
        let s = self.slacks(&point.x);
        let is_active = |i: usize| if active[i] { point.z[i] >= 0.0 } else { s[i] < 0.0 };
        let next: Vec<bool> =
            (0..active.len()).map(|i| i < self.balance_rows || is_active(i)).collect();
        (next != active).then_some(next)
    }
}

/// Row, column and value of the entries of a matrix, column by column.
fn entries(matrix: &CscMatrix<f64>) -> impl Iterator<Item = (usize, usize, f64)> {
    let of_column = |column: usize| matrix.colptr[column]..matrix.colptr[column + 1];
    (0..matrix.n).flat_map(move |column| {
        of_column(column).map(move |k| (matrix.rowval[k], column, matrix.nzval[k]))
    })
}

/// Factor of the equations with `shift` added to the first `n` numbers of the diagonal, and
/// subtracted from the others.
fn factorise(upper: &CscMatrix<f64>, n: usize, shift: f64) -> Option<QDLDLFactorisation<f64>> {
    let mut shifted = upper.clone();
    let signs: Vec<i8> = (0..upper.n).map(|k| if k < n { 1 } else { -1 }).collect();
    for (sign, end) in signs.iter().zip(&upper.colptr[1..]) {
        shifted.nzval[end - 1] += f64::from(*sign) * shift;
    }
    let settings = QDLDLSettings { Dsigns: Some(signs), ..QDLDLSettings::default() };
    QDLDLFactorisation::new(&shifted, Some(settings)).ok()
}

/// Right side less the matrix times y, and the maximum magnitude of its entries.
fn defect(upper: &CscMatrix<f64>, right: &[f64], y: &[f64]) -> (Vec<f64>, f64) {
    let mut r = right.to_vec();
    for (row, column, value) in entries(upper) {
        r[row] -= value * y[column];
        if row != column {
            r[column] -= value * y[row];
        }
    }
    let larger =
        |m: f64, x: &f64| if x.is_finite() && !m.is_nan() { m.max(x.abs()) } else { f64::NAN };
    let error = r.iter().fold(0.0, larger);
    (r, error)
}
