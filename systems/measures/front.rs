//! The front of a flow.

use clastic_components::contact::BodyTable;
use clastic_components::measure::Axis;

/// Coordinate up to which a share of the mass of all particles lies, by their centres, m. Particles
/// without mass count alike. `None` without particles.
pub(super) fn read(bodies: &BodyTable, along: Axis, share: f64) -> Option<f64> {
    let coordinate = |i: usize| match along {
        Axis::X => bodies.positions[i].x,
        Axis::Y => bodies.positions[i].y,
    };
    let has_mass = bodies.masses.iter().any(|mass| *mass > 0.0);
    let mass = |i: usize| if has_mass { bodies.masses[i] } else { 1.0 };
    let mut rows: Vec<usize> = (0..bodies.particles).collect();
    rows.sort_by(|a, b| coordinate(*a).total_cmp(&coordinate(*b)));
    let upto = rows.iter().scan(0.0, |sum, i| {
        *sum += mass(*i);
        Some((coordinate(*i), *sum))
    });
    let upto: Vec<_> = upto.collect();
    let wanted = share * upto.last()?.1;
    upto.iter().find(|(_, sum)| *sum >= wanted).map(|(x, _)| *x)
}
