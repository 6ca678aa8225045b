//! Links, and bonds that they would put out of action.

use bevy_ecs::prelude::*;

use clastic_components::domain::{COMPLIANCE, PLACE};
use clastic_components::prelude::*;

use super::bad::{self, Bad, outside};
use crate::gather_bodies::BondData;

/// The first link without a meaning, in words.
pub(super) fn bad(
    bodies: &BodyTable,
    links: &Query<(Entity, &Link)>,
    bonds: &Query<BondData>,
) -> Option<String> {
    // A rigid group has a row, but no rotation; its members have.
    let is_known = |id| bodies.row(id).is_some_and(|row| row < bodies.rotations.len());
    let mut loose = links.iter().filter_map(|(entity, link)| {
        let (end, id) =
            [("a", link.a), ("b", link.b)].into_iter().find(|(_, id)| !is_known(*id))?;
        let bad = Bad::new(end, id, "the identity of a particle or wall that is in the world");
        Some(bad.in_words(format_args!("the link of entity {entity}")))
    });
    loose.next().or_else(|| of_rows(bodies, bonds))
}

fn of_rows(bodies: &BodyTable, bonds: &Query<BondData>) -> Option<String> {
    bodies.links.iter().find_map(|link| {
        let mut arms = link.arms.iter().flat_map(|arm| [arm.x, arm.y]);
        let length = || match link.kind {
            LinkKind::Length(length) => {
                let is_length = length > 0.0 && length.is_finite();
                let wanted = "a length in m above 0; `Link::hinge` has none";
                bad::bad("length", length, is_length, wanted)
            }
            LinkKind::Hinge => None,
        };
        let bond = || {
            let pair = link.rows.map(|row| bodies.ids[row as usize]);
            let joins = |bond: &Bond| pair == [bond.a, bond.b] || pair == [bond.b, bond.a];
            let (_, id, ..) = bonds
                .iter()
                .find(|(_, _, bond, state)| **state == BondState::Intact && joins(bond))?;
            let wanted = "either a link or a bond to a pair: despawn one of the two";
            Some(Bad::new("a pair with bond", id.0, wanted))
        };
        let itself = || {
            let [a, b] = link.rows;
            (a == b).then(|| Bad::new("b", bodies.ids[b as usize], "another body than a"))
        };
        let bad = arms
            .find_map(|arm| outside("on_a or on_b", arm, PLACE))
            .or_else(itself)
            .or_else(length)
            .or_else(|| outside("compliance", link.compliance, COMPLIANCE))
            .or_else(bond)?;
        let [a, b] = link.rows.map(|row| bodies.name(row as usize));
        Some(bad.in_words(format_args!("the link of {a} and {b}, entity {},", link.entity)))
    })
}
