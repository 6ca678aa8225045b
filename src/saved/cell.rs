//! The periodic cell of a saved state. A state without one has no such arrays.

use clastic_components::cell::{CellControl, PeriodicCell};
use clastic_components::increment::ClasticProgress;
use clastic_systems::gather_bodies::PERIODIC_CELL;
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::{StateError, WorldState};

use super::SavedError;
use super::columns::{bad, finite, none_of, single};
use crate::tables::{Array, Tables};

pub(super) const ENTRIES: [&str; 1] = [PERIODIC_CELL];

/// The cell of a state, if it has one.
pub(crate) fn of(state: &WorldState) -> Result<Option<PeriodicCell>, StateError> {
    state.bytes(PERIODIC_CELL).map(|_| state.get(PERIODIC_CELL)).transpose()
}

pub(super) fn write(state: &WorldState, tables: &mut Tables) -> Result<(), SavedError> {
    let Some(cell) = of(state)? else { return Ok(()) };
    let progress: ClasticProgress = state.get(PROGRESS)?;
    let size = [cell.width, cell.height, cell.tilt];
    tables.put("cell.size_m", Array::f64(size.to_vec()));
    tables.put("cell.shear", Array::value(cell.shear));
    tables.put("cell.stress_pa", Array::f64(cell.stress.to_vec()));
    tables.put("cell.by_mean", Array::bool(vec![cell.by_mean]));
    // A stress stays at what it has reached; an imposed strain ends with its stage.
    let imposed = cell.controls.map(|control| match control {
        CellControl::Imposed(_) => None,
        CellControl::Stress { from, to } => Some(progress.ramp(from, to).from),
    });
    let flags = imposed.iter().map(Option::is_some).collect();
    tables.put("cell.is_loaded", Array::bool(flags));
    let values = imposed.iter().map(|stress| stress.unwrap_or_default()).collect();
    tables.put("cell.load_pa", Array::f64(values));
    Ok(())
}

/// Reads the cell. `has_walls`: whether the state has walls, which no cell has.
pub(super) fn read(
    tables: &Tables,
    has_walls: bool,
    state: &mut WorldState,
) -> Result<(), SavedError> {
    if !tables.has("cell.size_m") {
        return none_of(tables, "cell.", "cell.size_m");
    }
    if has_walls {
        return Err(bad("cell.size_m", "a periodic cell beside walls"));
    }
    let three = |name: &str| -> Result<[f64; 3], SavedError> {
        let values = tables.f64(name, &[3])?;
        Ok([values[0], values[1], values[2]])
    };
    let [width, height, tilt] = three("cell.size_m")?;
    let stress = three("cell.stress_pa")?;
    let loads = three("cell.load_pa")?;
    finite(tables, &["cell.size_m", "cell.stress_pa", "cell.load_pa", "cell.shear"])?;
    if !(width > 0.0 && height > 0.0) {
        let what = format!("{width:?} by {height:?}, which is no size of a cell");
        return Err(bad("cell.size_m", what));
    }
    let is_loaded = tables.bool("cell.is_loaded", &[3])?;
    let control = |k: usize| match is_loaded[k] {
        true => CellControl::Stress { from: loads[k], to: loads[k] },
        false => CellControl::default(),
    };
    let cell = PeriodicCell {
        width,
        height,
        tilt,
        shear: single(tables, "cell.shear")?,
        stress,
        controls: [control(0), control(1), control(2)],
        by_mean: tables.bool("cell.by_mean", &[1])?[0],
    };
    state.set(PERIODIC_CELL, &cell)?;
    Ok(())
}
