//! Clarabel, an interior-point solver for conic programs, behind [`ConeSolver`].
//!
//! In two dimensions |q| and |tau| are absolute values: the program is a QP (an LP where it is
//! static and rigid) and its cones are half-lines. It goes to Clarabel as
//! `min 1/2 x'Px + q'x, Ax + s = b` with x the forces and, where there is inertia w, `sqrt(w) u`;
//! first the balance rows (s = 0), whose multipliers are -u, then the limits (s >= 0). All is in
//! units of the program's scales.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};

use clastic_components::program::{ConeProgram, ConeSolution, Dof, SolveStatus};

use super::certificate::{certificate, proves};
use super::polish::{Point, QuadraticProgram};
use super::residuals::regularised_residuals;
use super::{ConeSolver, MalformedProgram};

/// Polishes of one solution at most.
const POLISHES: usize = 8;
/// Residual at which polishing stops.
const POLISHED: f64 = 1e-11;

/// Clarabel and its settings.
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

/// Triplets of a sparse matrix.
#[derive(Default)]
struct Triplets {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl Triplets {
    fn push(&mut self, row: usize, column: usize, value: f64) {
        if value != 0.0 {
            self.rows.push(row);
            self.columns.push(column);
            self.values.push(value);
        }
    }

    fn matrix(self, rows: usize, columns: usize) -> CscMatrix<f64> {
        CscMatrix::new_from_triplets(rows, columns, self.rows, self.columns, self.values)
    }
}

/// The program as Clarabel reads it, with the way back.
struct Lowered {
    /// Diagonal of P.
    quadratic: Vec<f64>,
    linear: Vec<f64>,
    matrix: Triplets,
    right: Vec<f64>,
    /// Row of every degree of freedom, where it has one.
    rows: Vec<[Option<usize>; 3]>,
    /// First column of every interaction.
    columns: Vec<usize>,
    balance_rows: usize,
    /// A free degree of freedom that carries a load and that nothing touches.
    unbalanced: Option<(usize, usize)>,
}

/// Units of the three degrees of freedom: displacement and force.
fn units(program: &ConeProgram) -> ([f64; 3], [f64; 3]) {
    let s = &program.scales;
    let (u, f, l) = (s.displacement, s.force, s.length);
    ([u, u, u / l], [f, f, f * l])
}

fn lower(program: &ConeProgram) -> Lowered {
    let (du, df) = units(program);
    let length = program.scales.length;
    let stiffness = program.scales.force / program.scales.displacement;
    let fixed: Vec<[f64; 3]> = program
        .bodies
        .iter()
        .map(|b| b.dofs.map(|d| if let Dof::Fixed(u) = d { u } else { 0.0 }))
        .collect();
    let mut low = Lowered {
        quadratic: Vec::new(),
        linear: Vec::new(),
        matrix: Triplets::default(),
        right: Vec::new(),
        rows: vec![[None; 3]; program.bodies.len()],
        columns: Vec::with_capacity(program.interactions.len()),
        balance_rows: 0,
        unbalanced: None,
    };

    // A balance row without a single coefficient is either trivial or a collapse by itself.
    let mut touched = vec![[false; 3]; program.bodies.len()];
    for c in &program.interactions {
        let has = [true, c.limits.has_shear(), c.limits.has_rolling()];
        for (body, first) in [(c.a as usize, true), (c.b as usize, false)] {
            let rows = c.rows(program.bodies[body].axis, first);
            for k in 0..3 {
                touched[body][k] |= (0..3).any(|f| has[f] && rows[k][f] != 0.0);
            }
        }
    }
    for (i, body) in program.bodies.iter().enumerate() {
        for k in 0..3 {
            if let Dof::Free(free) = &body.dofs[k] {
                if touched[i][k] || free.inertia + free.proximal > 0.0 {
                    low.rows[i][k] = Some(low.right.len());
                    low.right.push((free.load + free.proximal * free.reference) / df[k]);
                } else if free.load != 0.0 {
                    low.unbalanced.get_or_insert((i, k));
                }
            }
        }
    }
    low.balance_rows = low.right.len();

    for c in &program.interactions {
        let first = low.linear.len();
        low.columns.push(first);
        let e = program.kinematics(c, &fixed);
        let l = &c.limits;
        let column = |low: &mut Lowered, force: usize, quadratic: f64, linear: f64| {
            let k = low.linear.len();
            low.linear.push(linear);
            low.quadratic.push(quadratic);
            for (body, first) in [(c.a as usize, true), (c.b as usize, false)] {
                let rows = c.rows(program.bodies[body].axis, first);
                for dof in 0..3 {
                    if let Some(row) = low.rows[body][dof] {
                        // Moments and arms in units of length: rows over df, columns times df.
                        low.matrix.push(row, k, rows[dof][force] * df[force_unit(force)] / df[dof]);
                    }
                }
            }
            k
        };
        let p = column(&mut low, 0, c.normal_compliance * stiffness, (c.offset - e[0]) / du[0]);
        if l.has_shear() {
            let linear = -(e[1] + c.tangential_compliance * c.previous_shear) / du[0];
            let q = column(&mut low, 1, c.tangential_compliance * stiffness, linear);
            for sign in [1.0, -1.0] {
                let row = low.right.len();
                low.matrix.push(row, q, sign);
                low.matrix.push(row, p, -l.friction);
                low.right.push(l.cohesion / df[0]);
            }
        }
        if l.has_rolling() {
            let tau = column(&mut low, 2, 0.0, -e[2] / du[2]);
            for sign in [1.0, -1.0] {
                let row = low.right.len();
                low.matrix.push(row, tau, sign);
                low.matrix.push(row, p, -l.rolling / length);
                low.right.push(l.rolling * l.tension / df[2]);
            }
        }
        if l.has_tension_row() {
            low.matrix.push(low.right.len(), p, -1.0);
            low.right.push(l.tension / df[0]);
        }
    }
    for (i, body) in program.bodies.iter().enumerate() {
        for k in 0..3 {
            if let (Dof::Free(free), Some(row)) = (&body.dofs[k], low.rows[i][k]) {
                let weight = (free.inertia + free.proximal) * du[k] / df[k];
                if weight > 0.0 {
                    let column = low.linear.len();
                    low.linear.push(0.0);
                    low.quadratic.push(1.0);
                    low.matrix.push(row, column, weight.sqrt());
                }
            }
        }
    }
    low
}

/// Which unit a force variable has: forces, or moments.
fn force_unit(force: usize) -> usize {
    if force == 2 { 2 } else { 0 }
}

impl ConeSolver for Clarabel {
    fn name(&self) -> &'static str {
        "Clarabel"
    }

