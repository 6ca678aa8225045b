//! Solves the cone program with the solver of the world and computes the residuals.

pub mod sliding;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::attempt::Attempt;
use clastic_components::contact::BodyTable;
use clastic_components::contact_history::KeptRows;
use clastic_components::findings::Sliding;
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis, FrictionLaw};
use clastic_cone::condensed;
use clastic_cone::coulomb::Coulomb;
use clastic_cone::program::{ConeProgram, ConeSolution, Residuals, SlidingLaw, SolveStatus};
use clastic_cone::residuals;
use clastic_cone::solver::{ConeSolver, check};

use self::sliding::{SlidingSolver, solve_sliding};
use crate::rigid_groups::{carry_members, has_groups};
use crate::schedule::{AttemptIncrement, AttemptSystems, Increment, IncrementSystems, lap};
use crate::state::RegisterState;

/// The solver of the world; [`Condensed`](condensed::Condensed) by default.
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
        // The warm start is state; the solver itself follows from the settings.
        app.register_part(
            SOLVER_MEMORY,
            |world| world.get_resource::<Solver>().map(|solver| solver.0.memory().to_vec()),
            |memory, world| {
                if let Some(mut solver) = world.get_resource_mut::<Solver>() {
                    solver.0.remember(&memory);
                }
            },
        );
        app.init_resource::<ConeSolution>()
            .init_resource::<Solver>()
            .init_resource::<SlidingSolver>()
            .init_resource::<Sliding>()
            .add_systems(Increment, renumber_memory.in_set(IncrementSystems::Renumber))
            .add_systems(
                AttemptIncrement,
                (
                    solve_program,
                    carry_members.run_if(has_groups),
                    solve_sliding,
                    carry_members.run_if(has_groups),
                    lap(|t| &mut t.solve),
                )
                    .chain()
                    .in_set(AttemptSystems::Solve),
            );
    }
}

/// Name of the memory of the solver in a state.
pub const SOLVER_MEMORY: &str = "solver.memory";

/// Updates the rows of bodies. New bodies have no warm start.
fn renumber_memory(rows: Res<KeptRows>, bodies: Res<BodyTable>, mut solver: ResMut<Solver>) {
    if solver.0.memory().is_empty() {
        return;
    }
    let memory = rows.table(solver.0.memory(), bodies.ids.len());
    solver.0.remember(&memory);
}

/// Residual at which the solver may stop in a step of a motion under the associated law. Only the equilibrium after the
/// motion is committed.
const RESIDUAL_OF_MOTION: f64 = 1e-3;

/// Residual at which the solver may stop, given the one that is accepted; 0 means the default of
/// the solver. Loading of bonds to their limits requires the default, because errors could change
/// which bond breaks.
fn asked(accepted: f64, analysis: &ClasticAnalysis, attempt: &Attempt, bodies: &BodyTable) -> f64 {
    let is_time_step = analysis.kind.dt().is_some() && bodies.bonds.is_empty();
    if attempt.motion().is_some() || is_time_step { accepted } else { 0.0 }
}

/// Residuals of a solution. The proximal terms of a followed motion are its inertia and belong to
/// the balance; those of a regularisation are an error of it.
fn residuals_of(attempt: &Attempt, program: &ConeProgram, solution: &ConeSolution) -> Residuals {
    if attempt.motion().is_some() {
        residuals::regularised_residuals(program, solution)
    } else {
        residuals::residuals(program, solution)
    }
}

/// Solves the program and computes the residuals of the solution.
pub fn solve_program(
    law: Res<FrictionLaw>,
    finding: Res<Sliding>,
    acceptance: Res<Acceptance>,
    analysis: Res<ClasticAnalysis>,
    bodies: Res<BodyTable>,
    program: Res<ConeProgram>,
    mut solver: ResMut<Solver>,
    mut attempt: ResMut<Attempt>,
    mut solution: ResMut<ConeSolution>,
) {
    let accepted = acceptance.residual;
    let enough =
        if attempt.motion().is_some() { accepted.max(RESIDUAL_OF_MOTION) } else { accepted };
    let is_sliding = sliding::law_of(&law, &analysis, &attempt, &finding).is_some();
    let tolerance = asked(enough, &analysis, &attempt, &bodies);
    let mut solve = |program: &ConeProgram| {
        let aim = sliding::MARGIN * enough;
        let swept = is_sliding.then(|| Coulomb::sweep(program, solver.0.memory(), aim)).flatten();
        // Where sweeps succeed, `solve_sliding` needs no associated solution.
        swept.map_or_else(|| solver.0.solve(program, tolerance), Ok)
    };
    *solution = match check(&program).and_then(|()| solve(&program)) {
        Ok(solution) => solution,
        Err(malformed) => ConeSolution { message: malformed.to_string(), ..Default::default() },
    };
    solution.tolerance = enough;
    if solution.law == SlidingLaw::Associated
        && matches!(solution.status, SolveStatus::Solved | SolveStatus::Stalled)
        && solution.forces.len() == program.interactions.len()
        && solution.displacements.len() == program.bodies.len()
    {
        solution.residuals = if let AnalysisKind::Dynamic { .. } = analysis.kind {
            residuals::choose_displacements(&program, &mut solution, enough)
        } else {
            residuals_of(&attempt, &program, &solution)
        };
        // The status follows from the residuals and not from the solver, in either direction. NaN
        // compares false.
        let converged = solution.residuals.worst() <= enough;
        solution.status = if converged { SolveStatus::Solved } else { SolveStatus::Stalled };
    }
    attempt.solves += 1;
    attempt.iterations += solution.iterations;
}
