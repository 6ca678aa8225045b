//! Lengths of walls, and particles behind them.

use crate::scene::format::Wall;

/// Permitted distance of a centre behind a wall, in radii, for rounding in a generated scene.
const BEHIND: f64 = 1e-6;

/// Spacing of floating-point numbers at a position, m.
pub(super) fn finest((x, y): (f64, f64)) -> f64 {
    f64::EPSILON * x.abs().max(y.abs())
}

/// Whether the centre of a disk is on the outer side of a wall that is a line: also beyond the ends
/// of its drawn segment. Nothing is behind a wall that is yet to come at the outermost particles.
pub fn is_behind(wall: &Wall, (x, y): (f64, f64), radius: f64) -> bool {
    if !(wall.is_placed() && wall.shape.is_line()) {
        return false;
    }
    let along = (wall.end.0 - wall.start.0, wall.end.1 - wall.start.1);
    let from = (x - wall.start.0, y - wall.start.1);
    let inward = (along.0 * from.1 - along.1 * from.0) / length(wall);
    inward < -BEHIND * radius
}

/// Length of the drawn segment, m.
pub(super) fn length(wall: &Wall) -> f64 {
    (wall.end.0 - wall.start.0).hypot(wall.end.1 - wall.start.1)
}
