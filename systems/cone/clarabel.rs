//! Clarabel, an interior-point solver for conic programs, behind [`ConeSolver`].
//!
//! In two dimensions |q| and |tau| are absolute values: the program is a QP (an LP where it is
//! static and rigid) and its cones are half-lines. It goes to Clarabel as `min 1/2 x'Px + q'x, Ax +
//! s = b`. The variables x are the forces and, for degrees of freedom with inertia w, `sqrt(w) u`.
//! The balance rows (s = 0), whose multipliers are -u, come first, then the limits (s >= 0). All
//! numbers are in units of the program's scales.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};

use crate::program::{ConeProgram, ConeSolution, Dof, SolveStatus};

use super::certificate::{certificate, locks, proves};
use super::condensed::scaled::Scaled;
use super::solver::{ConeSolver, MalformedProgram};

/// Clarabel with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clarabel {
    /// Tolerance on feasibility and gap, in scaled units.
    pub tolerance: f64,
    /// Cap on iterations.
    pub max_iterations: u32,
}

impl Default for Clarabel {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_iterations: 200 }
    }
}

impl ConeSolver for Clarabel {
    fn name(&self) -> &'static str {
        "Clarabel"
    }

    fn solve(
        &mut self,
        program: &ConeProgram,
        _tolerance: f64,
    ) -> Result<ConeSolution, MalformedProgram> {
        let low = match Lowered::new(program) {
            Ok(low) => low,
            Err((body, dof)) => return Ok(lonely_collapse(program, body, dof)),
        };
        let variables = low.linear.len();
        if variables == 0 {
            return Ok(ConeSolution {
                status: SolveStatus::Solved,
                displacements: program.imposed(),
                ..Default::default()
            });
        }
        let p = CscMatrix::new(
            variables,
            variables,
            (0..=variables).collect(),
            (0..variables).collect(),
            low.quadratic.clone(),
        );
        let a = low.matrix();
        let limits = low.right.len() - low.balance_rows;
        let cones = [ZeroConeT(low.balance_rows), NonnegativeConeT(limits)];
        let settings = DefaultSettings {
            verbose: false,
            max_iter: self.max_iterations,
            tol_feas: self.tolerance,
            tol_gap_abs: self.tolerance,
            tol_gap_rel: self.tolerance,
            // Named, not "auto", so that a run does not depend on the features of the build.
            direct_solve_method: "qdldl".into(),
            max_threads: 1,
            iterative_refinement_max_iter: 20,
            iterative_refinement_reltol: 1e-14,
            iterative_refinement_abstol: 1e-14,
            presolve_enable: false,
            ..DefaultSettings::default()
        };
        let mut solver = DefaultSolver::new(&p, &low.linear, &a, &low.right, &cones, settings)
            .map_err(|e| MalformedProgram(e.to_string()))?;
        solver.solve();
        let raw = &solver.solution;
        let mut solution = ConeSolution {
            status: SolveStatus::Stalled,
            forces: low.forces(program, &raw.x),
            displacements: low.displacements(program, &raw.z),
            iterations: raw.iterations,
            message: format!("{:?}", raw.status),
            ..Default::default()
        };
        match raw.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                solution.status = SolveStatus::Solved;
            }
            SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible
                if locks(program, &solution.forces) =>
            {
                solution.status = SolveStatus::Locked;
            }
            // Clarabel may give up on an infeasible program: the mechanism proves the collapse, not
            // the status.
            _ => {
                let mechanism = certificate(program, &solution.displacements).filter(proves);
                if mechanism.is_some() {
                    solution.status = SolveStatus::Collapsed;
                    solution.certificate = mechanism;
                }
            }
        }
        Ok(solution)
    }
}

/// The program in matrix form, with the places of its rows and columns.
#[derive(Default)]
struct Lowered {
    /// Diagonal of P.
    quadratic: Vec<f64>,
    linear: Vec<f64>,
    /// Rows, columns and values of A.
    triplets: (Vec<usize>, Vec<usize>, Vec<f64>),
    right: Vec<f64>,
    /// Balance row of every degree of freedom; `None` if it has none.
    rows: Vec<[Option<usize>; 3]>,
    /// Columns of p, q and tau of every interaction; `None` if it has no such force.
    columns: Vec<[Option<usize>; 3]>,
    balance_rows: usize,
}

