//! Gap functions: equation 7 of the paper, and the distance to a wall.

use glam::DVec2;

use clastic_components::contact::{BodyTable, Contact, WallRow};
use clastic_components::wall_shape::Nearest;

/// Normal from a to b and gap `g_0 = |x_b - x_a| - (r_a + r_b)` of two particles; in a cell b is
/// its nearest image.
pub fn pair_contact(bodies: &BodyTable, a: u32, b: u32) -> Contact {
    let (i, j) = (a as usize, b as usize);
    let d = bodies.way(i, j);
    let length = d.length();
    // Coincident centres have no normal; any fixed one pushes them apart.
    let normal = if length > 0.0 { d / length } else { DVec2::X };
    Contact { a, b, normal, gap: length - bodies.radii[i] - bodies.radii[j], bond: None }
}

/// Normal from particle a to the nearest point of the wall and gap, the distance to it less `r_a`.
pub fn wall_contact(bodies: &BodyTable, a: u32, wall: &WallRow) -> Contact {
    let i = a as usize;
    let near = wall.nearest(bodies.positions[wall.body as usize], bodies.positions[i]);
    let gap = near.distance - bodies.radii[i];
    Contact { a, b: wall.body, normal: -near.outward, gap, bond: None }
}

/// Points of two walls that are closer than this, in radii of the disk, are one.
///
/// 1e-6: far above the round-off of places, and an edge of this height lifts no disk.
pub(crate) const JOINT: f64 = 1e-6;

/// Gap between a disk at `place` and a wall, m; infinite where another wall has the contact. All
/// walls and the places of all bodies are those of one moment.
#[inline]
pub fn wall_gap(
    walls: &[WallRow],
    positions: &[DVec2],
    wall: &WallRow,
    place: DVec2,
    radius: f64,
) -> f64 {
    let near = wall.nearest(positions[wall.body as usize], place);
    let gap = near.distance - radius;
    // Far from the disk the question does not arise.
    let is_near = !wall.is_line() && gap < radius;
    if is_near && is_of_another(walls, positions, wall, &near, place, radius) {
        return f64::INFINITY;
    }
    gap
}

/// Whether a contact belongs to another wall, since a second one would halve the force of each.
/// Where the end of a thin wall lies on another wall, the nearer of the two has the contact. If
/// both have the same point, a line has it, and of two thin walls the one with the lower number.
fn is_of_another(
    walls: &[WallRow],
    positions: &[DVec2],
    wall: &WallRow,
    near: &Nearest,
    place: DVec2,
    radius: f64,
) -> bool {
    let point = place - near.distance * near.outward;
    walls.iter().filter(|other| other.body != wall.body).any(|other| {
        let of_other = |place| other.nearest(positions[other.body as usize], place);
        let its = of_other(place);
        if point.distance(place - its.distance * its.outward) <= JOINT * radius {
            return other.is_line() || other.body < wall.body;
        }
        its.distance < near.distance && of_other(point).distance.abs() <= JOINT * radius
    })
}
