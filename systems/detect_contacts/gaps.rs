//! Gap functions: equation 7 of the paper, and the distance to a wall.

use glam::DVec2;

use clastic_components::contact::{Bodies, Contact, WallRow};

/// Normal from a to b and gap `g_0 = |x_b - x_a| - (r_a + r_b)` of two particles; in a cell b is
/// its nearest image.
#[must_use]
pub fn pair_contact(bodies: &Bodies, a: u32, b: u32) -> Contact {
    let (i, j) = (a as usize, b as usize);
    let d = bodies.way(i, j);
    let length = d.length();
    // Coincident centres have no normal; any fixed one pushes them apart.
    let normal = if length > 0.0 { d / length } else { DVec2::X };
    Contact { a, b, normal, gap: length - bodies.radii[i] - bodies.radii[j], bond: None }
}

/// Normal from particle a to the nearest point of the wall and gap, the distance to it less `r_a`.
#[must_use]
pub fn wall_contact(bodies: &Bodies, a: u32, wall: &WallRow) -> Contact {
    let i = a as usize;
    let near = wall.nearest(bodies.positions[wall.body as usize], bodies.positions[i]);
    let gap = near.distance - bodies.radii[i];
    Contact { a, b: wall.body, normal: -near.outward, gap, bond: None }
}

/// Gap between a disk at `place` and a wall at `position`, m; infinite where the disk touches the
/// next segment of a polyline instead.
#[inline]
#[must_use]
pub fn wall_gap(wall: &WallRow, position: DVec2, place: DVec2, radius: f64) -> f64 {
    let near = wall.nearest(position, place);
    if near.is_own { near.distance - radius } else { f64::INFINITY }
}
