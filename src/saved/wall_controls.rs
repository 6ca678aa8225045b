//! Controls and drives of the walls of a saved state.

use clastic_components::body::{BodyId, Ramp};
use clastic_components::increment::ClasticProgress;
use clastic_components::wall::WallDrive;
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::WorldState;
use clastic_systems::wall_states::{ControlState, ControlStates, LengthState, WALL_CONTROL};
use glam::DVec2;

use super::SavedError;
use super::columns::{add, bad, of};
use crate::tables::{Array, Tables};

/// No wall, where the loaded length lies between two.
const NONE: u32 = u32::MAX;

/// Writes controls and drives of these walls.
pub(super) fn write(
    state: &WorldState,
    ids: &[BodyId],
    tables: &mut Tables,
) -> Result<(), SavedError> {
    let progress: ClasticProgress = state.get(PROGRESS)?;
    let controls: ControlStates = state.get(WALL_CONTROL)?;
    let control = |id: &BodyId| {
        let found = controls.0.binary_search_by_key(id, |(id, _)| *id).ok();
        found.map_or(ControlState::Fixed, |k| controls.0[k].1)
    };
    // A load stays at what it has reached.
    let reached = |from: f64, to: f64| [from, progress.ramp(from, to).from];
    let mut rows = Vec::new();
    for control in ids.iter().map(control) {
        rows.push(match control {
            // A wall that turned in its stage stands still until another stage turns it.
            ControlState::Fixed
            | ControlState::Rotation(..)
            | ControlState::Spin(..)
            | ControlState::RotationTable(_) => ("fixed", [0.0; 2], [NONE; 2]),
            ControlState::Displacement(u) => ("displacement", u.to_array(), [NONE; 2]),
            ControlState::Velocity(v) => ("velocity", v.to_array(), [NONE; 2]),
            ControlState::Force(from, to) => ("force", reached(from, to), [NONE; 2]),
            ControlState::Stress(from, to, LengthState::Segment) => {
                ("stress", reached(from, to), [NONE; 2])
            }
            ControlState::Stress(from, to, LengthState::Between(a, b)) => {
                let between = [a, b].map(|wall| wall.map_or(NONE, |id| id.0));
                ("stress_between", reached(from, to), between)
            }
            ControlState::Custom => ("custom", [0.0; 2], [NONE; 2]),
            ControlState::DisplacementTable => ("displacement_table", [0.0; 2], [NONE; 2]),
            ControlState::ForceTable => ("force_table", [0.0; 2], [NONE; 2]),
            ControlState::StressTable(LengthState::Segment) => {
                ("stress_table", [0.0; 2], [NONE; 2])
            }
            ControlState::StressTable(LengthState::Between(a, b)) => {
                let between = [a, b].map(|wall| wall.map_or(NONE, |id| id.0));
                ("stress_table_between", [0.0; 2], between)
            }
        });
    }
    tables.put("walls.control", Array::text(rows.iter().map(|row| row.0.to_owned())));
    tables.put("walls.control_value", Array::vectors(rows.iter().map(|row| row.1)));
    for (k, name) in ["walls.between_a", "walls.between_b"].into_iter().enumerate() {
        tables.put(name, Array::u32(rows.iter().map(|row| row.2[k]).collect()));
    }
    let drives = of::<WallDrive>(state, "wall_drive", ids)?;
    let drives = drives.iter().map(|drive| match drive.unwrap_or_default() {
        WallDrive::Imposed(u) => ((false, f64::NAN), u.to_array()),
        WallDrive::Turning { .. } => ((false, f64::NAN), [0.0; 2]),
        WallDrive::Loaded(ramp) => ((true, f64::NAN), [ramp.from, ramp.to]),
        WallDrive::Sliding { load, along } => ((true, along), [load.from, load.to]),
    });
    let (kinds, values): (Vec<_>, Vec<_>) = drives.unzip();
    let (loaded, along): (Vec<_>, Vec<_>) = kinds.into_iter().unzip();
    tables.put("walls.is_loaded", Array::bool(loaded));
    tables.put("walls.slide_m", Array::f64(along));
    tables.put("walls.drive", Array::vectors(values));
    Ok(())
}

/// Reads the controls and drives of the walls that are there.
pub(super) fn read(
    tables: &Tables,
    all: &[u32],
    present: &[bool],
    state: &mut WorldState,
) -> Result<(), SavedError> {
    let n = all.len();
    let kinds = tables.text("walls.control", &[n])?;
    let values = tables.vectors::<2>("walls.control_value", n)?;
    let between = [tables.u32("walls.between_a", &[n])?, tables.u32("walls.between_b", &[n])?];
    let loaded = tables.bool("walls.is_loaded", &[n])?;
    let slides = tables.f64("walls.slide_m", &[n])?;
    let drives = tables.vectors::<2>("walls.drive", n)?;
    let (mut controls, mut driven, mut ids) = (Vec::new(), Vec::new(), Vec::new());
    for k in (0..n).filter(|k| present[*k]) {
        let [a, b] = values[k];
        let length = between.map(|ids| (ids[k] != NONE).then_some(BodyId(ids[k])));
        let control = match kinds[k].as_str() {
            "fixed" => ControlState::Fixed,
            "displacement" => ControlState::Displacement(DVec2::new(a, b)),
            "velocity" => ControlState::Velocity(DVec2::new(a, b)),
            "force" => ControlState::Force(a, b),
            "stress" => ControlState::Stress(a, b, LengthState::Segment),
            "stress_between" => {
                ControlState::Stress(a, b, LengthState::Between(length[0], length[1]))
            }
            "custom" => ControlState::Custom,
            "displacement_table" => ControlState::DisplacementTable,
            "force_table" => ControlState::ForceTable,
            "stress_table" => ControlState::StressTable(LengthState::Segment),
            "stress_table_between" => {
                ControlState::StressTable(LengthState::Between(length[0], length[1]))
            }
            other => return Err(bad("walls.control", format!("`{other}` in row {k}"))),
        };
        controls.push((BodyId(all[k]), control));
        ids.push(BodyId(all[k]));
        let load = Ramp { from: drives[k][0], to: drives[k][1] };
        driven.push(Some(match loaded[k] {
            true if slides[k].is_finite() => WallDrive::Sliding { load, along: slides[k] },
            true => WallDrive::Loaded(load),
            false => WallDrive::Imposed(drives[k].into()),
        }));
    }
    state.set(WALL_CONTROL, &ControlStates(controls))?;
    add(state, "wall_drive", &ids, driven)?;
    Ok(())
}