    fn solve(&mut self, program: &ConeProgram) -> Result<ConeSolution, MalformedProgram> {
        let mut low = lower(program);
        if let Some((body, dof)) = low.unbalanced {
            return Ok(lonely_collapse(program, body, dof));
        }
        let (variables, rows) = (low.linear.len(), low.right.len());
        if variables == 0 {
            return Ok(ConeSolution {
                status: SolveStatus::Solved,
                displacements: known_displacements(program),
                ..Default::default()
            });
        }
        let p = diagonal(&low.quadratic);
        let a = std::mem::take(&mut low.matrix).matrix(rows, variables);
        let cones =
            [ZeroConeT(low.balance_rows), NonnegativeConeT(rows - low.balance_rows)];
        let settings = DefaultSettings {
            verbose: false,
            max_iter: self.max_iterations,
            tol_feas: self.tolerance,
            tol_gap_abs: self.tolerance,
            tol_gap_rel: self.tolerance,
            // Named, not "auto", so that a run does not depend on what the build has.
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
            forces: forces(program, &low.columns, &raw.x),
            displacements: displacements(program, &low.rows, &raw.z),
            iterations: raw.iterations,
            message: format!("{:?}", raw.status),
            ..Default::default()
        };
        match raw.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                solution.status = SolveStatus::Solved;
                polish(program, &low, &a, Point { x: raw.x.clone(), z: raw.z.clone() }, &mut solution);
            }
            SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => {
                solution.status = SolveStatus::Locked;
            }
            // Clarabel may give up where the truth is infeasible; what proves the collapse is the
            // mechanism, not the word.
            _ => {
                let mechanism = certificate(program, &solution.displacements).filter(proves);
                if mechanism.is_some() {
                    solution.status = SolveStatus::Collapsed;
                    solution.certificate = mechanism;
                } else {
                    polish(program, &low, &a, Point { x: raw.x.clone(), z: raw.z.clone() }, &mut solution);
                }
            }
        }
        Ok(solution)
    }
}

/// Improves a solution while its residuals improve.
fn polish(
    program: &ConeProgram,
    low: &Lowered,
    matrix: &CscMatrix<f64>,
    start: Point,
    solution: &mut ConeSolution,
) {
    let qp = QuadraticProgram {
        quadratic: &low.quadratic,
        linear: &low.linear,
        matrix,
        right: &low.right,
        equalities: low.balance_rows,
    };
    let worst = |s: &ConeSolution| regularised_residuals(program, &s.forces, &s.displacements).worst();
    let mut best = worst(solution);
    let mut active = qp.active(&start);
    for pass in 0..POLISHES {
        let Some(point) = qp.solve_active(&active, &start) else { return };
        let forces = forces(program, &low.columns, &point.x);
        let displacements = displacements(program, &low.rows, &point.z);
        let polished = ConeSolution { forces, displacements, ..Default::default() };
        let now = worst(&polished);
        // Also true where the interior point left something that is not a number.
        if !(best <= now) {
            best = now;
            solution.forces = polished.forces;
            solution.displacements = polished.displacements;
            solution.message = format!("{}, polished {}", solution.message.split(',').next().unwrap_or_default(), pass + 1);
        }
        if best <= POLISHED {
            return;
        }
        match qp.corrected(&active, &point) {
            Some(next) => active = next,
            None => return,
        }
    }
}

fn diagonal(entries: &[f64]) -> CscMatrix<f64> {
    let n = entries.len();
    CscMatrix::new(n, n, (0..=n).collect(), (0..n).collect(), entries.to_vec())
}

fn known_displacements(program: &ConeProgram) -> Vec<[f64; 3]> {
    program.bodies.iter().map(|b| b.dofs.map(|d| if let Dof::Fixed(u) = d { u } else { 0.0 })).collect()
}

fn displacements(program: &ConeProgram, rows: &[[Option<usize>; 3]], z: &[f64]) -> Vec<[f64; 3]> {
    let (du, _) = units(program);
    let mut out = known_displacements(program);
    for (u, rows) in out.iter_mut().zip(rows) {
        for k in 0..3 {
            if let Some(row) = rows[k] {
                u[k] = -z[row] * du[k];
            }
        }
    }
    out
}

fn forces(program: &ConeProgram, columns: &[usize], x: &[f64]) -> Vec<[f64; 3]> {
    let (_, df) = units(program);
    program
        .interactions
        .iter()
        .zip(columns)
        .map(|(c, &first)| {
            let (shear, rolling) = (c.limits.has_shear(), c.limits.has_rolling());
            let q = if shear { x[first + 1] * df[0] } else { 0.0 };
            let tau = if rolling { x[first + 1 + usize::from(shear)] * df[2] } else { 0.0 };
            [x[first] * df[0], q, tau]
        })
        .collect()
}

/// The collapse of a degree of freedom that carries a load and that nothing holds.
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
