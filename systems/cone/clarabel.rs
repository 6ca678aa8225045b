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
use super::lowering::lower;
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
        if let Some((body, dof)) = low.unbalanced {
            return Ok(lonely_collapse(program, body, dof));
        }
        if low.linear.is_empty() {
            return Ok(ConeSolution {
                status: SolveStatus::Solved,
                displacements: program.imposed(),
                ..Default::default()
            });
        }
        let p = diagonal(&low.quadratic);
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
                return Ok(solution);
            }
            // Clarabel may give up on an infeasible program: the mechanism proves the collapse, not
            // the status.
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

fn diagonal(entries: &[f64]) -> CscMatrix<f64> {
    let n = entries.len();
    CscMatrix::new(n, n, (0..=n).collect(), (0..n).collect(), entries.to_vec())
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
