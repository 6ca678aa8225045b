//! Judge: is a collapse that of loose grains? A grain that has lost its hold falls or rolls
//! down. No equilibrium exists before it lies on others, but the specimen stands.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::BodyTable;
use clastic_cone::program::ConeSolution;

use super::restraints::{takes_part, translations};

/// Tests whether a mechanism moves a minority of the particles, and neither a wall, nor a rigid
/// group, nor a particle with a load of its own. Where most particles move, the specimen itself
/// gives way, and its motion would be followed in vain.
pub fn judge(bodies: Res<BodyTable>, solution: Res<ConeSolution>, mut attempt: ResMut<Attempt>) {
    // A motion that has found no rest ends with the proof, whatever bodies move in the mechanism.
    let Some(certificate) = solution.certificate.as_ref().filter(|_| attempt.effort().is_some())
    else {
        return;
    };
    let mut far = translations(certificate);
    // A group may turn about its centre, so that its position does not change.
    for group in &bodies.groups {
        let row = group.body as usize;
        far[row] += certificate.mechanism[row][2].abs() * group.extent;
    }
    let moves = takes_part(&far);
    let is_loaded =
        |i: usize| bodies.loads[i].iter().any(|load| load.from != 0.0 || load.to != 0.0);
    let is_loose = |i: usize| i < bodies.particles && !is_loaded(i) && bodies.group(i).is_none();
    let moving: Vec<usize> = (0..far.len()).filter(|i| moves(*i)).collect();
    // Without translations no grain falls.
    let few = !moving.is_empty() && 2 * moving.len() <= bodies.particles;
    if few && moving.iter().all(|i| is_loose(*i)) {
        attempt.verdict = Verdict::Loose;
    }
}
