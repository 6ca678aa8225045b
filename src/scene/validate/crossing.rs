//! Walls that pass through each other. A displacement applies to every increment. If it is mistaken
//! for that of the stage, the walls meet.

use super::findings::At;
use super::places::{are_opposite, distance, inward, length};
use crate::scene::format::{Load, Wall, WallControl};

/// Checks the imposed motions of walls: two parallel walls that face each other must not meet in a
/// stage without stop conditions. Motions in earlier stages are included. If a wall is absent, or
/// follows a load, a velocity or another system, the distance of its pairs is unknown from then on.
pub(super) fn check(at: &mut At) {
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
            "comes to wall `{}`, {distance:?} m away: the two close by {closing:?} m in every one of {} \
             increments",
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
            let (nx, ny) = inward(wall);
            Some(x * nx + y * ny).filter(|u| u.is_finite())
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
