//! Sliding under Coulomb's law: removes the dilation of the associated law from the solution.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Mode};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::{Corrections, Sliding};
use clastic_components::increment::{
    Acceptance, AnalysisKind, ClasticAnalysis, ClasticProgress, FrictionLaw,
};
use clastic_cone::coulomb::{Coulomb, Goal};
use clastic_cone::program::{ConeProgram, ConeSolution, SlidingLaw, SolveStatus};
use clastic_cone::residuals;

use super::Solver;
use crate::solved::Solved;
use crate::turns::too_far;

/// Number of failed solves after which the other solves of the increment are quick.
const MAX_FAILURES: u32 = 4;
/// Maximum number of factorisations of a quick solve. Steps of a motion are quick: a step without a
/// solution is made again with a larger inertia.
const QUICK: u32 = 40;
/// Maximum number of factorisations of a time step that may be halved. Solves that succeed mostly take fewer;
/// 2000 disks to 1e-4 take 11 736 with it and 17 461 without, for twelve more steps (decision 004).
const OF_TIME_STEP: u32 = 120;

/// Safety factor: the solver aims at 0.9 times the tolerance.
pub const MARGIN: f64 = 0.9;

/// The solver of the world, with its memory between increments.
#[derive(Resource, Default)]
pub(crate) struct SlidingSolver(Coulomb);

/// The law of the programs of an attempt that are solved without dilation; `None` if they keep it.
/// The proof of a collapse keeps it, because it holds for both laws. A followed motion keeps it
/// until Coulomb's law has rejected an equilibrium of the increment. Without it, motions would rest
/// where the associated law does.
pub fn law_of(
    law: &FrictionLaw,
    analysis: &ClasticAnalysis,
    attempt: &Attempt,
    finding: &Sliding,
) -> Option<clastic_components::increment::Coulomb> {
    let is_left_out =
        attempt.mode == Mode::Proof || (attempt.motion().is_some() && finding.rejected.is_none());
    law.coulomb(analysis.kind).filter(|_| !is_left_out)
}

/// Solves the program of an equilibrium or a time step again under Coulomb's law.
///
/// A solution that did not converge is kept with its residual.
/// [`coulomb::judge`](crate::attempt::coulomb::judge) decides on it.
pub(crate) fn solve_sliding(
    law: Res<FrictionLaw>,
    (acceptance, progress): (Res<Acceptance>, Res<ClasticProgress>),
    analysis: Res<ClasticAnalysis>,
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    corrections: Res<Corrections>,
    mut associated: ResMut<Solver>,
    mut solver: ResMut<SlidingSolver>,
    program: Res<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
    mut attempt: ResMut<Attempt>,
    mut finding: ResMut<Sliding>,
) {
    let Sliding { failures, rejected, .. } = *finding;
    *finding = Sliding { failures, rejected, ..Sliding::default() };
    let Some(law) = law_of(&law, &analysis, &attempt, &finding) else { return };
    let is_swept = solution.law == SlidingLaw::Coulomb;
    if !is_swept && solution.status != SolveStatus::Solved {
        return;
    }
    let moves = attempt.motion().is_some();
    // A solution that goes too far is rejected in any case.
    let is_static = analysis.kind == AnalysisKind::Static;
    let solved =
        Solved { bodies: &bodies, contacts: &contacts, program: &program, solution: &solution };
    if is_static && too_far(solved, &acceptance, &corrections).is_some() {
        return;
    }
    let bound = Sliding::bound(&acceptance);
    // What an equilibrium leaves out of balance drives the motion after it: a step that leaves as much
    // moves nothing.
    let enough = if moves { bound } else { solution.tolerance };
    // The solver treats the regularisation as part of the program, but the residual below counts it
    // as an error. The margin keeps a solution that just converges from failing.
    let max = match finding.failures < MAX_FAILURES && !moves {
        true if is_static || !acceptance.halves(progress.fraction) => law.factorisations,
        true => law.factorisations.min(OF_TIME_STEP),
        false => law.factorisations.min(QUICK),
    };
    let aim = MARGIN * enough;
    let asked = super::asked(enough, &analysis, &attempt, &bodies);
    // The first point within the tolerance suffices in time steps where it does for the associated
    // law. Solutions of a static increment are exact, those of its motions included.
    let at_once = !is_static && associated.0.first_point_suffices(&program, asked);
    let goal = Goal { tolerance: aim, at_once };
    // The last forces are the second start, with a tenth of the factorisations. After a motion they
    // belong to its state at rest, from which the associated solution may be far away. Sweeps begin
    // with them.
    let last = if is_swept { None } else { last_solution(&program) };
    let (of_first, of_second) = match last {
        Some(_) if rejected.is_none() => (max - max / 10, max / 10),
        _ => (max, max),
    };
    let mut found = solver.0.solve(&program, &solution, goal, of_first);
    attempt.iterations += found.iterations;
    if found.status != SolveStatus::Solved
        && let Some(last) = last
    {
        let other = solver.0.solve(&program, &last, goal, of_second);
        attempt.iterations += other.iterations;
        let worst = |s: &ConeSolution| super::residuals_of(&attempt, &program, s).worst();
        if other.status == SolveStatus::Solved || worst(&other) < worst(&found) {
            found = other;
        }
    }
    finding.failures += u32::from(!moves && found.status != SolveStatus::Solved);
    solution.status = SolveStatus::Solved;
    solution.law = found.law;
    solution.message = found.message;
    solution.forces = found.forces;
    solution.displacements = found.displacements;
    solution.residuals = super::residuals_of(&attempt, &program, &solution);
    if is_swept {
        associated.0.remember(&solution.displacements);
    }
    let worst = solution.residuals.worst();
    // The status is that of the associated law or of a start. The finding has the result.
    finding.natural_map = residuals::natural_map(&program, &solution);
    finding.lost = !(worst <= bound);
    if finding.lost && !moves {
        finding.rejected = Some(rejected.map_or(worst, |least| least.min(worst)));
    }
    finding.capped = !finding.lost && worst > enough;
}

/// The state after the last solution: its forces, and only imposed motion. Near rest it is closer
/// to the next solution than the associated one, and it has the sliding contacts of Coulomb's law.
/// `None` if nothing carried a force.
fn last_solution(program: &ConeProgram) -> Option<ConeSolution> {
    let mut forces = program.last_forces.clone();
    forces.resize(program.interactions.len(), [0.0; 3]);
    forces.iter().any(|f| f[0] != 0.0).then(|| ConeSolution {
        law: SlidingLaw::Coulomb,
        forces,
        displacements: program.imposed(),
        ..ConeSolution::default()
    })
}
