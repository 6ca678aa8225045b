//! Sliding under Coulomb's law: removes the dilation of the associated law from the solution.

use bevy_ecs::prelude::*;

use clastic_components::attempt::Attempt;
use clastic_components::contact::Bodies;
use clastic_components::findings::Sliding;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind, FrictionLaw};
use clastic_cone::coulomb::Coulomb;
use clastic_cone::program::{ConeProgram, ConeSolution, SolveStatus};
use clastic_cone::residuals;

use crate::mean_field::furthest;

/// Number of failed solves after which the other solves of the increment are quick.
const MAX_FAILURES: u32 = 4;
/// Maximum number of factorisations of a quick solve.
const QUICK: u32 = 40;

/// Safety factor: the solver aims at 0.9 times the tolerance.
const MARGIN: f64 = 0.9;

/// The solver of the world, with its memory between increments.
#[derive(Resource, Default)]
pub struct SlidingSolver(Coulomb);

/// Solves the program of an equilibrium, or of a time step, again without the dilation of contacts
/// that slide or roll. Interactions with strength keep the dilation: their law is that of the bond.
/// Steps of a followed motion keep it, because only the position at rest matters. The proof of a
/// collapse keeps it, because it holds for both laws.
///
/// A solution that did not converge is kept with its residual.
/// [`coulomb::judge`](crate::attempt::coulomb::judge) decides on it.
pub fn solve_sliding(
    law: Res<FrictionLaw>,
    acceptance: Res<Acceptance>,
    analysis: Res<Analysis>,
    bodies: Res<Bodies>,
    mut solver: ResMut<SlidingSolver>,
    mut program: ResMut<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
    mut attempt: ResMut<Attempt>,
    mut finding: ResMut<Sliding>,
) {
    *finding = Sliding { failures: finding.failures, ..Sliding::default() };
    let Some(law) = law.coulomb(analysis.kind) else { return };
    if attempt.effort().is_none() || solution.status != SolveStatus::Solved {
        return;
    }
    // A throw is rejected in any case.
    let far = furthest(&bodies, &program, &solution).map_or(0.0, |(_, far)| far);
    if analysis.kind == AnalysisKind::Static && far > acceptance.throw {
        return;
    }
    for c in &mut program.interactions {
        c.dilation = f64::from(u8::from(c.limits.has_strength()));
    }
    let enough = acceptance.residual.max(program.tolerance);
    // The solver treats the regularisation as part of the program, but the residual below counts it
    // as an error. The margin keeps a solution that just converges from failing.
    let patient = finding.failures < MAX_FAILURES;
    let max = if patient { law.factorisations } else { law.factorisations.min(QUICK) };
    let found = solver.0.solve(&program, &solution, MARGIN * enough, max);
    finding.failures += u32::from(found.status != SolveStatus::Solved);
    attempt.iterations += found.iterations;
    solution.forces = found.forces;
    solution.displacements = found.displacements;
    solution.residuals = residuals::residuals(&program, &solution.forces, &solution.displacements);
    let worst = solution.residuals.worst();
    // The status is not changed. The finding contains the result of this solve.
    finding.natural_map =
        residuals::natural_map(&program, &solution.forces, &solution.displacements);
    finding.lost = !(worst <= enough.max(Sliding::BOUND));
    finding.capped = !finding.lost && worst > enough;
}
