//! Loads that an embedding program adds to a trial: the systems of the [`Loads`] schedule are asked for them
//! once per trial, that is for every part of an increment and for every step of a motion that is followed.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::loads::TrialLoads;

use crate::schedule::Loads;

/// Adds [`TrialLoads`]. Systems that only add to it need no stated order: its sums do not depend on one.
pub struct TrialLoadsPlugin;

impl Plugin for TrialLoadsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<TrialLoads>();
        app.allow_ambiguous_resource::<TrialLoads>();
    }
}

/// Runs [`Loads`] on an empty table.
pub fn ask_for_loads(world: &mut World) {
    world.resource_mut::<TrialLoads>().clear();
    world.run_schedule(Loads);
}
