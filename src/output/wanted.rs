//! System: output that is wanted after the increment that has just ended.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use crate::run::stages::Script;
use crate::scene::format::Stage;

/// Output that is wanted after the last increment.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// A row of the history and of the timings.
    pub row: bool,
    pub frame: bool,
}

/// Decides which output is wanted.
pub fn decide(
    (script, progress): (Res<Script>, Res<ClasticProgress>),
    observation: Res<Observation>,
    mut wanted: ResMut<Wanted>,
) {
    let end = script.ends.last();
    let n = end.map_or(0, |end| end.rows);
    let over = progress.is_over() || end.is_some_and(|end| end.ended_by.is_some());
    let record = script.stage(progress.stage).and_then(Stage::record);
    let record = record.cloned().unwrap_or_default();
    // Increments that are not solved are always written.
    let plain = observation.status == IncrementStatus::Solved;
    let every = |count, every: u32| every > 0 && u64::is_multiple_of(count, every.into());
    let regular = match record.frames_every {
        Some(frames_every) => every(n, frames_every),
        None => every(observation.increment, script.scene.output.frames_every),
    };
    *wanted = Wanted {
        // A state within an avalanche is no equilibrium.
        row: !observation.in_avalanche && (over || !plain || every(n, record.every)),
        frame: regular || record.frames.iter().any(|frame| u64::from(*frame) == n),
    };
}
