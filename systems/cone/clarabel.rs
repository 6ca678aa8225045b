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

use crate::program::{ConeProgram, ConeSolution, Interaction, SolveStatus};

use super::certificate::{certificate, locks, proves};
use super::polish::{Point, PolishSettings, polish};
use super::solver::{ConeSolver, MalformedProgram};

/// Clarabel with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clarabel {
    /// Tolerance on feasibility and gap, in scaled units.
    pub tolerance: f64,
    /// Cap on iterations.
    pub max_iterations: u32,
    /// Settings of the [polish](super::polish) of its solutions; `None` for no polish.
    pub polish: Option<PolishSettings>,
}

impl Default for Clarabel {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_iterations: 200, polish: Some(PolishSettings::default()) }
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
        let low = lower(program);
        if let Some((body, dof, load)) = low.unbalanced {
            return Ok(lonely_collapse(program, body, dof, load));
        }
        if low.linear.is_empty() {
            return Ok(ConeSolution {
                status: SolveStatus::Solved,
                displacements: program.imposed(),
                ..Default::default()
            });
        }
        let n = low.linear.len();
        let p = CscMatrix::new(n, n, (0..=n).collect(), (0..n).collect(), low.quadratic.clone());
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
        let mut solver =
            DefaultSolver::new(&p, &low.linear, &low.matrix, &low.right, &cones, settings)
                .map_err(|e| MalformedProgram(e.to_string()))?;
        solver.solve();
        let raw = &solver.solution;
        let mut solution = ConeSolution {
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
                return Ok(solution);
            }
            // Clarabel may give up on an infeasible program: the mechanism is the proof.
            _ => {
                let mechanism = certificate(program, &solution.displacements).filter(proves);
                if mechanism.is_some() {
                    solution.status = SolveStatus::Collapsed;
                    solution.certificate = mechanism;
                    return Ok(solution);
                }
            }
        }
        if let Some(settings) = &self.polish {
            let start = Point { x: raw.x.clone(), z: raw.z.clone() };
            polish(program, &low, &start, settings, &mut solution);
        }
        Ok(solution)
    }
}

/// The collapse of a degree of freedom with a load and without interactions.
fn lonely_collapse(program: &ConeProgram, body: usize, dof: usize, load: f64) -> ConeSolution {
    let mut mechanism = vec![[0.0; 3]; program.bodies.len()];
    mechanism[body][dof] = load.signum();
    ConeSolution {
        status: SolveStatus::Collapsed,
        certificate: certificate(program, &mechanism),
        message: format!("body {body} carries a load and touches nothing"),
        ..Default::default()
    }
}

/// The matrix with these rows, columns and values.
pub(super) fn sparse(size: [usize; 2], entries: &[(usize, usize, f64)]) -> CscMatrix<f64> {
    let (rows, columns, values) = entries.iter().copied().collect();
    CscMatrix::new_from_triplets(size[0], size[1], rows, columns, values)
}

/// `min 1/2 x' diag(P) x + q'x` subject to `A x + s = b`, `s = 0` on the balance rows and `s >= 0` on
/// the others, with the places of rows and columns.
pub(super) struct Lowered {
    /// Diagonal of P.
    pub(super) quadratic: Vec<f64>,
    /// q.
    pub(super) linear: Vec<f64>,
    /// A.
    pub(super) matrix: CscMatrix<f64>,
    /// b.
    pub(super) right: Vec<f64>,
    /// Balance row of every degree of freedom; `None` if it has none.
    rows: Vec<[Option<usize>; 3]>,
    /// First column of every interaction.
    columns: Vec<usize>,
    pub(super) balance_rows: usize,
    /// A free degree of freedom with a load and without interactions: a collapse by itself.
    unbalanced: Option<(usize, usize, f64)>,
}

pub(super) fn lower(program: &ConeProgram) -> Lowered {
    let mut low = Lowered {
        quadratic: Vec::new(),
        linear: Vec::new(),
        matrix: CscMatrix::zeros((0, 0)),
        right: Vec::new(),
        rows: vec![[None; 3]; program.bodies.len()],
        columns: Vec::with_capacity(program.interactions.len()),
        balance_rows: 0,
        unbalanced: None,
    };
    let mut entries = Vec::new();
    low.add_balance(program);
    let imposed = program.imposed();
    for c in &program.interactions {
        low.add_interaction(program, c, &imposed, &mut entries);
    }
    low.add_weights(program, &mut entries);
    low.matrix = sparse([low.right.len(), low.linear.len()], &entries);
    low
}

/// Degrees of freedom on which an interaction acts.
fn touched(program: &ConeProgram) -> Vec<[bool; 3]> {
    let mut touched = vec![[false; 3]; program.bodies.len()];
    for c in &program.interactions {
        let has = c.limits.forces();
        for (body, rows) in program.rows(c) {
            for k in 0..3 {
                touched[body][k] |= (0..3).any(|f| has[f] && rows[k][f] != 0.0);
            }
        }
    }
    touched
}

