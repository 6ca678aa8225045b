//! The linear response of a solution: how bodies move if its forces are out of balance by a little.
//!
//! The stiffness is that of the forces that the solution has: contacts that are open have none,
//! and one that slides has none along itself. A rigid contact has a small compliance, so that one
//! matrix serves all programs.

use super::matrix::BodyMatrix;
use super::scaled::Local;
use crate::program::{ConeProgram, ConeSolution, Interaction};
use crate::residuals::Carrying;

/// Minimum compliance over displacement scale/force scale.
const MIN_COMPLIANCE: f64 = 1e-6;
/// Stiffness of bodies that nothing holds, over the maximum of the matrix.
const MIN_STIFFNESS: f64 = 1e-12;

/// The matrix of the last program, kept while its pairs stay.
#[derive(Default)]
pub struct LinearResponse(BodyMatrix);

impl LinearResponse {
    /// Displacements, m and rad, by body in its own axes, that balance the `loads`, N and N m, by
    /// body in its own axes, and the forces with which interactions answer to a `misfit`, m, of
    /// closing and slip. `None` where the stiffness has no factor.
    pub fn to(
        &mut self,
        program: &ConeProgram,
        solution: &ConeSolution,
        loads: &[[f64; 3]],
        misfits: &[[f64; 2]],
    ) -> Option<Vec<[f64; 3]>> {
        let matrix = &mut self.0;
        let scaled = matrix.pose(program);
        let (du, df) = program.scales.units();
        let carrying = Carrying::new(program, solution);
        let mut x = vec![[0.0; 3]; scaled.places()];
        for (x, body) in x.iter_mut().zip(matrix.order()) {
            *x = [0, 1, 2].map(|k| loads[*body][k] / df[k]);
        }
        matrix.clear();
        let mut values = matrix.assembly();
        for (k, (local, c)) in scaled.locals.iter().zip(&program.interactions).enumerate() {
            if c.limits.has_strength() || carrying.is_carrying(k) {
                let d = stiffness(c, &solution.forces[k], local);
                values.add(k, &local.arms.rows, &d);
                let e = misfits.get(k).map_or([0.0; 2], |e| [e[0] / du[0], e[1] / du[0]]);
                let force = [d[0][0] * e[0], d[1][1] * e[1], 0.0];
                local.arms.add_forces(&force, -1.0, &mut x);
            }
        }
        let floor = MIN_STIFFNESS * matrix.max_diagonal().max(f64::MIN_POSITIVE);
        matrix.assembly().add_weights(&scaled, floor);
        scaled.images.fold(&mut x);
        scaled.clear_fixed(&mut x);
        if !matrix.factorise_shifted_and_solve(&mut x) {
            return None;
        }
        let mut out = vec![[0.0; 3]; program.bodies.len()];
        for (i, k) in scaled.all_free() {
            out[matrix.order()[i]][k] = x[i][k] * du[k];
        }
        Some(out)
    }
}

/// Stiffness of an interaction that carries the forces `f`.
fn stiffness(c: &Interaction, f: &[f64; 3], local: &Local) -> [[f64; 3]; 3] {
    let mut d = [[0.0; 3]; 3];
    for (i, gives_way) in [false, c.limits.slides(f), c.limits.rolls(f)].into_iter().enumerate() {
        if local.has[i] && !gives_way {
            d[i][i] = local.compliance[i].max(MIN_COMPLIANCE).recip();
        }
    }
    d
}
