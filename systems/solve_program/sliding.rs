//! Sliding under Coulomb's law: takes the dilation of the associated law out of the solution.

use bevy_ecs::prelude::*;

use clastic_components::attempt::Attempt;
use clastic_components::contact::Bodies;
use clastic_components::findings::Sliding;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind, FrictionLaw};
use clastic_cone::coulomb::Coulomb;
use clastic_cone::program::{ConeProgram, ConeSolution, SolveStatus};
use clastic_cone::residuals;

use crate::mean_field::furthest;

/// Number of solves without success after which the other solves of the increment are quick.
const MAX_FAILURES: u32 = 4;
/// Factorisations of a quick solve at most.
const QUICK: u32 = 40;

/// Safety factor: the solver aims at 0.9 times the accepted residual.
const MARGIN: f64 = 0.9;

/// The solver of this world, with what it keeps between increments.
#[derive(Resource, Default)]
pub struct SlidingSolver(Coulomb);

/// Solves the program of an equilibrium, or of a time step, again without the dilation of contacts that slide or
/// roll. Contacts with strength keep it: their law is that of the bond. So do the steps of a followed motion, of
/// which only the place where it comes to rest matters, and the proof of a collapse, which holds for both laws.
///
/// What does not converge is kept with its residual; [`coulomb::judge`](crate::attempt::coulomb::judge) says
/// what becomes of it.
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
    // The solver counts the regularisation as a part of the program, the residual below counts it as an error:
    // a margin keeps a solution that just passes from failing.
    let patient = finding.failures < MAX_FAILURES;
    let max = if patient { law.factorisations } else { law.factorisations.min(QUICK) };
    let found = solver.0.solve(&program, &solution, MARGIN * enough, max);
    finding.failures += u32::from(found.status != SolveStatus::Solved);
    attempt.iterations += found.iterations;
    solution.forces = found.forces;
    solution.displacements = found.displacements;
    solution.residuals = residuals::residuals(&program, &solution.forces, &solution.displacements);
    let worst = solution.residuals.worst();
    // The status stays: how the solve ended is said by the finding.
    finding.natural_map =
        residuals::natural_map(&program, &solution.forces, &solution.displacements);
    finding.lost = !(worst <= enough.max(Sliding::BOUND));
    finding.capped = !finding.lost && worst > enough;
}
