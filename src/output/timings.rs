//! `timings.csv`: wall-clock seconds for the parts of every increment.

use std::time::Instant;

use bevy_ecs::prelude::*;

use clastic_components::observation::{Observation, Timings};

use super::OutputError;
use super::csv_file::Row;
use super::run_directory::RunDirectory;
use super::wanted::Wanted;

/// Columns, of which the last is the time for the other files of the increment and for a checkpoint
/// since the previous row.
pub const COLUMNS: [&str; 9] = [
    "increment",
    "detect_s",
    "assemble_s",
    "solve_s",
    "update_s",
    "rupture_s",
    "walls_s",
    "record_s",
    "output_s",
];

/// System: starts the clock of the output.
pub(super) fn start_clock(mut run: ResMut<RunDirectory>) {
    run.clock = Instant::now();
}

/// System: writes the timings of the increment, if wanted.
pub(super) fn write_wanted(
    wanted: Res<Wanted>,
    (observation, t): (Res<Observation>, Res<Timings>),
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    if !wanted.row {
        return Ok(());
    }
    let output = run.clock.elapsed().as_secs_f64() + std::mem::take(&mut run.saving);
    let parts = [t.detect, t.assemble, t.solve, t.update, t.rupture, t.walls, t.record, output];
    run.tables.timings.push(Row::default().with(observation.increment).and(parts))
}