impl Lowered {
    /// The matrix form of a program. The error is a free degree of freedom with a load and without
    /// interactions or weight: a collapse by itself.
    fn new(program: &ConeProgram) -> Result<Self, (usize, usize)> {
        let natural: Vec<usize> = (0..program.bodies.len()).collect();
        let scaled = Scaled::new(program, &natural);
        let mut low = Self { rows: vec![[None; 3]; natural.len()], ..Self::default() };
        let mut touched = vec![[false; 3]; natural.len()];
        for (body, rows) in scaled.locals.iter().flat_map(|l| scaled.participants(l)) {
            for k in 0..3 {
                touched[body][k] |= rows[k].iter().any(|g| *g != 0.0);
            }
        }
        for (i, free) in scaled.free.iter().enumerate() {
            for k in (0..3).filter(|k| free[*k]) {
                if touched[i][k] || scaled.weight[i][k] > 0.0 {
                    low.rows[i][k] = Some(low.right.len());
                    low.right.push(scaled.right[i][k]);
                } else if scaled.right[i][k] != 0.0 {
                    return Err((i, k));
                }
            }
        }
        low.balance_rows = low.right.len();
        for local in &scaled.locals {
            let mut columns = [None; 3];
            for f in (0..3).filter(|f| local.has[*f]) {
                let column = low.push_variable(local.compliance[f], local.linear[f]);
                columns[f] = Some(column);
                for (body, rows) in scaled.participants(local) {
                    for k in 0..3 {
                        if let Some(row) = low.rows[body][k] {
                            low.push(row, column, rows[k][f]);
                        }
                    }
                }
            }
            for (limit, right) in local.limits.iter().zip(local.right).take(local.count) {
                for (value, column) in limit.iter().zip(columns) {
                    if let Some(column) = column {
                        low.push(low.right.len(), column, *value);
                    }
                }
                low.right.push(right);
            }
            low.columns.push(columns);
        }
        for (i, weights) in scaled.weight.iter().enumerate() {
            for k in 0..3 {
                if let Some(row) = low.rows[i][k].filter(|_| weights[k] > 0.0) {
                    let column = low.push_variable(1.0, 0.0);
                    low.push(row, column, weights[k].sqrt());
                }
            }
        }
        Ok(low)
    }

    /// Adds a variable, and returns its column.
    fn push_variable(&mut self, quadratic: f64, linear: f64) -> usize {
        self.quadratic.push(quadratic);
        self.linear.push(linear);
        self.linear.len() - 1
    }

    /// Adds a value of A.
    fn push(&mut self, row: usize, column: usize, value: f64) {
        if value != 0.0 {
            let (rows, columns, values) = &mut self.triplets;
            rows.push(row);
            columns.push(column);
            values.push(value);
        }
    }

    fn matrix(&self) -> CscMatrix<f64> {
        let (rows, columns, values) = self.triplets.clone();
        CscMatrix::new_from_triplets(self.right.len(), self.linear.len(), rows, columns, values)
    }

    /// The displacements, m and rad, that belong to multipliers of the rows.
    fn displacements(&self, program: &ConeProgram, z: &[f64]) -> Vec<[f64; 3]> {
        let (du, _) = program.scales.units();
        let mut out = program.imposed();
        for (u, rows) in out.iter_mut().zip(&self.rows) {
            for k in 0..3 {
                if let Some(row) = rows[k] {
                    u[k] = -z[row] * du[k];
                }
            }
        }
        out
    }

    /// The forces, N and N m, that belong to variables.
    fn forces(&self, program: &ConeProgram, x: &[f64]) -> Vec<[f64; 3]> {
        let (_, df) = program.scales.units();
        let units = [df[0], df[0], df[2]];
        let of = |columns: &[Option<usize>; 3]| {
            [0, 1, 2].map(|f| columns[f].map_or(0.0, |column| x[column] * units[f]))
        };
        self.columns.iter().map(of).collect()
    }
}

/// The collapse of a degree of freedom with a load and without interactions.
fn lonely_collapse(program: &ConeProgram, body: usize, dof: usize) -> ConeSolution {
    let mut mechanism = vec![[0.0; 3]; program.bodies.len()];
    if let Dof::Free(free) = &program.bodies[body].dofs[dof] {
        mechanism[body][dof] = free.load.signum();
    }
    ConeSolution {
        status: SolveStatus::Collapsed,
        certificate: certificate(program, &mechanism),
        message: format!("body {body} carries a load and touches nothing"),
        ..Default::default()
    }
}