impl Lowered {
    /// Adds the balance rows. One without coefficients is trivial, or a collapse by itself.
    fn add_balance(&mut self, program: &ConeProgram) {
        let (_, df) = program.scales.units();
        let touched = touched(program);
        for (i, body) in program.bodies.iter().enumerate() {
            for (k, free) in body.free() {
                if touched[i][k] || free.inertia + free.proximal > 0.0 {
                    self.rows[i][k] = Some(self.right.len());
                    self.right.push((free.load + free.proximal * free.reference) / df[k]);
                } else if free.load != 0.0 {
                    self.unbalanced.get_or_insert((i, k, free.load));
                }
            }
        }
        self.balance_rows = self.right.len();
    }

    /// Adds the forces of an interaction and its limits. `imposed` are the known displacements.
    fn add_interaction(
        &mut self,
        program: &ConeProgram,
        c: &Interaction,
        imposed: &[[f64; 3]],
        entries: &mut Vec<(usize, usize, f64)>,
    ) {
        let (du, df) = program.scales.units();
        let l = &c.limits;
        let e = program.kinematics(c, imposed);
        let (q, tau) = (c.tangential_compliance, c.rolling_compliance);
        let stiffness = program.scales.force / program.scales.displacement;
        let columns = [
            (true, c.normal_compliance * stiffness, (c.offset - e[0]) / du[0]),
            (l.has_shear(), q * stiffness, -(e[1] + q * c.previous_shear) / du[0]),
            (l.has_rolling(), tau * df[2] / du[2], -(e[2] + tau * c.previous_moment) / du[2]),
        ];
        let p = self.linear.len();
        self.columns.push(p);
        for (force, (_, quadratic, linear)) in
            columns.into_iter().enumerate().filter(|(_, (exists, ..))| *exists)
        {
            let column = self.linear.len();
            self.linear.push(linear);
            self.quadratic.push(quadratic);
            for (body, rows) in program.rows(c) {
                for dof in 0..3 {
                    // Units of moments and arms: rows are divided by df, columns multiplied.
                    let value = rows[dof][force] * df[force] / df[dof];
                    if let Some(row) = self.rows[body][dof].filter(|_| value != 0.0) {
                        entries.push((row, column, value));
                    }
                }
            }
        }
        let mut limit = |x: Option<(usize, f64)>, slope: f64, strength: f64| {
            let row = self.right.len();
            for (column, value) in x.into_iter().chain([(p, -slope)]) {
                if value != 0.0 {
                    entries.push((row, column, value));
                }
            }
            self.right.push(strength);
        };
        for sign in [1.0, -1.0].into_iter().filter(|_| l.has_shear()) {
            limit(Some((p + 1, sign)), l.friction, l.cohesion / df[0]);
        }
        let rolling = p + 1 + usize::from(l.has_shear());
        for sign in [1.0, -1.0].into_iter().filter(|_| l.has_rolling()) {
            limit(Some((rolling, sign)), l.rolling / program.scales.length, l.moment / df[2]);
        }
        if l.has_tension_row() {
            limit(None, 1.0, l.tension / df[0]);
        }
    }

    /// Adds the columns of inertia and regularisation.
    fn add_weights(&mut self, program: &ConeProgram, entries: &mut Vec<(usize, usize, f64)>) {
        let (du, df) = program.scales.units();
        for (body, rows) in program.bodies.iter().zip(&self.rows) {
            for (k, free) in body.free() {
                let weight = (free.inertia + free.proximal) * du[k] / df[k];
                if let Some(row) = rows[k].filter(|_| weight > 0.0) {
                    entries.push((row, self.linear.len(), weight.sqrt()));
                    self.linear.push(0.0);
                    self.quadratic.push(1.0);
                }
            }
        }
    }

    /// The displacements that belong to multipliers.
    pub(super) fn displacements(&self, program: &ConeProgram, z: &[f64]) -> Vec<[f64; 3]> {
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

    /// The forces that belong to variables.
    pub(super) fn forces(&self, program: &ConeProgram, x: &[f64]) -> Vec<[f64; 3]> {
        let (_, df) = program.scales.units();
        let of = |(c, &first): (&Interaction, &usize)| {
            let (shear, rolling) = (c.limits.has_shear(), c.limits.has_rolling());
            let q = if shear { x[first + 1] * df[0] } else { 0.0 };
            let tau = if rolling { x[first + 1 + usize::from(shear)] * df[2] } else { 0.0 };
            [x[first] * df[0], q, tau]
        };
        program.interactions.iter().zip(&self.columns).map(of).collect()
    }
}
