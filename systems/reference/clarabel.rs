//! Clarabel, an interior-point solver for conic programs, behind [`ConeSolver`].

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};

use clastic_cone::certificate::{certificate, locks, proves};
use clastic_cone::program::{ConeProgram, ConeSolution, SolveStatus};
use clastic_cone::solver::{ConeSolver, MalformedProgram};

use crate::polish::{Point, PolishSettings, polish};
use crate::standard_form::lower;

/// Clarabel with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clarabel {
    /// Tolerance on feasibility and gap, in scaled units.
    pub tolerance: f64,
    /// Cap on iterations.
    pub max_iterations: u32,
    /// Settings of the polish of its solutions; `None` for no polish.
    pub polish: Option<PolishSettings>,
}

impl Default for Clarabel {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_iterations: 200, polish: Some(PolishSettings::default()) }
    }
}

impl ConeSolver for Clarabel {
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
