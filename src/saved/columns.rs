//! Components by identity as columns of tables, and back.

use serde::Serialize;
use serde::de::DeserializeOwned;

use clastic_components::body::{BodyExternalForce, BodyId, LastMotion};
use clastic_systems::state::{StateError, WorldState};

use super::SavedError;
use crate::tables::{TableError, Tables};

/// Components of one type of these bodies, in their order.
pub(super) fn of<T: DeserializeOwned + Clone>(
    state: &WorldState,
    entry: &str,
    ids: &[BodyId],
) -> Result<Vec<Option<T>>, StateError> {
    let all = state.components::<BodyId, T>(entry)?;
    let find = |id: &BodyId| {
        let at = all.binary_search_by_key(id, |(known, _)| *known).ok()?;
        Some(all[at].1.clone())
    };
    Ok(ids.iter().map(find).collect())
}

/// Components that every one of these bodies has, in their order.
pub(super) fn each<T: DeserializeOwned + Clone + Default>(
    state: &WorldState,
    entry: &str,
    ids: &[BodyId],
) -> Result<Vec<T>, StateError> {
    let all = of::<T>(state, entry, ids)?;
    Ok(all.into_iter().map(Option::unwrap_or_default).collect())
}

/// Adds components of one type to those that are in the state.
pub(super) fn add<T: Serialize + DeserializeOwned>(
    state: &mut WorldState,
    entry: &str,
    ids: &[BodyId],
    values: impl IntoIterator<Item = Option<T>>,
) -> Result<(), StateError> {
    let mut all = state.components::<BodyId, T>(entry)?;
    let values = ids.iter().zip(values);
    all.extend(values.filter_map(|(id, value)| Some((*id, value?))));
    all.sort_by_key(|(id, _)| *id);
    if all.is_empty() { Ok(()) } else { state.set(entry, &all) }
}

/// Adds the last motions of bodies and the external forces on them.
pub(super) fn add_motions(
    state: &mut WorldState,
    ids: &[BodyId],
    motions: Vec<[f64; 3]>,
    forces: Vec<[f64; 3]>,
) -> Result<(), StateError> {
    add(state, "last_motion", ids, motions.into_iter().map(|u| Some(LastMotion(u))))?;
    let forces = forces.into_iter().map(|f| Some(BodyExternalForce::of_state(f)));
    add(state, "external_force", ids, forces)
}

/// Error of an array.
pub(super) fn bad(name: &str, what: impl Into<String>) -> SavedError {
    TableError::at(name, what).into()
}

/// A single number.
pub(super) fn single(tables: &Tables, name: &str) -> Result<f64, SavedError> {
    Ok(tables.f64(name, &[])?[0])
}

/// A single count.
pub(super) fn count(tables: &Tables, name: &str) -> Result<u64, SavedError> {
    Ok(tables.u64(name, &[])?[0])
}

/// Checks that the numbers of an array are finite.
pub(super) fn finite(tables: &Tables, names: &[&str]) -> Result<(), SavedError> {
    for name in names {
        let shape = &tables.get(name)?.shape;
        if let Some(row) = tables.f64(name, shape)?.iter().position(|x| !x.is_finite()) {
            let width = shape.get(1).copied().unwrap_or(1).max(1);
            return Err(bad(name, format!("a number that is not finite in row {}", row / width)));
        }
    }
    Ok(())
}

/// Identities of a table, ascending.
pub(super) fn identities(tables: &Tables, name: &str) -> Result<Vec<u32>, SavedError> {
    let ids = tables.u32(name, &[tables.rows(name)?])?;
    match ids.windows(2).position(|pair| pair[0] >= pair[1]) {
        Some(row) => Err(bad(name, format!("identities do not ascend in row {}", row + 1))),
        None => Ok(ids.to_vec()),
    }
}

/// A text, or none if it is empty.
pub(super) fn some(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.to_owned())
}

/// Checks that a state without the array `key` has no other array of its kind. Otherwise the state
/// is damaged, and the content of the other arrays would be lost without a message.
pub(super) fn none_of(tables: &Tables, prefix: &str, key: &str) -> Result<(), SavedError> {
    match tables.iter().find(|(name, _)| name.starts_with(prefix)) {
        Some((other, _)) => Err(bad(key, format!("missing beside `{other}`"))),
        None => Ok(()),
    }
}
