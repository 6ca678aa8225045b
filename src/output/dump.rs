//! `program_000123.json`: the cone program of an increment and its solution.

use bevy_ecs::prelude::*;

use clastic_components::observation::Observation;
use clastic_cone::program::{ConeProgram, ConeSolution};
use clastic_reference::dump::to_json;

use super::run_directory::RunDirectory;
use super::{OutputError, directory};
use crate::run::stages::Script;

/// System: writes the program and the solution of the last increment, if the run has asked for it.
pub(super) fn write_if_asked(
    (script, observation): (Res<Script>, Res<Observation>),
    (program, solution): (Res<ConeProgram>, Res<ConeSolution>),
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    let in_stage = script.ends.last().map_or(0, |end| end.rows);
    let Observation { increment, stage, fraction, .. } = &*observation;
    let of_stage = |(name, n): &(String, u64)| name == stage && *n == in_stage;
    if !run.options.dump_programs.contains(increment)
        && !run.options.dump_in_stages.iter().any(of_stage)
    {
        return Ok(());
    }
    let path = directory::program(run.directory(), *increment);
    let text = to_json(*increment, stage, *fraction, &program, &solution);
    let text = text.map_err(OutputError::at(&path))?;
    run.write(path, text)
}
