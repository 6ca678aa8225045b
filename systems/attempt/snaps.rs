//! Judge: does the specimen strain much more than is imposed? The bound on the motion of single
//! grains does not cover a motion that all grains share.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::body::Drive;
use clastic_components::contact::Bodies;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind, Progress};
use clastic_cone::program::{ConeProgram, ConeSolution};

use crate::mean_field::mean_strain;

/// Rejects a static solution in which a loaded specimen strains by more than [`Acceptance::snap`]
/// beyond the imposed strain.
pub fn judge(
    bodies: Res<Bodies>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    acceptance: Res<Acceptance>,
    analysis: Res<Analysis>,
    progress: Res<Progress>,
    mut attempt: ResMut<Attempt>,
) {
    if analysis.kind == AnalysisKind::Static
        && attempt.bounded
        && let Some(reason) = snapped(&bodies, &program, &solution, &progress, &acceptance)
    {
        attempt.verdict = Verdict::TooFar(reason);
    }
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
    let imposed = bodies.drives.iter().flat_map(|d| &d[..2]).filter_map(|d| match d {
        Drive::Imposed(u) => Some(u.abs()),
        Drive::Free => None,
    });
    let walls = bodies.walls.iter().map(|w| bodies.wall_travel(w, w.drive));
    let groups = bodies.groups.iter().map(|group| bodies.imposed_motion(group));
    let imposed = imposed.chain(walls).chain(groups);
    let imposed = imposed.chain(bodies.cell.map(|cell| cell.imposed()));
    let imposed = progress.fraction.abs() * imposed.fold(0.0, f64::max);
    let n = bodies.particles;
    let (low, high) = bodies.positions[..n]
        .iter()
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    // Factor 2: a specimen that is compressed along one axis may extend as much along the other.
    let imposed = 2.0 * imposed / (high - low).min_element().max(bodies.mean_radius);
    (strain > acceptance.snap + imposed).then(|| {
        format!(
            "one solution strains the specimen by {:.1} %; `acceptance.snap` allows {:.1} % \
             beyond the imposed strain",
            100.0 * strain,
            100.0 * acceptance.snap
        )
    })
}
