//! `events.csv`: one row per rupture, by increment and bond.
//!
//! Position, normal (from a to b) and forces are those of the increment in which the bond reached
//! its limit. p is positive in compression.

use bevy_ecs::prelude::*;

use clastic_components::bond::Rupture;
use clastic_components::observation::Observation;

use super::OutputError;
use super::csv_file::{Column, Field, row};
use super::run_directory::RunDirectory;

/// Columns of a rupture, and of the name of its stage.
pub const COLUMNS: [Column<(Rupture, String)>; 13] = [
    ("increment", |(rupture, _)| rupture.increment.into()),
    ("stage", |(_, stage)| stage.as_str().into()),
    ("bond", |(rupture, _)| Field::Count(rupture.bond.0.into())),
    ("a", |(rupture, _)| Field::Count(rupture.a.0.into())),
    ("b", |(rupture, _)| Field::Count(rupture.b.0.into())),
    ("mode", |(rupture, _)| rupture.mode.name().into()),
    ("x_m", |(rupture, _)| rupture.position.x.into()),
    ("y_m", |(rupture, _)| rupture.position.y.into()),
    ("normal_x", |(rupture, _)| rupture.normal.x.into()),
    ("normal_y", |(rupture, _)| rupture.normal.y.into()),
    ("p_n", |(rupture, _)| rupture.p.into()),
    ("q_n", |(rupture, _)| rupture.q.into()),
    ("tau_nm", |(rupture, _)| rupture.tau.into()),
];

/// System: writes the ruptures of the increment.
pub(super) fn write(
    observation: Res<Observation>,
    mut run: ResMut<RunDirectory>,
) -> Result<(), OutputError> {
    for rupture in &observation.ruptures {
        run.tables.events.push(row(&COLUMNS, &(*rupture, observation.stage.clone())))?;
    }
    Ok(())
}
