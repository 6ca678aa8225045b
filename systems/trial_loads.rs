//! Loads of an embedding program. The [`AddTrialLoads`] schedule collects them once per trial: for
//! every tried fraction of an increment and after every step of a followed motion.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::loads::TrialLoads;

use crate::check_values::refused_load;
use crate::schedule::{AddTrialLoads, ClasticHalted};

/// Adds [`TrialLoads`]. Systems that only add to it may run in any order, because its sums do not
/// depend on the order.
pub struct TrialLoadsPlugin;

impl Plugin for TrialLoadsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<TrialLoads>();
        app.allow_ambiguous_resource::<TrialLoads>();
    }
}

/// Runs [`AddTrialLoads`] on an empty table. A load without a meaning halts the world.
pub fn ask_for_loads(world: &mut World) {
    world.resource_mut::<TrialLoads>().clear();
    world.run_schedule(AddTrialLoads);
    if let Some(message) = refused_load(world.resource(), world.resource()) {
        world.insert_resource(ClasticHalted(message));
    }
}
