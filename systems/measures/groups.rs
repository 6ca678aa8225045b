//! Force and moment on a group of particles: the sum over the contacts and bonds that cross its
//! boundary.

use glam::DVec2;

use clastic_components::body::BodyId;

use crate::solved::Solved;

/// Force (x, y; N) of the contacts with other bodies on the particles, and its moment about their
/// centre of mass (N m), anticlockwise. Points and centre are those at the start of the increment,
/// which [`BodyTable`](clastic_components::contact::BodyTable) holds until it is gathered anew. `None` without any of the particles.
pub fn force_on(members: &[BodyId], solved: Solved) -> Option<[f64; 3]> {
    let bodies = solved.bodies;
    let rows = members.iter().filter_map(|id| bodies.row(*id));
    let mut is_inside = vec![false; bodies.ids.len()];
    let (mut mass, mut middle, mut plain) = (0.0, DVec2::ZERO, DVec2::ZERO);
    for row in rows.filter(|row| *row < bodies.particles) {
        is_inside[row] = true;
        mass += bodies.masses[row];
        middle += bodies.masses[row] * bodies.positions[row];
        plain += bodies.positions[row];
    }
    let count = is_inside.iter().filter(|inside| **inside).count();
    if count == 0 {
        return None;
    }
    // Particles without mass count alike.
    let centre = if mass > 0.0 { middle / mass } else { plain / count as f64 };
    let mut sum = [0.0; 3];
    for (contact, c, f) in solved.contacts() {
        let (a, b) = (is_inside[contact.a as usize], is_inside[contact.b as usize]);
        if a == b {
            continue;
        }
        // The first body is pushed against the normal.
        let sign = if a { -1.0 } else { 1.0 };
        let force = sign * c.force(f);
        sum[0] += force.x;
        sum[1] += force.y;
        sum[2] += (contact.point(bodies) - centre).perp_dot(force) + sign * f[2];
    }
    Some(sum)
}
