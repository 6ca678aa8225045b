//! The bonds of a saved state, intact and broken.

use clastic_components::body::BodyId;
use clastic_components::bond::{Bond, BondId, BondState, RuptureMode};
use clastic_components::material::BondLaw;
use clastic_systems::state::WorldState;

use super::SavedError;
use super::columns::{bad, finite, identities};
use crate::tables::{Array, Tables};

pub(super) const ENTRIES: [&str; 2] = ["bond", "bond_state"];

const LAW: [&str; 7] = [
    "bonds.normal_compliance_m_n",
    "bonds.tangential_compliance_m_n",
    "bonds.rolling_compliance_rad_nm",
    "bonds.friction",
    "bonds.rolling_friction",
    "bonds.cohesion_pa",
    "bonds.tensile_strength_pa",
];

/// The codes of the array `bonds.state`.
const STATES: [BondState; 4] = [
    BondState::Intact,
    BondState::Broken(RuptureMode::Tension),
    BondState::Broken(RuptureMode::Shear),
    BondState::Broken(RuptureMode::Rolling),
];

pub(super) fn write(state: &WorldState, tables: &mut Tables) -> Result<(), SavedError> {
    let bonds = state.components::<BondId, Bond>("bond")?;
    let states = state.components::<BondId, BondState>("bond_state")?;
    let column = |of: fn(&Bond) -> u32| Array::u32(bonds.iter().map(|(_, b)| of(b)).collect());
    tables.put("bonds.id", Array::u32(bonds.iter().map(|(id, _)| id.0).collect()));
    tables.put("bonds.a", column(|bond| bond.a.0));
    tables.put("bonds.b", column(|bond| bond.b.0));
    let code = |id: &BondId| -> u8 {
        let found = states.binary_search_by_key(id, |(id, _)| *id).ok();
        let state = found.map_or(BondState::Intact, |k| states[k].1);
        STATES.iter().zip(0..).find(|(known, _)| **known == state).map_or(0, |(_, code)| code)
    };
    tables.put("bonds.state", Array::u8(bonds.iter().map(|(id, _)| code(id)).collect()));
    let gaps = bonds.iter().map(|(_, bond)| bond.initial_gap).collect();
    tables.put("bonds.initial_gap_m", Array::f64(gaps));
    for (k, name) in LAW.into_iter().enumerate() {
        let law = |bond: &Bond| {
            let law = bond.law;
            [
                law.normal_compliance,
                law.tangential_compliance,
                law.rolling_compliance,
                law.friction,
                law.rolling_friction,
                law.cohesion,
                law.tensile_strength,
            ][k]
        };
        tables.put(name, Array::f64(bonds.iter().map(|(_, bond)| law(bond)).collect()));
    }
    Ok(())
}

/// Reads the bonds between `bodies` (identities of particles, then of walls). `next` is the
/// identity that follows those of all bonds.
pub(super) fn read(
    tables: &Tables,
    bodies: &[u32],
    next: u32,
    state: &mut WorldState,
) -> Result<(), SavedError> {
    let ids = identities(tables, "bonds.id")?;
    let n = ids.len();
    if let Some(id) = ids.last().filter(|id| **id >= next) {
        return Err(bad("bonds.id", format!("bond {id}, and the next one is {next}")));
    }
    let mut sorted = bodies.to_vec();
    sorted.sort_unstable();
    let ends = [tables.u32("bonds.a", &[n])?, tables.u32("bonds.b", &[n])?];
    let codes = tables.u8("bonds.state", &[n])?;
    for (name, ends) in ["bonds.a", "bonds.b"].into_iter().zip(ends) {
        // A bond that broke stays in the record when its body goes.
        let is_lost = |row: &usize| {
            STATES.get(usize::from(codes[*row])) == Some(&BondState::Intact)
                && sorted.binary_search(&ends[*row]).is_err()
        };
        if let Some(row) = (0..n).find(is_lost) {
            let what = format!("body {} in row {row}, which is not there", ends[row]);
            return Err(bad(name, what));
        }
    }
    let gaps = tables.f64("bonds.initial_gap_m", &[n])?;
    finite(tables, &["bonds.initial_gap_m"])?;
    finite(tables, &LAW)?;
    let mut law = Vec::with_capacity(LAW.len());
    for name in LAW {
        law.push(tables.f64(name, &[n])?);
    }
    let (mut bonds, mut states) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for k in 0..n {
        let id = BondId(ids[k]);
        let law = BondLaw {
            normal_compliance: law[0][k],
            tangential_compliance: law[1][k],
            rolling_compliance: law[2][k],
            friction: law[3][k],
            rolling_friction: law[4][k],
            cohesion: law[5][k],
            tensile_strength: law[6][k],
        };
        let [a, b] = ends.map(|ends| BodyId(ends[k]));
        bonds.push((id, Bond { a, b, initial_gap: gaps[k], law }));
        let code = codes[k];
        let known = STATES.get(usize::from(code)).copied();
        let known = known.ok_or_else(|| bad("bonds.state", format!("{code} in row {k}")))?;
        states.push((id, known));
    }
    if n > 0 {
        state.set("bond", &bonds)?;
        state.set("bond_state", &states)?;
    }
    Ok(())
}
