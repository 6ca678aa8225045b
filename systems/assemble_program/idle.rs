//! Idle increments: those in which no load changes and no motion is imposed.
//!
//! The associated law of sliding opens a contact that slides, although it goes on to carry force.
//! The next increment closes the opening, which makes contacts slide and open again. While the
//! specimen is sheared this is what limits the error of the law to one increment. Under constant
//! loads it would be a creep without a cause: idle increments therefore leave contacts as far open as
//! the last increment did, and their gaps are those of their forces, `-C_N p`.

use clastic_components::body::Ramp;
use clastic_components::cell::CellControl;
use clastic_components::contact::Bodies;
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::loads::TrialLoads;
use clastic_components::membrane::Membrane;

use super::scales::maximum_imposed;

/// Whether the increment is idle. Loads that a program of its own adds may change at any time, and
/// after a rupture loads find other ways.
pub fn is_idle(
    bodies: &Bodies,
    analysis: &Analysis,
    progress: &Progress,
    loads: &TrialLoads,
    membranes: &[&Membrane],
) -> bool {
    let is_constant = |ramp: Ramp| ramp.from == ramp.to;
    let of_walls = bodies.walls.iter().filter_map(|wall| bodies.wall_drive(wall).load());
    let of_bodies = bodies.loads.iter().chain(bodies.groups.iter().map(|group| &group.loads));
    let of_cell = |control: &CellControl| match *control {
        CellControl::Stress { from, to } => is_constant(progress.ramp(from, to)),
        CellControl::Imposed(_) => true,
    };
    analysis.kind == AnalysisKind::Static
        && !progress.relaxing
        && progress.gravity == Some(analysis.gravity.into())
        && maximum_imposed(bodies) == 0.0
        && of_walls.chain(of_bodies.flatten().copied()).all(is_constant)
        && bodies.cell.is_none_or(|cell| cell.controls.iter().all(of_cell))
        && membranes.iter().all(|membrane| is_constant(membrane.ramp(progress)))
        && (loads.is_empty() || !membranes.is_empty())
}
