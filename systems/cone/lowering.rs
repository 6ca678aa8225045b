//! The cone program as a quadratic program in matrix form, in units of its scales, and its solution
//! back in SI units. [`clarabel`](super::clarabel) states the form.

use clarabel::algebra::CscMatrix;

use crate::program::{ConeProgram, ConeSolution, Dof, Interaction};

use super::polish::{Point, PolishSettings, QuadraticProgram};
use super::residuals::regularised_residuals;

/// Triplets of a sparse matrix.
#[derive(Default)]
pub(super) struct Triplets {
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

    pub(super) fn matrix(self, rows: usize, columns: usize) -> CscMatrix<f64> {
        CscMatrix::new_from_triplets(rows, columns, self.rows, self.columns, self.values)
    }
}

/// The program as Clarabel reads it, with the places of its rows and columns.
pub(super) struct Lowered {
    /// Diagonal of P.
    pub(super) quadratic: Vec<f64>,
    pub(super) linear: Vec<f64>,
    pub(super) matrix: Triplets,
    pub(super) right: Vec<f64>,
    /// Balance row of every degree of freedom; `None` if it has none.
    pub(super) rows: Vec<[Option<usize>; 3]>,
    /// First column of every interaction.
    pub(super) columns: Vec<usize>,
    pub(super) balance_rows: usize,
    /// A free degree of freedom with a load and without interactions: a collapse by itself.
    pub(super) unbalanced: Option<(usize, usize)>,
}

pub(super) fn lower(program: &ConeProgram) -> Lowered {
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
    low.add_balance(program);
    let imposed = program.imposed();
    for c in &program.interactions {
        low.add_interaction(program, c, &imposed);
    }
    low.add_weights(program);
    low
}

/// Degrees of freedom on which an interaction acts.
fn touched(program: &ConeProgram) -> Vec<[bool; 3]> {
    let mut touched = vec![[false; 3]; program.bodies.len()];
    for c in &program.interactions {
        let has = [true, c.limits.has_shear(), c.limits.has_rolling()];
        let of =
            |body: u32, first| (body as usize, c.rows(program.bodies[body as usize].axis, first));
        let cell = program.rows_of_cell(c);
        for (body, rows) in [of(c.a, true), of(c.b, false)].into_iter().chain(cell) {
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
            for k in 0..3 {
                if let Dof::Free(free) = &body.dofs[k] {
                    if touched[i][k] || free.inertia + free.proximal > 0.0 {
                        self.rows[i][k] = Some(self.right.len());
                        self.right.push((free.load + free.proximal * free.reference) / df[k]);
                    } else if free.load != 0.0 {
                        self.unbalanced.get_or_insert((i, k));
                    }
                }
            }
        }
        self.balance_rows = self.right.len();
    }

    /// Adds the forces of an interaction and its limits. `imposed` are the known displacements.
    fn add_interaction(&mut self, program: &ConeProgram, c: &Interaction, imposed: &[[f64; 3]]) {
        let (du, df) = program.scales.units();
        let length = program.scales.length;
        let stiffness = program.scales.force / program.scales.displacement;
        self.columns.push(self.linear.len());
        let e = program.kinematics(c, imposed);
        let l = &c.limits;
        let linear = (c.offset - e[0]) / du[0];
        let p = self.add_force(program, c, 0, c.normal_compliance * stiffness, linear);
        if l.has_shear() {
            let linear = -(e[1] + c.tangential_compliance * c.previous_shear) / du[0];
            let q = self.add_force(program, c, 1, c.tangential_compliance * stiffness, linear);
            for sign in [1.0, -1.0] {
                let row = self.right.len();
                self.matrix.push(row, q, sign);
                self.matrix.push(row, p, -l.friction);
                self.right.push(l.cohesion / df[0]);
            }
        }
        if l.has_rolling() {
            let linear = -(e[2] + c.rolling_compliance * c.previous_moment) / du[2];
            let quadratic = c.rolling_compliance * df[2] / du[2];
            let tau = self.add_force(program, c, 2, quadratic, linear);
            for sign in [1.0, -1.0] {
                let row = self.right.len();
                self.matrix.push(row, tau, sign);
                self.matrix.push(row, p, -l.rolling / length);
                self.right.push(l.moment / df[2]);
            }
        }
        if l.has_tension_row() {
            self.matrix.push(self.right.len(), p, -1.0);
            self.right.push(l.tension / df[0]);
        }
    }

    /// Adds the column of a force (0 for p, 1 for q, 2 for tau), and returns its index.
    fn add_force(
        &mut self,
        program: &ConeProgram,
        c: &Interaction,
        force: usize,
        quadratic: f64,
        linear: f64,
    ) -> usize {
        let (_, df) = program.scales.units();
        let column = self.linear.len();
        self.linear.push(linear);
        self.quadratic.push(quadratic);
        let of =
            |body: u32, first| (body as usize, c.rows(program.bodies[body as usize].axis, first));
        let cell = program.rows_of_cell(c);
        for (body, rows) in [of(c.a, true), of(c.b, false)].into_iter().chain(cell) {
            for dof in 0..3 {
                if let Some(row) = self.rows[body][dof] {
                    // Units of moments and arms: rows are divided by df, columns multiplied.
                    let value = rows[dof][force] * df[force_unit(force)] / df[dof];
                    self.matrix.push(row, column, value);
                }
            }
        }
        column
    }

    /// Adds the columns of inertia and regularisation.
    fn add_weights(&mut self, program: &ConeProgram) {
        let (du, df) = program.scales.units();
        for (i, body) in program.bodies.iter().enumerate() {
            for k in 0..3 {
                if let (Dof::Free(free), Some(row)) = (&body.dofs[k], self.rows[i][k]) {
                    let weight = (free.inertia + free.proximal) * du[k] / df[k];
                    if weight > 0.0 {
                        let column = self.linear.len();
                        self.linear.push(0.0);
                        self.quadratic.push(1.0);
                        self.matrix.push(row, column, weight.sqrt());
                    }
                }
            }
        }
    }
}

