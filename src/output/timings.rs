//! `timings.csv`: wall-clock seconds for the parts of every increment.

use clastic_components::observation::Timings;

use super::csv_file::Row;

/// Columns.
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

/// Row of an increment. `output` is the time for its other files and for a checkpoint since the
/// previous row.
#[must_use]
pub fn row(increment: u64, t: &Timings, output: f64) -> Row {
    let parts = [t.detect, t.assemble, t.solve, t.update, t.rupture, t.walls, t.record];
    Row::default().count(increment).numbers(parts).number(output)
}
