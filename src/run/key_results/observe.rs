//! Systems: the key results follow every increment, and measures read them.

use bevy_ecs::prelude::*;

use clastic_components::attempt::IncrementStatus;
use clastic_components::increment::Progress;
use clastic_components::measure::{NamedMeasures, Quantity, Readings};
use clastic_components::observation::Observation;
use clastic_systems::identities::Identities;

use super::collected::{KeyResults, Phase};
use crate::run::script::Script;
use crate::scene::format::Stage;

/// Run condition: the increment is undecided.
pub fn is_undecided(observation: Res<Observation>) -> bool {
    observation.status == IncrementStatus::Undecided
}

/// Records the increment in the key results.
pub fn observe_increment(
    (script, progress): (Res<Script>, Res<Progress>),
    observation: Res<Observation>,
    identities: Res<Identities>,
    mut results: ResMut<KeyResults>,
) {
    let is_compaction = matches!(script.stage(progress.stage), Some(Stage::Compact(_)));
    let phase = match (is_compaction, progress.stage >= script.reference_stage()) {
        (true, _) => Phase::Preparation,
        (false, false) => Phase::Loading,
        (false, true) => Phase::Reference,
    };
    results.see_bonds(identities.next().bond as usize);
    results.observe(&observation, phase);
}

/// Reads the measures that are key results.
pub fn read_key_results(
    named: Res<NamedMeasures>,
    results: Res<KeyResults>,
    mut out: ResMut<Readings>,
) {
    for (k, (_, quantity)) in named.list.iter().enumerate() {
        if let (Some(Quantity::KeyResult(key)), Some(out)) = (quantity, out.0.get_mut(k)) {
            *out = results.result(*key);
        }
    }
}
