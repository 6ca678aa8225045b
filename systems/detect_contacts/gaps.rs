//! Gap functions: equation 7 of the paper, and the distance to a wall's line.

use glam::DVec2;

use clastic_components::contact::{Bodies, Contact, WallRow};

/// Normal from a to b and gap `g_0 = |x_b - x_a| - (r_a + r_b)` of two particles.
#[must_use]
pub fn pair_contact(bodies: &Bodies, a: u32, b: u32) -> Contact {
    let (i, j) = (a as usize, b as usize);
    let d = bodies.positions[j] - bodies.positions[i];
    let length = d.length();
    // Coincident centres have no normal; any fixed one pushes them apart.
    let normal = if length > 0.0 { d / length } else { DVec2::X };
    Contact { a, b, normal, gap: length - bodies.radii[i] - bodies.radii[j], bond: None }
}

/// Normal from particle a to the wall and gap, the distance to the wall's line less `r_a`.
#[must_use]
pub fn wall_contact(bodies: &Bodies, a: u32, wall: &WallRow) -> Contact {
    let i = a as usize;
    let distance = (bodies.positions[i] - bodies.positions[wall.body as usize]).dot(wall.inward);
    Contact { a, b: wall.body, normal: -wall.inward, gap: distance - bodies.radii[i], bond: None }
}
