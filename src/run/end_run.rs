//! Tells the engine that the run of a scene has ended, so that the app stops.

use bevy_ecs::prelude::*;

use clastic_systems::stepping::{EndOfRun, StoppedBy};

use super::script::{Outcome, Script};

/// Writes [`EndOfRun`], once the script has an outcome.
pub(super) fn end_run(script: Res<Script>, mut end: ResMut<EndOfRun>) {
    let Some(outcome) = &script.outcome else { return };
    end.0 = Some(match outcome {
        Outcome::Completed => (StoppedBy::Completed, "all stages of the scene have ended".into()),
        Outcome::Collapsed(collapse) => (
            StoppedBy::Collapsed,
            format!("all stages have ended; `{}` collapsed: {}", collapse.stage, collapse.reason),
        ),
        Outcome::Undecided { message, .. } => (StoppedBy::Undecided, message.clone()),
        Outcome::Halted(message) => (StoppedBy::Halted, message.clone()),
        Outcome::Refused { message, .. } => (StoppedBy::Refused, message.clone()),
    });
}
