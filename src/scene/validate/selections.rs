//! Boxes that select no particle, so that a control of particles would have no effect.
//!
//! Positions are known until a stage moves the particles. The check therefore covers the first
//! loading stage, if only cementing precedes it. For later stages the run makes this check when
//! they begin.

use super::Context;
use super::findings::Findings;
use crate::run::particles::particles;
use crate::scene::format::{Load, Select, Specimen, Stage};

pub(super) fn check(context: &Context, findings: &mut Findings) {
    let scene = context.scene;
    let moves = |stage: &Stage| !matches!(stage, Stage::Cement(_) | Stage::Save(_));
    let unmoved = scene.stages.iter().position(moves);
    let Some((i, Stage::Load(stage))) = unmoved.map(|i| (i, &scene.stages[i])) else { return };
    let is_read = match &scene.specimen {
        Specimen::File { .. } => context.specimen.is_some(),
        Specimen::State { .. } => context.starts_here(),
        _ => true,
    };
    if !is_read || boxes(stage).next().is_none() {
        return;
    }
    // An invalid recipe makes no particles.
    if !findings.is_sound("specimen") || !findings.is_sound(&format!("stages[{i}].particles")) {
        return;
    }
    let centres: Vec<_> = particles(&scene.specimen, context.specimen)
        .iter()
        .map(|particle| (particle.position.x, particle.position.y))
        .collect();
    for (k, min, max) in boxes(stage) {
        let is_inside =
            |(x, y): &(f64, f64)| *x >= min.0 && *y >= min.1 && *x <= max.0 && *y <= max.1;
        if !centres.iter().any(is_inside) {
            let path = format_args!("stages[{i}].particles[{k}].select");
            findings.add(path, "selects no particle: no centre is in the box", &bounds(&centres));
        }
    }
}

/// Boxes with which a stage selects particles: number of the entry, lower left and upper right
/// corner.
fn boxes(stage: &Load) -> impl Iterator<Item = (usize, (f64, f64), (f64, f64))> {
    stage.particles.iter().enumerate().filter_map(|(k, control)| match control.select {
        Select::Box { min, max } => Some((k, min, max)),
        _ => None,
    })
}

/// Range of the centres in words.
fn bounds(centres: &[(f64, f64)]) -> String {
    let Some(first) = centres.first() else { return "the specimen has no particles".to_owned() };
    let (mut low, mut high) = (*first, *first);
    for (x, y) in centres {
        low = (low.0.min(*x), low.1.min(*y));
        high = (high.0.max(*x), high.1.max(*y));
    }
    format!(
        "give a box that holds some: the centres are between ({:.4e}, {:.4e}) and ({:.4e}, {:.4e})",
        low.0, low.1, high.0, high.1
    )
}
