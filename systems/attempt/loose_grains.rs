//! Judge: is a collapse that of a few loose grains? A grain that has lost its hold falls or rolls
//! down. No equilibrium exists before it lies on others, but the specimen stands.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::Bodies;
use clastic_cone::program::ConeSolution;

use super::restraints::TAKES_PART;

/// Maximum share of the particles in the mechanism of loose grains, unless it is a single one.
/// Above it the specimen itself gives way; no study.
const MAX_SHARE: f64 = 0.2;

/// Tests whether a mechanism moves few particles, and neither a wall, nor a rigid group, nor a
/// particle with a load of its own.
pub fn judge(bodies: Res<Bodies>, solution: Res<ConeSolution>, mut attempt: ResMut<Attempt>) {
    // A motion that has found no rest ends with the proof, whoever moves in it.
    let Some(certificate) = solution.certificate.as_ref().filter(|_| attempt.effort().is_some())
    else {
        return;
    };
    let mechanism = &certificate.mechanism;
    let mut far: Vec<f64> = mechanism.iter().map(|u| u[0].hypot(u[1])).collect();
    // A group may turn about its centre, which then stays.
    for group in &bodies.groups {
        let row = group.body as usize;
        far[row] += mechanism[row][2].abs() * group.extent;
    }
    let maximum = far.iter().copied().fold(0.0, f64::max);
    let moves = |i: &usize| far[*i] > TAKES_PART * maximum;
    let is_loaded =
        |i: usize| bodies.loads[i].iter().any(|load| load.from != 0.0 || load.to != 0.0);
    let is_loose = |i: usize| i < bodies.particles && !is_loaded(i) && bodies.group(i).is_none();
    let moving: Vec<usize> = (0..far.len()).filter(moves).collect();
    // A mechanism without translations is no fall, nor is that of all particles: no particle is left
    // that stands.
    let few = !moving.is_empty()
        && moving.len() < bodies.particles
        && moving.len() as f64 <= (MAX_SHARE * bodies.particles as f64).max(1.0);
    if few && moving.iter().all(|i| is_loose(*i)) {
        attempt.verdict = Verdict::Loose;
    }
}
