//! A cone program as a quadratic program in standard form.
//!
//! In two dimensions |q| and |tau| are absolute values: the program is a QP (an LP where it is
//! static and rigid) and its cones are half-lines: `min 1/2 x'Px + q'x, Ax + s = b`. The variables x
//! are the forces and, for degrees of freedom with inertia w, `sqrt(w) u`. The balance rows (s = 0),
//! whose multipliers are -u, come first, then the limits (s >= 0). All numbers are in units of the
//! program's scales.

use clarabel::algebra::CscMatrix;
use clastic_cone::program::{ConeProgram, Interaction};

/// The matrix with these rows, columns and values.
pub(crate) fn sparse(size: [usize; 2], entries: &[(usize, usize, f64)]) -> CscMatrix<f64> {
    let (rows, columns, values) = entries.iter().copied().collect();
    CscMatrix::new_from_triplets(size[0], size[1], rows, columns, values)
}

/// `min 1/2 x' diag(P) x + q'x` subject to `A x + s = b`, `s = 0` on the balance rows and `s >= 0` on
/// the others, with the places of rows and columns.
pub(crate) struct Lowered {
    /// Diagonal of P.
    pub(crate) quadratic: Vec<f64>,
    /// q.
    pub(crate) linear: Vec<f64>,
    /// A.
    pub(crate) matrix: CscMatrix<f64>,
    /// b.
    pub(crate) right: Vec<f64>,
    /// Balance row of every degree of freedom; `None` if it has none.
    rows: Vec<[Option<usize>; 3]>,
    /// First column of every interaction.
    columns: Vec<usize>,
    pub(crate) balance_rows: usize,
    /// A free degree of freedom with a load and without interactions: a collapse by itself.
    pub(crate) unbalanced: Option<(usize, usize, f64)>,
}

pub(crate) fn lower(program: &ConeProgram) -> Lowered {
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
    pub(crate) fn displacements(&self, program: &ConeProgram, z: &[f64]) -> Vec<[f64; 3]> {
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
    pub(crate) fn forces(&self, program: &ConeProgram, x: &[f64]) -> Vec<[f64; 3]> {
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
