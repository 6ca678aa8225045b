//! Judge: did the solve end in a state that its residuals or its certificate support?

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, IncrementStatus, Verdict};
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::increment::Acceptance;
use clastic_components::program::{Certificate, ConeProgram, ConeSolution, SolveStatus};

use super::magnitudes;
use super::thrown_grains::{reply, thrown};
use crate::detect_contacts::Candidates;
use crate::solve_program::certificate::{certificate, proves};
use crate::solve_program::residuals::regularised_residuals;

/// Moves of the centre of the regularisation in one attempt.
const MAX_CENTRES: u32 = 6;

/// Accepts solved and collapsed programs, moves the centre of the regularisation until its bias is
/// gone, rejects the rest. A bias because grains move far is a throw.
pub fn judge(
    program: Res<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
    acceptance: Res<Acceptance>,
    bodies: Res<Bodies>,
    candidates: Res<Candidates>,
    contacts: Res<Contacts>,
    mut attempt: ResMut<Attempt>,
) {
    attempt.status = match solution.status {
        SolveStatus::Solved => IncrementStatus::Solved,
        SolveStatus::Collapsed => IncrementStatus::Collapsed,
        SolveStatus::Locked => IncrementStatus::Locked,
        SolveStatus::Stalled => IncrementStatus::Stalled,
    };
    if solution.status == SolveStatus::Stalled && attempt.settling.is_none() {
        keep_best(&solution, &mut attempt);
    }
    attempt.verdict = match solution.status {
        SolveStatus::Solved => match runaway(&program, &solution) {
            None => Verdict::Accept,
            Some(body) => {
                let reason = format!("body {body} leaves without end: nothing holds it");
                attempt.status = IncrementStatus::Stalled;
                collapsed_or(&program, &mut solution, &mut attempt, Verdict::Reject(reason))
            }
        },
        // The solver's word does not count.
        SolveStatus::Collapsed => match recheck(&program, &solution) {
            Some(mechanism) => {
                solution.certificate = Some(mechanism);
                Verdict::Accept
            }
            None => Verdict::Reject("the solver reports a collapse that it cannot prove".into()),
        },
        SolveStatus::Locked => {
            Verdict::Reject("locked: rigid bodies have no feasible motion".into())
        }
        SolveStatus::Stalled if biased(&program, &solution, &acceptance) => {
            if let Some(reason) = thrown(&bodies, &program, &solution, &acceptance) {
                // A grain that finds no support must not have been kept from it by pruning.
                match reply(
                    &bodies,
                    &candidates,
                    &contacts,
                    &program,
                    &solution,
                    &acceptance,
                    &mut attempt,
                    reason,
                ) {
                    Verdict::Again => Verdict::Again,
                    thrown if attempt.learnt => thrown,
                    thrown => collapsed_or(&program, &mut solution, &mut attempt, thrown),
                }
            } else if attempt.centres < MAX_CENTRES {
                attempt.centres += 1;
                attempt.centre.clone_from(&solution.displacements);
                Verdict::Again
            } else {
                let reason = Verdict::Reject(complaint(&attempt, &acceptance));
                collapsed_or(&program, &mut solution, &mut attempt, reason)
            }
        }
        SolveStatus::Stalled => Verdict::Reject(complaint(&attempt, &acceptance)),
    };
    if matches!(attempt.verdict, Verdict::Reject(_)) {
        attempt.magnitudes = magnitudes(&solution, bodies.mean_radius);
    }
}

/// A motion beyond so many mean radii is none: a load that nothing takes up, in a solution that only
/// the solver's own damping keeps finite.
const NO_MOTION: f64 = 1e6;

/// The first body that a solution moves without end.
fn runaway(program: &ConeProgram, solution: &ConeSolution) -> Option<usize> {
    let most = NO_MOTION * program.scales.length;
    solution.displacements.iter().position(|u| !(u[0].hypot(u[1]) <= most))
}

/// What a regularised solution moves far may be the mechanism of a collapse: loads that nothing
/// balances move without end.
fn collapsed_or(
    program: &ConeProgram,
    solution: &mut ConeSolution,
    attempt: &mut Attempt,
    otherwise: Verdict,
) -> Verdict {
    match certificate(program, &solution.displacements).filter(proves) {
        Some(mechanism) => {
            solution.status = SolveStatus::Collapsed;
            solution.certificate = Some(mechanism);
            attempt.status = IncrementStatus::Collapsed;
            Verdict::Accept
        }
        None => otherwise,
    }
}

/// The certificate of a collapse by our own count, if it proves it.
fn recheck(program: &ConeProgram, solution: &ConeSolution) -> Option<Certificate> {
    let claimed = solution.certificate.as_ref()?;
    certificate(program, &claimed.mechanism).filter(proves)
}

/// Whether a solution would have converged but for what the regularisation adds to the balance.
fn biased(program: &ConeProgram, solution: &ConeSolution, acceptance: &Acceptance) -> bool {
    let sound = solution.forces.len() == program.interactions.len()
        && solution.displacements.len() == program.bodies.len();
    sound
        && regularised_residuals(program, &solution.forces, &solution.displacements).worst()
            <= acceptance.residual
}

/// Keeps the residuals of the solution that came closest in this increment. What is regularised has
/// its bias in them, so that later attempts may be further off than the first.
fn keep_best(solution: &ConeSolution, attempt: &mut Attempt) {
    let worst = solution.residuals.worst();
    if attempt.best.as_ref().is_none_or(|(best, _)| !(best.worst() <= worst)) {
        attempt.best = Some((solution.residuals, solution.message.clone()));
    }
}

fn complaint(attempt: &Attempt, acceptance: &Acceptance) -> String {
    let Some((r, message)) = &attempt.best else { return "no solution was found".to_owned() };
    format!(
        "no solution was found; residuals of the best one: balance {:.1e}, kinematics {:.1e}, cone \
         {:.1e}, complementarity {:.1e}; accepted {:.0e} (the solver says \"{message}\")",
        r.balance, r.kinematics, r.cone, r.complementarity, acceptance.residual
    )
}
