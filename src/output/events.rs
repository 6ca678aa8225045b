//! `events.csv`: one row per rupture, by increment and bond.
//!
//! Position, normal (from a to b) and forces are those of the increment in which the bond reached
//! its limit. p is positive in compression.

use clastic_components::bond::Rupture;

use super::csv_file::Row;

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
#[must_use]
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
