//! The program in units of its scales, contact by contact, as the condensed solver works on it.
//!
//! Interaction c: `min 1/2 s'Cs + l's`, `A s + w = b`, `w >= 0` with s = (p, q, tau); stationarity
//! `l + C s - e(u) + A' lambda = 0`. Bodies: `m u + G s = f` on free degrees of freedom.

use clastic_components::program::{ConeProgram, Dof};

use super::super::lowering::units;

/// Most limit rows of an interaction.
pub const ROWS: usize = 5;

/// One interaction.
#[derive(Clone, Debug)]
pub struct Local {
    /// Bodies.
    pub bodies: [usize; 2],
    /// Rows of the two bodies: `[body][dof][force]`, zero where the degree of freedom is fixed.
    pub rows: [[[f64; 3]; 3]; 2],
    /// The same with fixed degrees of freedom.
    pub all_rows: [[[f64; 3]; 3]; 2],
    /// Which of p, q, tau exist.
    pub has: [bool; 3],
    /// Compliances.
    pub compliance: [f64; 3],
    /// Linear terms.
    pub linear: [f64; 3],
    /// Limits: coefficients.
    pub limits: [[f64; 3]; ROWS],
    /// Limits: right sides.
    pub right: [f64; ROWS],
    /// Number of limits.
    pub count: usize,
}

/// The program.
#[derive(Clone, Debug, Default)]
pub struct Scaled {
    /// Interactions.
    pub locals: Vec<Local>,
    /// Free degrees of freedom.
    pub free: Vec<[bool; 3]>,
    /// Weights m (inertia and regularisation).
    pub weight: Vec<[f64; 3]>,
    /// Right sides f.
    pub right: Vec<[f64; 3]>,
    /// Known displacements; zero where free.
    pub known: Vec<[f64; 3]>,
}

impl Scaled {
    /// Scales a program.
    #[must_use]
    pub fn new(program: &ConeProgram) -> Self {
        let (du, df) = units(program);
        let s = &program.scales;
        let stiffness = s.force / s.displacement;
        let mut out = Self::default();
        for body in &program.bodies {
            let (mut free, mut weight, mut right, mut known) =
                ([false; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
            for k in 0..3 {
                match &body.dofs[k] {
                    Dof::Fixed(u) => known[k] = u / du[k],
                    Dof::Free(f) => {
                        free[k] = true;
                        weight[k] = (f.inertia + f.proximal) * du[k] / df[k];
                        right[k] = (f.load + f.proximal * f.reference) / df[k];
                    }
                }
            }
            out.free.push(free);
            out.weight.push(weight);
            out.right.push(right);
            out.known.push(known);
        }
        for c in &program.interactions {
            let l = &c.limits;
            let has = [true, l.has_shear(), l.has_rolling()];
            let bodies = [c.a as usize, c.b as usize];
            let mut all_rows = [[[0.0; 3]; 3]; 2];
            let mut rows = all_rows;
            for (side, first) in [(0, true), (1, false)] {
                let raw = c.rows(program.bodies[bodies[side]].axis, first);
                for k in 0..3 {
                    for f in 0..3 {
                        let unit = if f == 2 { df[2] } else { df[0] };
                        let value = if has[f] { raw[k][f] * unit / df[k] } else { 0.0 };
                        all_rows[side][k][f] = value;
                        rows[side][k][f] = if out.free[bodies[side]][k] { value } else { 0.0 };
                    }
                }
            }
            let mut local = Local {
                bodies,
                rows,
                all_rows,
                has,
                compliance: [
                    c.normal_compliance * stiffness,
                    c.tangential_compliance * stiffness,
                    0.0,
                ],
                linear: [
                    c.offset / du[0],
                    -c.tangential_compliance * stiffness * c.previous_shear / df[0],
                    0.0,
                ],
                limits: [[0.0; 3]; ROWS],
                right: [0.0; ROWS],
                count: 0,
            };
            let mut limit = |row: [f64; 3], right: f64| {
                local.limits[local.count] = row;
                local.right[local.count] = right;
                local.count += 1;
            };
            if l.has_shear() {
                limit([-l.friction, 1.0, 0.0], l.cohesion / df[0]);
                limit([-l.friction, -1.0, 0.0], l.cohesion / df[0]);
            }
            if l.has_rolling() {
                limit([-l.rolling / s.length, 0.0, 1.0], l.rolling * l.tension / df[2]);
                limit([-l.rolling / s.length, 0.0, -1.0], l.rolling * l.tension / df[2]);
            }
            if l.has_tension_row() {
                limit([-1.0, 0.0, 0.0], l.tension / df[0]);
            }
            out.locals.push(local);
        }
        out
    }

    /// Kinematics `e = G'u` of an interaction, fixed degrees of freedom included.
    #[must_use]
    pub fn kinematics(local: &Local, u: &[[f64; 3]]) -> [f64; 3] {
        transpose_times(&local.all_rows, &u[local.bodies[0]], &u[local.bodies[1]])
    }

    /// Adds `sign G s` to the rows of free degrees of freedom.
    pub fn add_forces(local: &Local, s: &[f64; 3], sign: f64, out: &mut [[f64; 3]]) {
        for side in 0..2 {
            let row = &mut out[local.bodies[side]];
            for k in 0..3 {
                let g = &local.rows[side][k];
                row[k] += sign * (g[0] * s[0] + g[1] * s[1] + g[2] * s[2]);
            }
        }
    }
}

/// `G' v` for rows of two bodies.
fn transpose_times(rows: &[[[f64; 3]; 3]; 2], a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    let mut e = [0.0; 3];
    for (f, e) in e.iter_mut().enumerate() {
        for k in 0..3 {
            *e += rows[0][k][f] * a[k] + rows[1][k][f] * b[k];
        }
    }
    e
}
