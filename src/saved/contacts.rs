//! Contacts of a saved state with the forces that they carry, and the memory of the solver.

use bevy_ecs::prelude::*;
use clastic_components::body::BodyId;
use clastic_components::contact::BodyTable;
use clastic_components::contact_history::{ContactHistory, ContactMemory};
use clastic_systems::solve_program::SOLVER_MEMORY;
use clastic_systems::state::WorldState;

use super::SavedError;
use super::columns::{bad, finite};
use crate::frames::pairs::contact;
use crate::tables::{Array, Tables};

/// Entry with the identities behind rows.
const ROWS: &str = "contact_history.rows";
/// Entry with the memory of contacts.
const HISTORY: &str = "contact_history";

pub(super) const ENTRIES: [&str; 3] = [HISTORY, ROWS, SOLVER_MEMORY];

pub(super) fn write(
    state: &WorldState,
    world: &World,
    tables: &mut Tables,
) -> Result<(), SavedError> {
    let rows: Vec<BodyId> = state.get(ROWS)?;
    let history: ContactHistory = state.get(HISTORY)?;
    let id = |row: u32| rows.get(row as usize).map_or(u32::MAX, |id| id.0);
    let column = |of: fn(&ContactMemory) -> f64| Array::f64(history.0.iter().map(of).collect());
    tables.put("contacts.a", Array::u32(history.0.iter().map(|m| id(m.a)).collect()));
    tables.put("contacts.b", Array::u32(history.0.iter().map(|m| id(m.b)).collect()));
    tables.put("contacts.p_n", column(|m| m.p));
    tables.put("contacts.q_n", column(|m| m.q));
    tables.put("contacts.tau_nm", column(|m| m.tau));
    let bodies = world.resource::<BodyTable>();
    let found: Vec<_> =
        history.0.iter().map(|m| contact(bodies, (BodyId(id(m.a)), BodyId(id(m.b))))).collect();
    let normals = found.iter().map(|c| c.map_or([f64::NAN; 2], |c| c.normal.to_array()));
    tables.put("contacts.normal", Array::vectors(normals));
    let gaps = found.iter().map(|c| c.map_or(f64::NAN, |c| c.gap)).collect();
    tables.put("contacts.gap_m", Array::f64(gaps));
    let bonded = found.iter().map(|c| {
        let rows = c.map(|c| (c.a, c.b))?;
        let at = bodies.bonds.binary_search_by_key(&rows, |bond| (bond.a, bond.b)).ok()?;
        Some(bodies.bonds[at].id.0)
    });
    tables.put("contacts.bond", Array::u32(bonded.map(|id| id.unwrap_or(u32::MAX)).collect()));
    tables.put("rows.id", Array::u32(rows.iter().map(|id| id.0).collect()));
    let memory: Vec<[f64; 3]> = state.get(SOLVER_MEMORY)?;
    tables.put("rows.solver_memory", Array::vectors(memory));
    Ok(())
}

pub(super) fn read(tables: &Tables, state: &mut WorldState) -> Result<(), SavedError> {
    let rows = tables.u32("rows.id", &[tables.rows("rows.id")?])?;
    let n = tables.rows("contacts.a")?;
    finite(tables, &["contacts.p_n", "contacts.q_n", "contacts.tau_nm", "rows.solver_memory"])?;
    let mut at: Vec<(u32, u32)> = rows.iter().copied().zip(0..).collect();
    at.sort_unstable();
    let row = |name: &str, k: usize, id: u32| {
        let found = at.binary_search_by_key(&id, |(id, _)| *id).ok().map(|k| at[k].1);
        found.ok_or_else(|| bad(name, format!("body {id} in row {k}, which `rows.id` lacks")))
    };
    let (a, b) = (tables.u32("contacts.a", &[n])?, tables.u32("contacts.b", &[n])?);
    let (p, q) = (tables.f64("contacts.p_n", &[n])?, tables.f64("contacts.q_n", &[n])?);
    let tau = tables.f64("contacts.tau_nm", &[n])?;
    let mut history = ContactHistory(Vec::with_capacity(n));
    for k in 0..n {
        let (a, b) = (row("contacts.a", k, a[k])?, row("contacts.b", k, b[k])?);
        if history.0.last().is_some_and(|last| (last.a, last.b) >= (a, b)) {
            return Err(bad("contacts.a", format!("pairs do not ascend in row {k}")));
        }
        history.0.push(ContactMemory { a, b, p: p[k], q: q[k], tau: tau[k] });
    }
    let memory = tables.rows("rows.solver_memory")?;
    let memory = tables.vectors::<3>("rows.solver_memory", memory)?;
    state.set(ROWS, &rows.iter().map(|id| BodyId(*id)).collect::<Vec<_>>())?;
    state.set(HISTORY, &history)?;
    state.set(SOLVER_MEMORY, &memory)?;
    Ok(())
}
