//! Judge: do the residuals or the certificate confirm the result of the solver?

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Effort, Mode, Verdict};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::{Centre, Corrections, Unconverged};
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis};
use clastic_cone::program::{Certificate, ConeProgram, ConeSolution, SolveStatus};

use crate::assemble_program::regularise::max_moves;
use crate::assemble_program::scales::MAX_MOTION;
use crate::ending;
use crate::places::{moves_most, near, worst_place};
use crate::solved::Solved;
use crate::turns::too_far;
use clastic_cone::certificate::{certificate, proves};
use clastic_cone::residuals::{displacement_scale, regularised_residuals};

/// Accepts solved programs and proven collapses, moves the centre of the regularisation until its
/// bias vanishes, and rejects all else. A bias together with a far turn is left to
/// [`closed_pairs`](super::closed_pairs) and [`too_far`](super::too_far), one of which rejects it.
pub fn judge(
    program: Res<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
    acceptance: Res<Acceptance>,
    analysis: Res<ClasticAnalysis>,
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    mut centre: ResMut<Centre>,
    mut corrections: ResMut<Corrections>,
    mut attempt: ResMut<Attempt>,
) {
    let solution = &mut *solution;
    let solved = Solved { bodies: &bodies, contacts: &contacts, program: &program, solution };
    let seeks_equilibrium = matches!(attempt.mode, Mode::Equilibrium(_));
    if solution.status == SolveStatus::Stalled && seeks_equilibrium {
        keep_best(solved, &mut attempt.best);
    }
    let is_static = analysis.kind == AnalysisKind::Static;
    attempt.verdict = match solution.status {
        SolveStatus::Solved => Verdict::Sound,
        // Grains without bonds that have no equilibrium nearby are followed until they lie elsewhere.
        SolveStatus::Collapsed
            if attempt.mode == Mode::Equilibrium(Effort::Usual) && !program.has_bonds() =>
        {
            Verdict::Unconverged(format!("no equilibrium is near{}", most_moved(solved, ": ")))
        }
        // The status of the solver alone is not sufficient.
        SolveStatus::Collapsed => match recheck(&program, solution) {
            Some(mechanism) => {
                solution.certificate = Some(mechanism);
                Verdict::Impossible
            }
            None => Verdict::Unconverged(format!(
                "the solver reports a collapse that it cannot prove{}",
                most_moved(solved, ", in which ")
            )),
        },
        SolveStatus::Locked => Verdict::Locked,
        SolveStatus::Stalled if seeks_equilibrium && is_biased(&program, solution) => {
            if is_static && too_far(solved, &acceptance, &corrections).is_some() {
                // A grain that lacks support does not find it where the centre goes.
                Verdict::Sound
            } else if centre.moves < max_moves(&acceptance) {
                centre.moves += 1;
                centre.place.clone_from(&solution.displacements);
                Verdict::Again
            } else {
                let verdict = Verdict::Unconverged(complaint(&attempt.best, solution.tolerance));
                impossible_or(&program, solution, verdict)
            }
        }
        SolveStatus::Stalled => Verdict::Unconverged(complaint(&attempt.best, solution.tolerance)),
    };
    let fails =
        matches!(attempt.verdict, Verdict::Impossible | Verdict::Locked | Verdict::Unconverged(_));
    if fails && corrections.passes > 0 {
        // A guess of the end proves nothing.
        let why = match std::mem::take(&mut attempt.verdict) {
            Verdict::Unconverged(why) => why,
            Verdict::Locked => "in one of them rigid bodies have no feasible motion".to_owned(),
            _ => "one of them has no equilibrium".to_owned(),
        };
        attempt.verdict = ending::fail(&mut corrections, &why);
    }
    if attempt.verdict != Verdict::Impossible {
        // A solution has a certificate only if it proves a collapse.
        solution.certificate = None;
    }
    if matches!(attempt.verdict, Verdict::Unconverged(_)) && seeks_equilibrium {
        attempt.magnitudes = magnitudes(&program, solution);
    }
    if attempt.verdict == Verdict::Locked {
        attempt.complaint = locked(&bodies, &program, solution);
    }
}

