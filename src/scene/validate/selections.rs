//! Boxes that select no particle, so that a control of particles would have no effect.
//!
//! Positions are known until a stage moves the particles. The check therefore covers the first
//! loading stage, if only cementing precedes it. For later stages the run makes this check when
//! they begin.

use super::Context;
use super::findings::Findings;
use crate::run::particles::particles;
use crate::scene::format::{Load, Select, Specimen, Stage};
use crate::scene::spans::join;

pub(super) fn check(context: &Context, findings: &mut Findings) {
    let scene = context.scene;
    let unmoved = scene.stages.iter().position(|stage| !matches!(stage, Stage::Cement(_)));
    let Some((i, Stage::Load(stage))) = unmoved.map(|i| (i, &scene.stages[i])) else { return };
    let is_read = context.specimen.is_some() || !matches!(scene.specimen, Specimen::File { .. });
    if !is_read || boxes(stage).next().is_none() {
        return;
    }
    // An invalid recipe makes no particles.
    let fields = ["particles", "rigid"].map(|field| format!("stages[{i}].{field}"));
    if !findings.is_sound("specimen") || !fields.iter().all(|field| findings.is_sound(field)) {
        return;
    }
    let centres: Vec<_> = particles(&scene.specimen, context.specimen)
        .iter()
        .map(|particle| (particle.position.x, particle.position.y))
        .collect();
    for (entry, min, max) in boxes(stage) {
        let is_inside =
            |(x, y): &(f64, f64)| *x >= min.0 && *y >= min.1 && *x <= max.0 && *y <= max.1;
        if !centres.iter().any(is_inside) {
            let path = format_args!("stages[{i}].{entry}.select");
            findings.add(path, "selects no particle: no centre is in the box", &bounds(&centres));
        }
    }
}

/// Boxes with which a stage selects particles: the entry, lower left and upper right corner.
fn boxes(stage: &Load) -> impl Iterator<Item = (String, (f64, f64), (f64, f64))> {
    let controls = stage.particles.iter().enumerate();
    let controls = controls.map(|(k, control)| (format!("particles[{k}]"), Some(&control.select)));
    let groups = stage.rigid.iter();
    let groups = groups.map(|(name, control)| (join("rigid", name), control.select.as_ref()));
    controls.chain(groups).filter_map(|(entry, select)| match select {
        Some(Select::Box { min, max }) => Some((entry, *min, *max)),
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
