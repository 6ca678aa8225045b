//! Solving the cone program: the trait, the solvers, residuals and certificates.
//!
//! A solver reads the [`ConeProgram`] and writes a [`ConeSolution`]; how it ended is data. Whether
//! it is a solution is not for the solver to say: residuals and certificates are computed here,
//! from the forces and displacements alone.

pub mod certificate;
pub mod clarabel;
pub mod condensed;
pub mod coulomb;
mod lowering;
pub mod mechanism;
pub mod polish;
pub mod residuals;
pub mod sliding;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Mode};
use clastic_components::findings::Sliding;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind};
use clastic_components::program::{ConeProgram, ConeSolution, Dof, SolveStatus};

use self::sliding::{SlidingSolver, solve_sliding};
use crate::schedule::{AttemptIncrement, AttemptSystems, lap};

/// A program that no solver can read: an error of whoever assembled it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("malformed cone program: {0}")]
pub struct MalformedProgram(pub String);

/// Solves cone programs. A solver may keep what it likes between calls as long as its answer does
/// not depend on it beyond its tolerance; what its last bits depend on is its [`memory`](Self::memory).
pub trait ConeSolver: Send + Sync {
    /// Name for the record.
    fn name(&self) -> &'static str;

    /// Solves the program. Every ending of a well-formed program is a [`ConeSolution`].
    ///
    /// # Errors
    /// Only for a program that is malformed: indices out of range, numbers that are not finite,
    /// negative inertias, compliances or limits.
    fn solve(&mut self, program: &ConeProgram) -> Result<ConeSolution, MalformedProgram>;

    /// What the next answer depends on besides the program: where a warm start begins. By body
    /// in its own axes: two displacements, m, and a rotation, rad.
    /// A checkpoint stores it.
    fn memory(&self) -> &[[f64; 3]] {
        &[]
    }

    /// Goes on from the [`memory`](Self::memory) of another solver of the same kind.
    fn remember(&mut self, _memory: &[[f64; 3]]) {}
}

/// The solver of this world; [`Condensed`](condensed::Condensed) unless something else is said.
#[derive(Resource)]
pub struct Solver(pub Box<dyn ConeSolver>);

impl Default for Solver {
    fn default() -> Self {
        Self(Box::new(condensed::Condensed::default()))
    }
}

/// Adds [`solve_program`].
pub struct SolveProgramPlugin;

impl Plugin for SolveProgramPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ConeSolution>()
            .init_resource::<Solver>()
            .init_resource::<SlidingSolver>()
            .init_resource::<Sliding>()
            .add_systems(
                AttemptIncrement,
                (solve_program, solve_sliding, lap(|t| &mut t.solve))
                    .chain()
                    .in_set(AttemptSystems::Solve),
            );
    }
}

/// Solves the program and computes the residuals of what came back.
pub fn solve_program(
    program: Res<ConeProgram>,
    acceptance: Res<Acceptance>,
    analysis: Res<Analysis>,
    mut solver: ResMut<Solver>,
    mut attempt: ResMut<Attempt>,
    mut solution: ResMut<ConeSolution>,
) {
    let mut solve = |program: &ConeProgram| {
        if attempt.mode == Mode::Proof {
            Ok(mechanism::find(program))
        } else {
            solver.0.solve(program)
        }
    };
    *solution = match check(&program).and_then(|()| solve(&program)) {
        Ok(solution) => solution,
        Err(malformed) => ConeSolution { message: malformed.to_string(), ..Default::default() },
    };
    if matches!(solution.status, SolveStatus::Solved | SolveStatus::Stalled)
        && solution.forces.len() == program.interactions.len()
        && solution.displacements.len() == program.bodies.len()
    {
        let evaluate = if attempt.motion().is_some() {
            residuals::regularised_residuals
        } else {
            residuals::residuals
        };
        if let AnalysisKind::Dynamic { .. } = analysis.kind {
            displacements_from_forces(&program, &mut solution);
        }
        solution.residuals = evaluate(&program, &solution.forces, &solution.displacements);
        // The solver's word does not count, in either direction. NaN compares false.
        let enough = acceptance.residual.max(program.tolerance);
        let converged = solution.residuals.worst() <= enough;
        solution.status = if converged { SolveStatus::Solved } else { SolveStatus::Stalled };
    }
    attempt.solves += 1;
    attempt.iterations += solution.iterations;
}

/// Replaces the multipliers of degrees of freedom with inertia by `u = (load - G f)/inertia`, so
/// that momentum holds to round-off whatever the solver's tolerance. What the forces are off by then
/// shows in the motion: it is that motion whose residuals count.
fn displacements_from_forces(program: &ConeProgram, solution: &mut ConeSolution) {
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(&solution.forces, &mut rows);
    for ((body, row), u) in program.bodies.iter().zip(&rows).zip(&mut solution.displacements) {
        for k in 0..3 {
            if let Dof::Free(free) = &body.dofs[k]
                && free.inertia > 0.0
            {
                u[k] = (free.load - row[k]) / free.inertia;
            }
        }
    }
}

/// Refuses programs that are malformed.
fn check(program: &ConeProgram) -> Result<(), MalformedProgram> {
    let n = program.bodies.len();
    for (k, body) in program.bodies.iter().enumerate() {
        let sound = |dof: &Dof| match dof {
            Dof::Fixed(u) => u.is_finite(),
            Dof::Free(f) => {
                [f.load, f.momentum, f.reference].iter().all(|x| x.is_finite())
                    && [f.inertia, f.proximal].iter().all(|x| x.is_finite() && *x >= 0.0)
            }
        };
        if !body.axis.is_finite() || !body.dofs.iter().all(sound) {
            return Err(MalformedProgram(format!(
                "body {k} has a number that is not finite, or a negative inertia"
            )));
        }
    }
    for (k, c) in program.interactions.iter().enumerate() {
        if c.a as usize >= n || c.b as usize >= n || c.a == c.b {
            return Err(MalformedProgram(format!(
                "interaction {k} joins bodies {} and {} of {n}",
                c.a, c.b
            )));
        }
        let l = &c.limits;
        let numbers = [
            c.normal.x,
            c.normal.y,
            c.arm_a,
            c.arm_b,
            c.offset,
            c.normal_compliance,
            c.tangential_compliance,
            c.previous_shear,
            l.cohesion,
            l.friction,
            l.tension,
            l.rolling,
            l.moment,
        ];
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err(MalformedProgram(format!(
                "interaction {k} of bodies {} and {} has a number that is not finite",
                c.a, c.b
            )));
        }
        let not_negative = [
            c.normal_compliance,
            c.tangential_compliance,
            l.cohesion,
            l.friction,
            l.tension,
            l.rolling,
            l.moment,
        ];
        if not_negative.iter().any(|x| *x < 0.0) {
            return Err(MalformedProgram(format!(
                "interaction {k} of bodies {} and {} has a negative compliance or limit",
                c.a, c.b
            )));
        }
    }
    Ok(())
}
