//! Bonds: their laws, and the pairs that they join.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use super::bad::{Bad, finite};
use super::laws;
use crate::gather_bodies::BondData;

/// A bond without a meaning, with its entity and the name of the pair that it joins.
pub(super) type BadBond = (BondId, Entity, String, Bad);

/// The first bond of the tables without a meaning.
pub(super) fn in_tables(bodies: &BodyTable) -> Option<BadBond> {
    let pair = |bond: &BondRow| {
        let [a, b] = [bond.a, bond.b].map(|row| bodies.name(row as usize));
        format!("of {a} and {b}")
    };
    let of_law = bodies.bonds.iter().filter_map(|bond| {
        let gap = || finite("initial_gap", bond.initial_gap, "a length in m");
        let walls = || {
            let [first, second] = [bond.a, bond.b].map(|row| bodies.ids[row as usize]);
            let is_particle = (bond.a as usize) < bodies.particles;
            let is_group = bond.b as usize >= bodies.first_group();
            (!is_particle)
                .then(|| Bad::new("a", first, "a particle: walls bond to particles"))
                .or_else(|| {
                    let wanted = "a particle or a wall: members of a rigid group have bonds";
                    is_group.then(|| Bad::new("b", second, wanted))
                })
                .or_else(|| (first == second).then(|| Bad::new("b", second, "another body than a")))
        };
        let bad = laws::of_bond(&bond.law).or_else(gap).or_else(walls)?;
        Some((bond.id, bond.entity, pair(bond), bad))
    });
    // The table is ordered by pair and identity.
    let second = bodies.bonds.windows(2).filter_map(|two| {
        let is_second = (two[0].a, two[0].b) == (two[1].a, two[1].b);
        let wanted = format!(
            "one bond to a pair: bond {} joins it already; despawn one of the two",
            two[0].id.0
        );
        is_second.then(|| {
            let ends = [two[1].a, two[1].b].map(|row| bodies.ids[row as usize]);
            (two[1].id, two[1].entity, pair(&two[1]), Bad::new("bodies", ends, wanted))
        })
    });
    of_law.chain(second).next()
}

/// The first intact bond to a body that does not exist. Bonds end with their bodies, so that only
/// such a bond, or one within a rigid group, has no row.
pub(super) fn loose(bodies: &BodyTable, bonds: &Query<BondData>) -> Option<BadBond> {
    let intact = || bonds.iter().filter(|(.., state)| **state == BondState::Intact);
    if intact().count() == bodies.bonds.len() {
        return None;
    }
    let unknown = |id: BodyId| bodies.row(id).is_none();
    let loose = intact().filter_map(|(entity, id, bond, _)| {
        let (end, body) = [("a", bond.a), ("b", bond.b)].into_iter().find(|(_, b)| unknown(*b))?;
        let bad = Bad::new(end, body, "the identity of a body that is in the world");
        Some((*id, entity, format!("of bodies {} and {}", bond.a.0, bond.b.0), bad))
    });
    loose.min_by_key(|(id, ..)| *id)
}
