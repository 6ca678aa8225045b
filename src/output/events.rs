//! `events.csv`: one row per rupture, by increment and bond.
//!
//! Position, normal (from a to b) and forces are those of the increment in which the bond reached
//! its limit. p is positive in compression.

use bevy_ecs::prelude::*;

use clastic_components::bond::Rupture;
use clastic_components::observation::Observation;

use super::OutputError;
use super::csv_file::Row;
use super::run_directory::RunDirectory;

/// Columns.
pub const COLUMNS: [&str; 13] = [
    "increment",
    "stage",
    "bond",
    "a",
    "b",
    "mode",
    "x_m",
    "y_m",
    "normal_x",
    "normal_y",
    "p_n",
    "q_n",
    "tau_nm",
];

/// The row of a rupture.
pub fn row(rupture: &Rupture, stage: &str) -> Row {
    Row::default()
        .count(rupture.increment)
        .text(stage)
        .count(rupture.bond.0)
        .count(rupture.a.0)
        .count(rupture.b.0)
        .text(rupture.mode.name())
        .numbers(rupture.position.to_array())
        .numbers(rupture.normal.to_array())
        .numbers([rupture.p, rupture.q, rupture.tau])
}

/// System: writes the ruptures of the increment.
pub(super) fn write(
    observation: Res<Observation>,
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    for rupture in &observation.ruptures {
        run.tables.events.push(row(rupture, &observation.stage))?;
    }
    Ok(())
}