/// Tests whether a far motion in a regularised solution is the mechanism of a collapse: unbalanced
/// loads move bodies without bound.
pub(super) fn impossible_or(
    program: &ConeProgram,
    solution: &mut ConeSolution,
    otherwise: Verdict,
) -> Verdict {
    match certificate(program, &solution.displacements).filter(proves) {
        Some(mechanism) => {
            solution.status = SolveStatus::Collapsed;
            solution.certificate = Some(mechanism);
            Verdict::Impossible
        }
        None => otherwise,
    }
}

/// The body that moves most in the mechanism of a collapse, behind these words; empty without one.
fn most_moved(Solved { bodies, program, solution, .. }: Solved, words: &str) -> String {
    let mechanism = solution.certificate.as_ref();
    let most = mechanism.and_then(|m| moves_most(bodies, program, &m.mechanism));
    most.map_or(String::new(), |most| format!("{words}{most}"))
}

/// Recomputes the certificate of a collapse; `None` if it proves nothing.
fn recheck(program: &ConeProgram, solution: &ConeSolution) -> Option<Certificate> {
    let claimed = solution.certificate.as_ref()?;
    certificate(program, &claimed.mechanism).filter(proves)
}

/// Whether a solution converged except for the force of the regularisation in the balance.
fn is_biased(program: &ConeProgram, solution: &ConeSolution) -> bool {
    let sound = solution.forces.len() == program.interactions.len()
        && solution.displacements.len() == program.bodies.len();
    sound && regularised_residuals(program, solution).worst() <= solution.tolerance
}

/// Keeps the residuals of the solution with the smallest error in the increment. Regularised
/// attempts contain a bias, so later attempts may have larger residuals than the first.
fn keep_best(solved: Solved, best: &mut Option<Unconverged>) {
    let residuals = solved.solution.residuals;
    let worst = residuals.worst();
    if best.as_ref().is_none_or(|best| !(best.residuals.worst() <= worst)) {
        *best = Some(Unconverged {
            residuals,
            place: worst_place(solved),
            message: solved.solution.message.clone(),
        });
    }
}

/// Complaint about rigid bodies that lock. The forces prove it: they balance each other and do work
/// on the imposed motions.
fn locked(bodies: &BodyTable, program: &ConeProgram, solution: &ConeSolution) -> String {
    let forces = program.interactions.iter().zip(&solution.forces);
    let strongest = forces.max_by(|a, b| a.1[0].abs().total_cmp(&b.1[0].abs()));
    let place = strongest.map_or(String::new(), |(c, _)| {
        format!("; most strongly at {}", near(bodies, [c.a as usize, c.b as usize]))
    });
    format!("locked: rigid bodies have no feasible motion{place}")
}

/// Maximum displacement and force of a solution, as scales for the next attempt.
fn magnitudes(program: &ConeProgram, solution: &ConeSolution) -> Option<(f64, f64)> {
    if solution.status == SolveStatus::Locked {
        return None;
    }
    let moves = solution.displacements.iter().any(|u| u[0] != 0.0 || u[1] != 0.0);
    let f = solution.forces.iter().map(|f| f[0].abs().max(f[1].abs())).fold(0.0, f64::max);
    // Neither a thrown grain nor an almost fixed body may set the scale.
    let u = displacement_scale(program, &solution.displacements);
    let u = u.min(MAX_MOTION * program.scales.length);
    (moves && u.is_finite() && f.is_finite() && f > 0.0).then_some((u, f))
}

fn complaint(best: &Option<Unconverged>, tolerance: f64) -> String {
    let Some(best) = best else { return "no solution was found".to_owned() };
    let (r, place, message) = (best.residuals, &best.place, &best.message);
    format!(
        "no solution was found; residuals of the best one: balance {:.1e}, kinematics {:.1e}, cone \
         {:.1e}, complementarity {:.1e}{place}; tolerance {:.0e} (the solver: \"{message}\")",
        r.balance, r.kinematics, r.cone, r.complementarity, tolerance
    )
}
