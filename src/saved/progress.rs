//! Quantities that count from the start of the first run: increments, time, identities, energies.

use clastic_components::energy::{Changed, Energies, EnergyLedger, Released};
use clastic_components::increment::ClasticProgress;
use clastic_systems::identities::NextIdentities;
use clastic_systems::schedule::PROGRESS;
use clastic_systems::state::WorldState;

use super::SavedError;
use super::columns::{bad, count, finite, none_of, single};
use crate::tables::{Array, Tables};

/// Entry with the energy ledger.
pub(crate) const LEDGER: &str = "energy_ledger";
/// Entry with the next identities.
const IDENTITIES: &str = "identities.next";

pub(super) const ENTRIES: [&str; 3] = [LEDGER, IDENTITIES, PROGRESS];

/// What counts from the start of the first run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counts {
    /// Number of the last increment.
    pub increment: u64,
    /// Time, s.
    pub time: f64,
    /// Identities of the next body and bond.
    pub next: NextIdentities,
}

pub(super) fn write(
    state: &WorldState,
    thickness: f64,
    tables: &mut Tables,
) -> Result<(), SavedError> {
    let progress: ClasticProgress = state.get(PROGRESS)?;
    let next: NextIdentities = state.get(IDENTITIES)?;
    tables.put("increment", Array::count(progress.increment));
    tables.put("time_s", Array::value(progress.time));
    tables.put("stage", Array::word(&progress.stage_name));
    tables.put("thickness_m", Array::value(thickness));
    tables.put("next_body", Array::count(next.body.into()));
    tables.put("next_bond", Array::count(next.bond.into()));
    if state.bytes(LEDGER).is_some() {
        let ledger: EnergyLedger = state.get(LEDGER)?;
        tables.put("energy.total_j", Array::f64(ledger.total.to_array().to_vec()));
        tables.put("energy.last_increment_j", Array::f64(ledger.increment.to_array().to_vec()));
        // No number before the first increment.
        tables.put("energy.elastic_j", Array::value(ledger.stored.unwrap_or(f64::NAN)));
        tables.put("energy.kinetic_j", Array::value(ledger.kinetic.unwrap_or(f64::NAN)));
        let released = &ledger.released;
        tables.put("energy.released_a", Array::u32(released.iter().map(|r| r.a).collect()));
        tables.put("energy.released_b", Array::u32(released.iter().map(|r| r.b).collect()));
        let forces = released.iter().map(|r| r.forces);
        tables.put("energy.released_force", Array::vectors(forces));
    }
    Ok(())
}

pub(super) fn read(tables: &Tables, state: &mut WorldState) -> Result<Counts, SavedError> {
    let increment = count(tables, "increment")?;
    let time = single(tables, "time_s")?;
    finite(tables, &["time_s"])?;
    let identity = |name: &str| -> Result<u32, SavedError> {
        let next = count(tables, name)?;
        u32::try_from(next).map_err(|_| bad(name, format!("{next}, beyond all identities")))
    };
    let next = NextIdentities { body: identity("next_body")?, bond: identity("next_bond")? };
    state.set(IDENTITIES, &next)?;
    state.set(PROGRESS, &ClasticProgress { increment, time, ..ClasticProgress::default() })?;
    if !tables.has("energy.total_j") {
        none_of(tables, "energy.", "energy.total_j")?;
    } else {
        let n = tables.rows("energy.released_a")?;
        let a = tables.u32("energy.released_a", &[n])?;
        let b = tables.u32("energy.released_b", &[n])?;
        let forces = tables.vectors::<3>("energy.released_force", n)?.into_iter();
        let released = forces.zip(a.iter().zip(b));
        let now = |name: &str| -> Result<Option<f64>, SavedError> {
            Ok(Some(single(tables, name)?).filter(|energy| !energy.is_nan()))
        };
        let ledger = EnergyLedger {
            increment: energies(tables, "energy.last_increment_j")?,
            total: energies(tables, "energy.total_j")?,
            stored: now("energy.elastic_j")?,
            kinetic: now("energy.kinetic_j")?,
            changed: Changed::Nothing,
            released: released.map(|(forces, (a, b))| Released { a: *a, b: *b, forces }).collect(),
        };
        state.set(LEDGER, &ledger)?;
    }
    Ok(Counts { increment, time, next })
}

fn energies(tables: &Tables, name: &str) -> Result<Energies, SavedError> {
    let all = tables.f64(name, &[13])?;
    finite(tables, &[name])?;
    Ok(Energies::from_array(std::array::from_fn(|k| all[k])))
}
