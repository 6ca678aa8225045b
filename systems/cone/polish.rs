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

/// Defect that no refinement can lower: round-off of rows whose entries are of the order of 1.
const ROUND_OFF: f64 = 1e-15;

/// Settings of the polish. Residuals are those of the program, without dimension.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolishSettings {
    /// Maximum number of guesses of the active limits.
    ///
    /// 8: a cap. Inert in decision 001, where the guess settles earlier.
    pub max_passes: usize,
    /// Residual at which polishing ends. A polished solution within it replaces any solution without
    /// polish, even one with a smaller residual: slack and multiplier of a limit that is just reached
    /// are accurate to the square root of the residual only.
    ///
    /// 1e-11: decision 001.
    pub residual: f64,
    /// Regularisation on the diagonal of the factorised matrix, in scaled units.
    ///
    /// 1e-8: about the root of the round-off, so that the factor exists and the refinement
    /// converges. Decision 001.
    pub regularisation: f64,
    /// Ratio of the defects of two refinements above which the refinement ends.
    ///
    /// 0.9: decision 001.
    pub progress: f64,
}

impl Default for PolishSettings {
    fn default() -> Self {
        Self { max_passes: 8, residual: 1e-11, regularisation: 1e-8, progress: 0.9 }
    }
}

/// `min 1/2 x' diag(P) x + q'x` subject to `A x + s = b`, `s = 0` on the first rows and `s >= 0`
/// on the others.
pub struct QuadraticProgram<'a> {
    /// Diagonal of P.
    pub quadratic: &'a [f64],
    /// q.
    pub linear: &'a [f64],
    /// A.
    pub matrix: &'a CscMatrix<f64>,
    /// b.
    pub right: &'a [f64],
    /// Number of rows with s = 0.
    pub equalities: usize,
}

/// A primal and dual point.
#[derive(Clone, Debug)]
pub struct Point {
    /// Variables x.
    pub x: Vec<f64>,
    /// Multipliers of the rows.
    pub z: Vec<f64>,
}

impl QuadraticProgram<'_> {
    /// Slacks `b - A x`.
    fn slacks(&self, x: &[f64]) -> Vec<f64> {
        let mut s = self.right.to_vec();
        for (column, &x) in x.iter().enumerate() {
            for k in self.matrix.colptr[column]..self.matrix.colptr[column + 1] {
                s[self.matrix.rowval[k]] -= self.matrix.nzval[k] * x;
            }
        }
        s
    }

    /// The active limits of a point: those whose multiplier exceeds their slack.
    #[must_use]
    pub fn active(&self, point: &Point) -> Vec<bool> {
        let s = self.slacks(&point.x);
        s.iter().zip(&point.z).enumerate().map(|(i, (s, z))| i < self.equalities || z > s).collect()
    }

    /// Solves with the given rows as equalities and all others absent, from `start`. `None` if
    /// the factorisation or the refinement fails.
    #[must_use]
    pub fn solve_active(
        &self,
        active: &[bool],
        start: &Point,
        settings: &PolishSettings,
    ) -> Option<Point> {
        let n = self.linear.len();
        let mut row_of = vec![usize::MAX; self.right.len()];
        let mut rows = Vec::new();
        for (i, _) in active.iter().enumerate().filter(|(_, a)| **a) {
            row_of[i] = n + rows.len();
            rows.push(i);
        }
        let size = n + rows.len();
        let mut factor = self.factorise(&row_of, size, settings.regularisation)?;

        let mut y = start.x.clone();
        y.extend(rows.iter().map(|i| start.z[*i]));
        let (mut defect, mut error) = self.defect(&y, &row_of, &rows);
        while error > ROUND_OFF {
            let mut step = defect;
            factor.solve(&mut step);
            let next: Vec<f64> = y.iter().zip(&step).map(|(y, d)| y + d).collect();
            let (next_defect, next_error) = self.defect(&next, &row_of, &rows);
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
        for (k, i) in rows.iter().enumerate() {
            z[*i] = y[n + k];
        }
        y.truncate(n);
        y.iter().chain(&z).all(|v| v.is_finite()).then_some(Point { x: y, z })
    }

    /// The guess corrected by a point: limits whose multiplier has the wrong sign leave, limits
    /// that are violated enter. `None` if nothing changes.
    #[must_use]
    pub fn corrected(&self, active: &[bool], point: &Point) -> Option<Vec<bool>> {
        let s = self.slacks(&point.x);
        let next: Vec<bool> = (0..active.len())
            .map(|i| i < self.equalities || if active[i] { point.z[i] >= 0.0 } else { s[i] < 0.0 })
            .collect();
        (next != active).then_some(next)
    }

    fn factorise(
        &self,
        row_of: &[usize],
        size: usize,
        shift: f64,
    ) -> Option<QDLDLFactorisation<f64>> {
        let n = self.linear.len();
        let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
        for column in 0..n {
            i.push(column);
            j.push(column);
            v.push(self.quadratic[column] + shift);
            for k in self.matrix.colptr[column]..self.matrix.colptr[column + 1] {
                let row = row_of[self.matrix.rowval[k]];
                if row != usize::MAX {
                    i.push(column);
                    j.push(row);
                    v.push(self.matrix.nzval[k]);
                }
            }
        }
        for row in n..size {
            i.push(row);
            j.push(row);
            v.push(-shift);
        }
        let upper = CscMatrix::new_from_triplets(size, size, i, j, v);
        let signs = (0..size).map(|k| if k < n { 1 } else { -1 }).collect();
        let settings = QDLDLSettings { Dsigns: Some(signs), ..QDLDLSettings::default() };
        QDLDLFactorisation::new(&upper, Some(settings)).ok()
    }

    /// Right side less the matrix times y, and the maximum magnitude of its entries.
    fn defect(&self, y: &[f64], row_of: &[usize], rows: &[usize]) -> (Vec<f64>, f64) {
        let n = self.linear.len();
        let mut r: Vec<f64> =
            self.linear.iter().map(|q| -q).chain(rows.iter().map(|i| self.right[*i])).collect();
        for column in 0..n {
            r[column] -= self.quadratic[column] * y[column];
            for k in self.matrix.colptr[column]..self.matrix.colptr[column + 1] {
                let row = row_of[self.matrix.rowval[k]];
                if row != usize::MAX {
                    r[column] -= self.matrix.nzval[k] * y[row];
                    r[row] -= self.matrix.nzval[k] * y[column];
                }
            }
        }
        let mut error = 0.0_f64;
        for r in &r {
            error = if r.is_finite() { error.max(r.abs()) } else { f64::NAN };
            if error.is_nan() {
                break;
            }
        }
        (r, error)
    }
}
