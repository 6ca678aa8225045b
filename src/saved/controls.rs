//! Loads and drives of particles and rigid groups in a saved state.

use clastic_components::body::{BodyDrive, BodyDrives, BodyId, LoadControl, Ramp};
use clastic_components::increment::ClasticProgress;
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::WorldState;

use super::SavedError;
use super::columns::{add, each};
use crate::tables::{Array, Tables};

/// Writes the columns of bodies whose names begin with `kind`.
pub(super) fn write(
    state: &WorldState,
    kind: &str,
    ids: &[BodyId],
    tables: &mut Tables,
) -> Result<(), SavedError> {
    let progress: ClasticProgress = state.get(PROGRESS)?;
    let mut put = |column: &str, array: Array| tables.put(&format!("{kind}.{column}"), array);
    let loads = each::<LoadControl>(state, "load_control", ids)?;
    put("load_from", Array::vectors(loads.iter().map(|l| l.0.map(|l| l.0))));
    // A load stays at what it has reached.
    let reached = |(from, to): (f64, f64)| progress.ramp(from, to).from;
    put("load_to", Array::vectors(loads.iter().map(|l| l.0.map(reached))));
    let applied = each::<[Ramp; 3]>(state, "applied_load", ids)?;
    let ends = |of: fn(Ramp) -> f64| Array::vectors(applied.iter().map(move |l| l.map(of)));
    put("applied_from", ends(|load| load.from));
    put("applied_to", ends(|load| load.to));
    let drives = each::<BodyDrives>(state, "drives", ids)?;
    let imposed = |drive: BodyDrive| match drive {
        BodyDrive::Free => None,
        BodyDrive::Imposed(u) => Some(u),
    };
    let flags = drives.iter().map(|d| d.0.map(|drive| imposed(drive).is_some()));
    put("imposed", Array::flags(flags));
    let values = drives.iter().map(|d| d.0.map(|drive| imposed(drive).unwrap_or_default()));
    put("imposed_motion", Array::vectors(values));
    Ok(())
}

/// Reads the columns of bodies whose names begin with `kind`.
pub(super) fn read(
    tables: &Tables,
    kind: &str,
    ids: &[BodyId],
    state: &mut WorldState,
) -> Result<(), SavedError> {
    let n = ids.len();
    let triples = |column: &str| tables.vectors::<3>(&format!("{kind}.{column}"), n);
    let loads = triples("load_from")?.into_iter().zip(triples("load_to")?);
    let loads = loads.map(|(from, to)| Some(LoadControl([0, 1, 2].map(|k| (from[k], to[k])))));
    add(state, "load_control", ids, loads)?;
    let applied = triples("applied_from")?.into_iter().zip(triples("applied_to")?);
    let applied =
        applied.map(|(from, to)| Some([0, 1, 2].map(|k| Ramp { from: from[k], to: to[k] })));
    add(state, "applied_load", ids, applied)?;
    let flags = tables.bool(&format!("{kind}.imposed"), &[n, 3])?.as_chunks::<3>().0;
    let drives = flags.iter().zip(triples("imposed_motion")?).map(|(imposed, value)| {
        Some(BodyDrives([0, 1, 2].map(|k| match imposed[k] {
            true => BodyDrive::Imposed(value[k]),
            false => BodyDrive::Free,
        })))
    });
    Ok(add(state, "drives", ids, drives)?)
}
