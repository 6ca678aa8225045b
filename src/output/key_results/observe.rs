//! System: the key results follow every increment, and picture and frame of the peak with them.

use bevy_ecs::prelude::*;

use clastic_components::identity::Identities;
use clastic_components::increment::Progress;
use clastic_components::observation::Observation;

use super::{KeyResults, Phase};
use crate::frames::FrameTables;
use crate::output::caption::caption;
use crate::output::frames::{ARE_ARRAYS, FrameMoments};
use crate::output::snapshot::{Moments, Scenery};
use crate::run::stages::Script;
use crate::scene::format::Stage;

/// Records the increment in the key results, and takes the frame of the peak so far, and a
/// snapshot of it if pictures are drawn.
pub fn observe_increment(
    (script, progress): (Res<Script>, Res<Progress>),
    observation: Res<Observation>,
    identities: Res<Identities>,
    (scenery, tables): (Scenery, FrameTables),
    mut results: ResMut<KeyResults>,
    mut moments: ResMut<Moments>,
    mut frames: ResMut<FrameMoments>,
) {
    let is_compaction = matches!(script.stage(progress.stage), Some(Stage::Compact(_)));
    let phase = match (is_compaction, progress.stage >= script.reference_stage()) {
        (true, _) => Phase::Preparation,
        (false, false) => Phase::Loading,
        (false, true) => Phase::Reference,
    };
    results.see_bonds(identities.next().bond as usize);
    let is_peak = results.observe(&observation, phase);
    if is_peak && ARE_ARRAYS {
        frames.peak = Some(tables.frame());
    }
    if is_peak && moments.are_drawn {
        moments.peak = Some((scenery.snapshot(), caption(&observation)));
    }
}
