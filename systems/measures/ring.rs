//! The particles around a hole: how far they have moved in, and what supports them.

use std::f64::consts::TAU;

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

/// Identity, place and external force of a particle.
pub(super) type ParticleForce =
    (&'static BodyId, &'static BodyPosition, &'static BodyExternalForce);

/// Reads a value of the particles whose centres were between two circles at the start of the reference
/// stage, at the places `start`. Directions are those from the centre to these places. `None` without
/// particles.
pub(super) fn read(
    particles: &Query<ParticleForce, With<Particle>>,
    start: &[(BodyId, DVec2)],
    (centre, (inner, outer), thickness): (DVec2, (f64, f64), f64),
    value: RingValue,
) -> Option<f64> {
    let in_ring = particles.iter().filter_map(|(id, x, force)| {
        let place = start[start.binary_search_by_key(id, |(id, _)| *id).ok()?].1;
        let (from, out) = (place.distance(centre), (place - centre).normalize_or_zero());
        let force = DVec2::new(force.0[0], force.0[1]);
        let terms = (*id, (place - x.0).dot(out), force.dot(out));
        (inner..=outer).contains(&from).then_some(terms)
    });
    let mut terms: Vec<_> = in_ring.collect();
    // The order of a query may vary, and with it the round-off of a sum.
    terms.sort_unstable_by_key(|(id, ..)| *id);
    let area = TAU * inner * thickness;
    (!terms.is_empty()).then(|| match value {
        RingValue::Closure => terms.iter().map(|term| term.1).sum::<f64>() / terms.len() as f64,
        RingValue::Support => terms.iter().map(|term| term.2).sum::<f64>() / area,
    })
}
