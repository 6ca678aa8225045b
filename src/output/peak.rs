//! System: picture and frame of the peak so far.

use bevy_ecs::prelude::*;

use clastic_components::observation::Observation;

use super::caption::caption;
use super::frames::{ARE_ARRAYS, FrameMoments};
use super::snapshot::{Moments, Scenery};
use crate::frames::FrameTables;
use crate::run::key_results::KeyResults;

/// Takes the frame of an increment that is the peak so far, and a snapshot of it if pictures are
/// drawn.
pub fn take(
    (observation, results): (Res<Observation>, Res<KeyResults>),
    (scenery, tables): (Scenery, FrameTables),
    mut moments: ResMut<Moments>,
    mut frames: ResMut<FrameMoments>,
) {
    if !results.is_peak(observation.increment) {
        return;
    }
    if ARE_ARRAYS {
        frames.peak = Some(tables.frame());
    }
    if moments.are_drawn {
        moments.peak = Some((scenery.snapshot(), caption(&observation)));
    }
}
