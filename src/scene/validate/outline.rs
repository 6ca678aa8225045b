//! Where particles are: not behind a wall, and not so far away that numbers are too coarse.

use std::fmt::Arguments;

use crate::scene::format::Wall;

use super::findings::Findings;
use super::places::{finest, is_behind};

/// Maximum spacing of floating-point numbers at a disk, in radii.
pub(super) const COARSEST: f64 = 1e-4;

/// Checks the corners of a specimen that a recipe makes.
pub(super) fn outline(
    low: (f64, f64),
    high: (f64, f64),
    (bottom, top): (f64, f64),
    radius: f64,
    findings: &mut Findings,
) {
    // Particles that are cut away may lie behind a wall; `cuts` checks the others.
    let is_cut = findings.context.scene.keep.is_some();
    if is_cut || !findings.are_sure_of(&["specimen", "walls"]) {
        return;
    }
    let corners = [(low.0, bottom), (low.1, bottom), (high.0, top), (high.1, top)];
    let far = corners.iter().copied().max_by(|a, b| finest(*a).total_cmp(&finest(*b)));
    if let Some(far) = far {
        not_too_far(format_args!("specimen"), "a corner of it", far, radius, findings);
    }
    let outside =
        |wall: &Wall| wall.present && corners.iter().any(|corner| is_behind(wall, *corner, radius));
    if let Some(wall) = findings.context.scene.walls.iter().find(|wall| outside(wall)) {
        let message = format!("the specimen reaches behind wall `{}`", wall.name);
        let help = "move its origin or the wall; a wall has its inside on the left of start to end";
        findings.add(format_args!("specimen"), message, help);
    }
}

/// Checks that floating-point numbers are fine enough at a disk.
pub(super) fn not_too_far(
    path: Arguments,
    what: &str,
    place: (f64, f64),
    radius: f64,
    findings: &mut Findings,
) {
    let step = finest(place);
    if step > COARSEST * radius {
        let message = format!("{what} is too far from the origin {place:?}");
        let help = format!(
            "numbers there are {step:.1e} m apart, too coarse for a radius of {radius:?} m"
        );
        findings.add(path, message, &help);
    }
}

/// Checks that a disk is not behind a wall.
pub(super) fn not_behind(
    path: Arguments,
    what: &str,
    place: (f64, f64),
    radius: f64,
    findings: &mut Findings,
) {
    if !findings.is_sure_of("walls") || findings.context.scene.keep.is_some() {
        return;
    }
    let present = findings.context.scene.walls.iter().filter(|wall| wall.present);
    for wall in present.filter(|wall| is_behind(wall, place, radius)) {
        let message = format!("{what} is behind wall `{}` {place:?}", wall.name);
        let help = "move it inside; a wall has its inside on the left of start to end";
        findings.add(path, message, help);
    }
}
