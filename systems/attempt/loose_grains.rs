//! Judge: is a collapse that of loose grains? A grain that has lost its hold falls or rolls
//! down. No equilibrium exists before it lies on others, but the specimen stands.

use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, Verdict};
use clastic_components::contact::BodyTable;
use clastic_components::contact_history::DraftHistory;
use clastic_components::increment::Acceptance;
use clastic_cone::program::ConeSolution;

use super::motion::may_begin;
use super::set_aside::carry_themselves;
use crate::mechanism::{takes_part, translations};
use crate::motion_settings::MotionSettings;

/// Calls a mechanism of loose grains one, whose motion is followed. Where no further motion may
/// begin, those that carry nothing but themselves are set aside where they are.
pub fn judge(
    mut bodies: ResMut<BodyTable>,
    solution: Res<ConeSolution>,
    draft: Res<DraftHistory>,
    acceptance: Res<Acceptance>,
    settings: Res<MotionSettings>,
    mut attempt: ResMut<Attempt>,
) {
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
    let Some(grains) = loose(&bodies, &far) else { return };
    attempt.verdict = Verdict::Loose;
    if !may_begin(&attempt, &acceptance, &settings) {
        let grains = carry_themselves(&bodies, &grains, draft.0.sizes()).unwrap_or_default();
        if grains.iter().any(|i| !bodies.set_aside[*i]) {
            grains.iter().for_each(|i| bodies.set_aside[*i] = true);
            attempt.verdict = Verdict::Again;
        }
    }
}

/// The particles among the bodies that move this `far`, if they are a minority of the particles, and
/// neither a wall, nor a rigid group, nor a particle with a load of its own moves. Where most
/// particles move, the specimen itself gives way, and its motion would be followed in vain.
pub(super) fn loose(bodies: &BodyTable, far: &[f64]) -> Option<Vec<usize>> {
    let moves = takes_part(far);
    let is_loose =
        |i: usize| i < bodies.particles && !bodies.has_load(i) && bodies.group(i).is_none();
    let moving: Vec<usize> = (0..far.len()).filter(|i| moves(*i)).collect();
    // Without translations no grain falls.
    let few = !moving.is_empty() && 2 * moving.len() <= bodies.particles;
    (few && moving.iter().all(|i| is_loose(*i))).then_some(moving)
}
