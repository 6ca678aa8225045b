//! `OutputPlugin`: follows every increment, and writes it into the run directory.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_systems::state::RegisterState;
use clastic_systems::stepping::{AdvanceIncrement, AdvanceSystems, ClasticHalted};

use super::avalanches::{self, CurrentAvalanche};
use super::found::Found;
use super::prepared::{self, PreparedSpecimen};
use super::run_directory::RunDirectory;
use super::save::{is_checkpoint_due, is_last_increment, keep_last, save};
use super::wanted::{self, Wanted};
use super::{OutputError, dump, events, found, frames, history, mechanism, states, timings};
use crate::run::key_results::is_undecided;
use crate::run::plugin::{BeginStage, EndStage, StageSystems};
use crate::run::save::SavedStates;

/// Writes the results of every increment. Its systems run after the stop conditions, so that the
/// last row of a stopped stage is written too. [`begin`](super::begin) and
/// [`resume`](super::resume) open the run directory, [`RunDirectory`]; nothing is written without
/// it. This plugin does not change the results of a run.
///
/// An increment that cannot be written halts the run: [`ClasticHalted`] has the message, and
/// [`OutputFailure`] the error.
pub struct OutputPlugin;

/// Why the run could not be written.
#[derive(Resource, Debug)]
pub struct OutputFailure(pub OutputError);

impl Plugin for OutputPlugin {
    fn build(&self, app: &mut App) {
        let take_start = prepared::take_start.run_if(resource_exists::<RunDirectory>);
        let write_packing = prepared::write_packing.pipe(halt).run_if(can_write);
        app.register_resource::<PreparedSpecimen>("output.specimen")
            .register_resource::<CurrentAvalanche>("output.avalanche")
            .register_resource::<Found>("output.results")
            .init_resource::<Wanted>()
            .add_systems(BeginStage, take_start.before(StageSystems::BuiltIn))
            .add_systems(EndStage, write_packing.after(StageSystems::Custom))
            .add_systems(
                AdvanceIncrement,
                (
                    (timings::start_clock, wanted::decide).chain(),
                    history::is_there.pipe(halt),
                    states::write_kept.pipe(halt).run_if(resource_exists::<SavedStates>),
                    // A resumed run with other settings repeats the increment. Its checkpoint
                    // therefore comes before anything of it is written.
                    save.pipe(halt).run_if(is_undecided),
                    events::write.pipe(halt),
                    avalanches::write_ended.pipe(halt),
                    history::write_wanted.pipe(halt),
                    prepared::prepare.pipe(halt),
                    (frames::take_peak, found::see_forces),
                    mechanism::write_first.pipe(halt),
                    frames::write_wanted.pipe(halt),
                    dump::write_if_asked.pipe(halt),
                    timings::write_wanted.pipe(halt),
                    save.pipe(halt).run_if(is_checkpoint_due).run_if(not(is_undecided)),
                    keep_last.pipe(halt).run_if(is_last_increment).run_if(not(is_undecided)),
                )
                    .chain()
                    .distributive_run_if(can_write)
                    .in_set(AdvanceSystems::Output),
            );
    }
}

/// Run condition: a run directory is open, and nothing has failed.
fn can_write(run: Option<Res<RunDirectory>>, failure: Option<Res<OutputFailure>>) -> bool {
    run.is_some() && failure.is_none()
}

/// Halts the run after an error.
fn halt(In(written): In<Result<(), OutputError>>, mut commands: Commands) {
    if let Err(error) = written {
        commands.insert_resource(ClasticHalted(error.to_string()));
        commands.insert_resource(OutputFailure(error));
    }
}
