//! Computes the loads of particles over the next increment from their loads over the stage.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::body::{AppliedLoad, BodyId, LoadControl};
use clastic_components::increment::ClasticProgress;

use crate::schedule::{ControlSystems, ControlWalls};
use crate::state::RegisterState;

/// Adds [`control_loads`].
pub struct ControlLoadsPlugin;

impl Plugin for ControlLoadsPlugin {
    fn build(&self, app: &mut App) {
        app.register_component::<BodyId, LoadControl>("load_control");
        app.add_systems(ControlWalls, control_loads.in_set(ControlSystems::BuiltIn));
    }
}

/// Writes [`AppliedLoad`] for the increment that starts at [`ClasticProgress::done`].
pub fn control_loads(
    progress: Res<ClasticProgress>,
    mut particles: Query<(&LoadControl, &mut AppliedLoad)>,
) {
    for (control, mut load) in &mut particles {
        load.set_if_neq(AppliedLoad::next(control, &progress));
    }
}
