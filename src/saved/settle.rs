//! What a later run does not go on with: the place in a stage, and what ends with a stage.

use clastic_components::energy::Changed;
use clastic_components::prelude::*;
use clastic_systems::gather_bodies::PERIODIC_CELL;
use clastic_systems::membranes::{MEMBRANES, MembraneStates};
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::{StateError, WorldState};
use clastic_systems::wall_states::{ControlStates, WALL_CONTROL};
use glam::DVec2;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::find;

/// Ends the stage: loads stay at what they have reached, and imposed motions of walls that turn and
/// of the cell end.
pub(super) fn settle(state: &mut WorldState, at: &ClasticProgress) -> Result<(), StateError> {
    let reached = |from: f64, to: f64| at.ramp(from, to).from;
    change(state, "load_control", |loads: &mut Vec<(BodyId, LoadControl)>| {
        for (_, load) in loads {
            load.0 = load.0.map(|(from, to)| (from, reached(from, to)));
        }
    })?;
    change(state, WALL_CONTROL, |controls: &mut ControlStates| {
        for (_, control, _) in &mut controls.0 {
            match control {
                WallControl::Force { from, to } | WallControl::Stress { from, to, .. } => {
                    *to = reached(*from, *to);
                }
                // A wall that turned in its stage stands still until another stage turns it.
                WallControl::Rotation { .. }
                | WallControl::Spin { .. }
                | WallControl::Table(TableOf::Rotation(_)) => *control = WallControl::Fixed,
                _ => {}
            }
        }
    })?;
    change(state, "wall_drive", |drives: &mut Vec<(BodyId, WallDrive)>| {
        for (_, drive) in drives {
            if let WallDrive::Turning { .. } = drive {
                *drive = WallDrive::Imposed(DVec2::ZERO);
            }
        }
    })?;
    change(state, PERIODIC_CELL, |cell: &mut PeriodicCell| {
        cell.controls = cell.controls.map(|control| match control {
            CellControl::Imposed(_) => CellControl::default(),
            CellControl::Stress { from, to } => {
                let stress = reached(from, to);
                CellControl::Stress { from: stress, to: stress }
            }
        });
    })?;
    change(state, MEMBRANES, |membranes: &mut MembraneStates| {
        for membrane in &mut membranes.0 {
            let pressure = membrane.ramp(at).from;
            membrane.pressure = (pressure, pressure);
        }
    })?;
    change(state, "energy_ledger", |ledger: &mut EnergyLedger| ledger.changed = Changed::Nothing)?;
    let (increment, time) = (at.increment, at.time);
    state.set(PROGRESS, &ClasticProgress { increment, time, ..ClasticProgress::default() })
}

/// Changes an entry of the state, if it has it.
fn change<T: Serialize + DeserializeOwned>(
    state: &mut WorldState,
    entry: &str,
    with: impl FnOnce(&mut T),
) -> Result<(), StateError> {
    let Some(mut value) = find(state, entry)? else { return Ok(()) };
    with(&mut value);
    state.set(entry, &value)
}
