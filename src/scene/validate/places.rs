//! Where walls and particles are: no particle is behind a wall, or so far away that numbers are too
//! coarse, and no walls pass through each other.

use std::f64::consts::FRAC_1_SQRT_2;
use std::fmt::Display;

use glam::DVec2;

use crate::scene::format::{Load, Scene, Wall, WallControl};

use super::findings::At;

/// Maximum spacing of floating-point numbers at a disk, in radii.
const COARSEST: f64 = 1e-4;

/// Permitted distance of a centre behind a wall, in radii, for rounding in a generated scene.
const BEHIND: f64 = 1e-6;

/// Maximum deviation of the normals of opposite walls (1 - cos).
const ASKEW: f64 = 1e-9;

/// Spacing of floating-point numbers at a position, m.
fn finest((x, y): (f64, f64)) -> f64 {
    f64::EPSILON * x.abs().max(y.abs())
}

/// Whether the centre of a disk is on the outer side of a wall that is a line: also beyond the ends
/// of its drawn segment. Nothing is behind a wall that is yet to come at the outermost particles.
pub(crate) fn is_behind(wall: &Wall, (x, y): (f64, f64), radius: f64) -> bool {
    if !(wall.is_placed() && wall.shape.is_line()) {
        return false;
    }
    let from = DVec2::new(x, y) - DVec2::from(wall.start);
    along(wall).perp_dot(from) / length(wall) < -BEHIND * radius
}

/// The walls that are there from the start and that a disk is behind.
pub(super) fn walls_before(
    scene: &Scene,
    place: (f64, f64),
    radius: f64,
) -> impl Iterator<Item = &Wall> {
    scene.walls.iter().filter(move |wall| wall.present && is_behind(wall, place, radius))
}

/// From start to end, m.
fn along(wall: &Wall) -> DVec2 {
    DVec2::from(wall.end) - DVec2::from(wall.start)
}

/// Length of the drawn segment, m.
pub(super) fn length(wall: &Wall) -> f64 {
    along(wall).x.hypot(along(wall).y)
}

/// Unit normal on the left of the direction from start to end.
pub(super) fn inward(wall: &Wall) -> DVec2 {
    along(wall).perp() / length(wall)
}

/// Cosine of the angle between the inward normals of two walls.
fn cosine(a: &Wall, b: &Wall) -> f64 {
    inward(a).dot(inward(b))
}

/// Whether two straight walls are parallel, with their insides in the same direction.
pub(super) fn are_alike(a: &Wall, b: &Wall) -> bool {
    cosine(a, b) > 1.0 - ASKEW
}

/// Whether two straight walls are parallel, with their insides in opposite directions.
pub(super) fn are_opposite(a: &Wall, b: &Wall) -> bool {
    cosine(a, b) < ASKEW - 1.0
}

/// Whether two straight walls are nearer to a right angle than to parallel.
pub(super) fn are_askew(a: &Wall, b: &Wall) -> bool {
    cosine(a, b).abs() < FRAC_1_SQRT_2
}

/// Distance from the line of a wall to the start of another along the inward normal, m.
pub(super) fn distance(from: &Wall, to: &Wall) -> f64 {
    (DVec2::from(to.start) - DVec2::from(from.start)).dot(inward(from))
}

/// Checks that floating-point numbers are fine enough at a disk, and that it is not behind a wall. Disks of which
/// some are cut away may be; `cuts` checks the others.
pub(super) fn is_well_placed(
    at: &mut At,
    field: impl Display,
    what: impl Display,
    place: (f64, f64),
    radius: f64,
) -> bool {
    let scene = at.context.scene;
    let mut is_fine = finest(place) <= COARSEST * radius;
    if !is_fine {
        let message = format!("{what} is too far from the origin {place:?}");
        let step = finest(place);
        let help = format!(
            "numbers there are {step:.1e} m apart, too coarse for a radius of {radius:?} m"
        );
        at.add(&field, message, help);
    }
    for wall in walls_before(scene, place, radius).filter(|_| scene.keep.is_none()) {
        is_fine = false;
        let message = format!("{what} is behind wall `{}` {place:?}", wall.name);
        let help = "move it inside; a wall has its inside on the left of start to end";
        at.refuse(at.is_sure_of("walls"), &field, message, help);
    }
    is_fine
}

/// Checks the imposed motions of walls. A displacement applies to every increment. If it is
/// mistaken for that of the stage, the walls meet: two parallel walls that face each other must not
/// do so in a stage without stop conditions. Motions in earlier stages are included. If a wall is
/// absent, or follows a load, a velocity or another system, the distance of its pairs is unknown
/// from then on.
pub(super) fn crossing(at: &mut At) {
    if !at.are_sure_of(&["walls", "stages"]) {
        return;
    }
    let walls = &at.context.scene.walls;
    for (i, a) in walls.iter().enumerate() {
        for b in &walls[i + 1..] {
            if let Some(distance) = facing(a, b).filter(|_| a.present && b.present) {
                pair(at, (a, b), distance);
            }
        }
    }
}

fn pair(at: &mut At, (a, b): (&Wall, &Wall), drawn: f64) {
    let mut distance = drawn;
    for (i, stage) in at.context.scene.stages.iter().enumerate() {
        let Some(stage) = stage.load() else { continue };
        let (Some(of_a), Some(of_b)) = (closing(stage, a), closing(stage, b)) else { return };
        let closing = of_a + of_b;
        let total = closing * f64::from(stage.increments);
        if closing < 0.0 {
            distance -= total;
        }
        let meets = if stage.stop.is_empty() { total } else { closing };
        if meets < distance || closing <= 0.0 {
            continue;
        }
        let (mover, other) = if of_a > 0.0 { (a, b) } else { (b, a) };
        let message = format!(
            "comes to wall `{}`, {distance:?} m away: the two close by {closing:?} m in every one of {} increments",
            other.name, stage.increments
        );
        let help = "give less for an increment; a displacement is not that of the whole stage";
        at.item("stages", i).entry("walls", &mover.name).add("", message, help);
        return;
    }
}

/// Inward displacement of a wall in every increment of a stage, m; `None` if the scene does not
/// determine it.
fn closing(stage: &Load, wall: &Wall) -> Option<f64> {
    if stage.remove_walls.contains(&wall.name) {
        return None;
    }
    match stage.walls.get(&wall.name) {
        None | Some(WallControl::Fixed) => Some(0.0),
        Some(WallControl::Displacement(x, y)) => {
            Some(DVec2::new(*x, *y).dot(inward(wall))).filter(|u| u.is_finite())
        }
        Some(_) => None,
    }
}

/// Distance between two parallel lines that face each other, m; `None` for other pairs: thin walls
/// may pass beside each other, and the place of one that comes at the outermost particles is unknown.
fn facing(a: &Wall, b: &Wall) -> Option<f64> {
    let is_line = |wall: &Wall| wall.shape.is_line() && wall.is_placed() && length(wall) > 0.0;
    let face = is_line(a) && is_line(b) && are_opposite(a, b);
    face.then(|| distance(a, b)).filter(|distance| *distance > 0.0)
}
