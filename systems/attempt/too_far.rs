//! Judge: does a static solution move bodies further than its constant normals are valid? It may
//! move a barely supported grain by many radii although its residuals are small. The grain lands on
//! others, and later increments lose load without a physical reason. The motion of grains is
//! measured relative to the affine field that fits all grains best. The strain of this field is
//! bounded as well, because it contains the motion that all grains share.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Effort, Verdict};
use clastic_components::contact::Bodies;
use clastic_components::findings::Restraints;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind, Progress};
use clastic_cone::program::{ConeProgram, ConeSolution};

use super::converged::impossible_or;
use super::places::{digits, moves_most, near};
use super::restraints::restrain;
use crate::assemble_program::scales::maximum_imposed;
use crate::mean_field::{mean_strain, thrown};

/// Rejects a static solution that moves a grain by more than [`Acceptance::throw`] radii about the
/// mean field, or that strains a loaded specimen by more than [`Acceptance::snap`] beyond the
/// imposed strain. A throw may show [restraints](super::restraints), which the next attempt then
/// includes. Every such reply adds a restraint, of which a specimen has a finite number.
pub fn judge(
    bodies: Res<Bodies>,
    program: Res<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
    acceptance: Res<Acceptance>,
    analysis: Res<Analysis>,
    progress: Res<Progress>,
    mut restraints: ResMut<Restraints>,
    mut attempt: ResMut<Attempt>,
) {
    if analysis.kind != AnalysisKind::Static {
        return;
    }
    if let Some((grain, far)) = thrown(&bodies, &program, &solution, &acceptance) {
        let all_regularised = attempt.effort() == Some(Effort::Regularised);
        let (acceptance, restraints) = (&acceptance, &mut restraints);
        let is_new =
            restrain(&bodies, &program, &solution, acceptance, restraints, all_regularised);
        attempt.verdict = if is_new {
            Verdict::Again
        } else {
            let reason = Verdict::TooFar(complaint(&bodies, grain, far, acceptance));
            impossible_or(&program, &mut solution, reason)
        };
    } else if attempt.bounded
        && let Some(reason) = snapped(&bodies, &program, &solution, &progress, &acceptance)
    {
        attempt.verdict = Verdict::TooFar(reason);
    }
}

/// Complaint about a throw.
fn complaint(bodies: &Bodies, grain: usize, far: f64, acceptance: &Acceptance) -> String {
    format!(
        "{} would be thrown by {} radii relative to the mean motion; `acceptance.throw` allows {}",
        near(bodies, [grain, grain]),
        digits(far),
        acceptance.throw
    )
}

/// Complaint about a specimen that strains much more than is imposed.
fn snapped(
    bodies: &Bodies,
    program: &ConeProgram,
    solution: &ConeSolution,
    progress: &Progress,
    acceptance: &Acceptance,
) -> Option<String> {
    let strain = mean_strain(bodies, program, solution);
    let imposed = progress.fraction * maximum_imposed(bodies);
    let n = bodies.particles;
    let (low, high) = bodies.positions[..n]
        .iter()
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    // Factor 2: a specimen that is compressed along one axis may extend as much along the other.
    let imposed = 2.0 * imposed / (high - low).min_element().max(bodies.mean_radius);
    (strain > acceptance.snap + imposed).then(|| {
        let most = moves_most(bodies, program, &solution.displacements);
        format!(
            "one solution strains the specimen by {:.1} %{}; `acceptance.snap` allows {:.1} % \
             beyond the imposed strain",
            100.0 * strain,
            most.map_or(String::new(), |(body, far)| format!(" and moves {body} by {far:.1e} m")),
            100.0 * acceptance.snap
        )
    })
}
