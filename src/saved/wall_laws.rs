//! Laws of walls as rows of numbers, and back.

use clastic_components::material::ContactLaw;

use super::SavedError;
use super::columns::bad;
use crate::scene::format as scene;
use crate::tables::{Array, Tables};

/// Array of the elasticity of rolling, where a wall has one: the compliance of the law in force, and
/// the stiffness of contacts and of bonds in the scene.
pub(super) const ROLLING: &str = "walls.rolling";

/// Rolling compliance of the law in force, rad/(N m), and rolling stiffness of contacts and of bonds
/// in the scene, N m/rad; no stiffness is infinite.
pub(super) fn rolling_row(law: Option<&ContactLaw>, wall: Option<&scene::Wall>) -> [f64; 3] {
    let of_bond = wall.and_then(|wall| wall.bond).and_then(|bond| bond.rolling_stiffness);
    let of_contact = wall.and_then(|wall| wall.contact.rolling_stiffness);
    [law.map_or(0.0, |law| law.rolling_compliance), rigid(of_contact), rigid(of_bond)]
}

/// Adds the rows if a wall rolls elastically.
pub(super) fn write_rolling(rows: Vec<[f64; 3]>, tables: &mut Tables) {
    if rows.iter().any(|row| *row != rigid_row()) {
        tables.put(ROLLING, Array::vectors(rows));
    }
}

/// The rows of `n` walls.
pub(super) fn read_rolling(tables: &Tables, n: usize) -> Result<Vec<[f64; 3]>, SavedError> {
    if !tables.has(ROLLING) {
        return Ok(vec![rigid_row(); n]);
    }
    let rows = tables.vectors::<3>(ROLLING, n)?;
    let is_law = |[c, k, l]: &[f64; 3]| c.is_finite() && *c >= 0.0 && *k > 0.0 && *l > 0.0;
    match rows.iter().position(|row| !is_law(row)) {
        Some(row) => Err(bad(ROLLING, format!("{:?} in row {row}", rows[row]))),
        None => Ok(rows),
    }
}

fn rigid_row() -> [f64; 3] {
    [0.0, f64::INFINITY, f64::INFINITY]
}

pub(super) fn law_row(law: &ContactLaw) -> [f64; 5] {
    let ContactLaw {
        normal_compliance,
        tangential_compliance,
        rolling_compliance: _,
        friction,
        rolling_friction,
        restitution,
    } = *law;
    [normal_compliance, tangential_compliance, friction, rolling_friction, restitution]
}

/// A law of contact as the scene has it; no stiffness is infinite.
pub(super) fn contact_row(law: &scene::Contact) -> [f64; 5] {
    let [n, t] = [law.normal_stiffness, law.tangential_stiffness].map(rigid);
    [n, t, law.friction, law.rolling_friction, law.restitution]
}

pub(super) fn contact(
    [n, t, friction, rolling_friction, restitution]: [f64; 5],
    rolling: f64,
) -> scene::Contact {
    let [normal_stiffness, tangential_stiffness, rolling_stiffness] = [n, t, rolling].map(elastic);
    scene::Contact {
        normal_stiffness,
        tangential_stiffness,
        rolling_stiffness,
        friction,
        rolling_friction,
        restitution,
    }
}

pub(super) fn bond_row(law: &scene::Bond) -> [f64; 6] {
    let [n, t] = [law.normal_stiffness, law.tangential_stiffness].map(rigid);
    [n, t, law.friction, law.rolling_friction, law.cohesion, law.tensile_strength]
}

/// A law of bonds; none if it is no number.
pub(super) fn bond(
    [n, t, friction, rolling_friction, cohesion, tensile]: [f64; 6],
    rolling: f64,
) -> Option<scene::Bond> {
    let [normal_stiffness, tangential_stiffness, rolling_stiffness] = [n, t, rolling].map(elastic);
    let law = scene::Bond {
        normal_stiffness,
        tangential_stiffness,
        rolling_stiffness,
        friction,
        rolling_friction,
        cohesion,
        tensile_strength: tensile,
        scatter: None,
    };
    (!n.is_nan()).then_some(law)
}

fn rigid(stiffness: Option<f64>) -> f64 {
    stiffness.unwrap_or(f64::INFINITY)
}

fn elastic(stiffness: f64) -> Option<f64> {
    Some(stiffness).filter(|k| k.is_finite())
}