/// The unit of a force variable: 0 for forces, 2 for moments.
fn force_unit(force: usize) -> usize {
    if force == 2 { 2 } else { 0 }
}

/// Polishes a solution until its residual is at its goal or the guess of the active limits stays.
pub(super) fn polish(
    program: &ConeProgram,
    low: &Lowered,
    matrix: &CscMatrix<f64>,
    start: Point,
    settings: &PolishSettings,
    solution: &mut ConeSolution,
) {
    let qp = QuadraticProgram {
        quadratic: &low.quadratic,
        linear: &low.linear,
        matrix,
        right: &low.right,
        equalities: low.balance_rows,
    };
    let worst = |s: &ConeSolution| regularised_residuals(program, s).worst();
    let mut best = worst(solution);
    let mut active = qp.active(&start);
    for pass in 0..settings.max_passes {
        let Some(point) = qp.solve_active(&active, &start, settings) else { return };
        let forces = forces(program, &low.columns, &point.x);
        let displacements = displacements(program, &low.rows, &point.z);
        let polished = ConeSolution { forces, displacements, ..Default::default() };
        let now = worst(&polished);
        // The negation also replaces a solution whose residual is NaN.
        if now <= settings.residual || !(best <= now) {
            best = now;
            solution.forces = polished.forces;
            solution.displacements = polished.displacements;
            solution.message = format!(
                "{}, polished {}",
                solution.message.split(',').next().unwrap_or_default(),
                pass + 1
            );
        }
        if best <= settings.residual {
            return;
        }
        match qp.corrected(&active, &point) {
            Some(next) => active = next,
            None => return,
        }
    }
}

pub(super) fn displacements(
    program: &ConeProgram,
    rows: &[[Option<usize>; 3]],
    z: &[f64],
) -> Vec<[f64; 3]> {
    let (du, _) = program.scales.units();
    let mut out = program.imposed();
    for (u, rows) in out.iter_mut().zip(rows) {
        for k in 0..3 {
            if let Some(row) = rows[k] {
                u[k] = -z[row] * du[k];
            }
        }
    }
    out
}

pub(super) fn forces(program: &ConeProgram, columns: &[usize], x: &[f64]) -> Vec<[f64; 3]> {
    let (_, df) = program.scales.units();
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
