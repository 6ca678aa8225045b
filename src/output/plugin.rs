//! `OutputPlugin`: writes every increment into the run directory.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_systems::stepping::{Advance, AdvanceSystems, Halted};

use super::OutputError;
use super::run_directory::RunWriter;

/// Writes the results of every increment. It runs after the stop conditions, so that the last row
/// of a stopped stage is written too. The run directory is the resource [`RunWriter`]; nothing is
/// written without it. This plugin does not change the results of a run.
///
/// An increment that cannot be written halts the run: [`Halted`] has the message, and
/// [`OutputFailure`] the error.
pub struct OutputPlugin;

/// Why the run could not be written.
#[derive(Resource, Debug)]
pub struct OutputFailure(pub OutputError);

impl Plugin for OutputPlugin {
    fn build(&self, app: &mut App) {
        let write = write_increment.in_set(AdvanceSystems::Output);
        app.add_systems(Advance, write.run_if(resource_exists::<RunWriter>));
    }
}

/// Exclusive, because a checkpoint reads everything that plugins have registered.
fn write_increment(world: &mut World) {
    let written = world.resource_scope(|world, mut writer: Mut<RunWriter>| writer.record(world));
    if let Err(error) = written {
        world.insert_resource(Halted(error.to_string()));
        world.insert_resource(OutputFailure(error));
    }
}
