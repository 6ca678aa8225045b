//! The linear response of a solution: how bodies move if its forces are out of balance by a little.
//!
//! The stiffness is that of the forces that the solution has: contacts that are open have none, and a
//! force on its limit follows the normal force. A rigid contact has a small compliance, so that one
//! matrix serves all programs.

use super::matrix::BodyMatrix;
use super::scaled::Local;
use crate::program::{ConeProgram, ConeSolution, Interaction, SlidingLaw};
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
                let d = stiffness(c, &solution.forces[k], local, solution.law);
                values.add(k, &local.arms.rows, &d);
                let e = misfits.get(k).map_or([0.0; 2], |e| [e[0] / du[0], e[1] / du[0]]);
                let force = d.map(|row| row[0] * e[0] + row[1] * e[1]);
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

/// Stiffness of an interaction that carries the forces `f`. A force on its limit `m p` has none of its own:
/// it follows p, and its slip opens the interaction by m times as much, where the law dilates.
fn stiffness(c: &Interaction, f: &[f64; 3], local: &Local, law: SlidingLaw) -> [[f64; 3]; 3] {
    let compliance = local.compliance.map(|compliance| compliance.max(MIN_COMPLIANCE));
    let yields = [false, c.limits.slides(f), c.limits.rolls(f)];
    let mut d = [[0.0; 3]; 3];
    let (mut along, mut below) = ([1.0, 0.0, 0.0], compliance[0]);
    for x in (1..3).filter(|x| local.has[*x]) {
        if yields[x] {
            along[x] = law.dilation(c) * local.slopes[x - 1] * f[x].signum();
            below += along[x] * along[x] * compliance[x];
        } else {
            d[x][x] = compliance[x].recip();
        }
    }
    for (i, row) in d.iter_mut().enumerate() {
        for (j, d) in row.iter_mut().enumerate() {
            *d += along[i] * along[j] / below;
        }
    }
    d
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::Condensed;
    use super::super::tests::{contact, held, loaded};
    use super::*;
    use crate::solver::ConeSolver as _;

    /// A body that slides on one contact and rests against another: the response to further loads is the
    /// difference of two solutions. What slides opens its contact by mu times the slip.
    #[test]
    fn a_body_that_slides_responds_as_it_is_solved() {
        let program = |x: f64, y: f64| ConeProgram {
            bodies: vec![held(), loaded(x, y)],
            interactions: vec![
                contact(0, 1, DVec2::Y, 0.1, 0.5),
                contact(0, 1, DVec2::X, 0.2, 0.0),
            ],
            ..ConeProgram::default()
        };
        let solve = |program: &ConeProgram| Condensed::default().solve(program, 0.0).unwrap();
        let start = program(-3.0, -2.0);
        let (before, after) = (solve(&start), solve(&program(-3.1, -1.8)));
        assert!(start.interactions[0].limits.slides(&before.forces[0]), "{:?}", before.forces);
        let loads = [[0.0; 3], [-0.1, 0.2, 0.0]];
        let response = LinearResponse::default().to(&start, &before, &loads, &[]).unwrap();
        for k in 0..3 {
            let moved = after.displacements[1][k] - before.displacements[1][k];
            assert!((response[1][k] - moved).abs() < 1e-8, "{response:?} {moved}");
        }
    }
}
