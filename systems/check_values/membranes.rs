//! Membranes.

use bevy_ecs::prelude::*;

use clastic_components::domain::RADIUS;
use clastic_components::prelude::*;

use super::bad::{Bad, not_negative, outside};

/// The first membrane without a meaning, by name.
pub(super) fn bad(bodies: &BodyTable, membranes: &Query<&Membrane>) -> Option<String> {
    let bad = membranes.iter().filter_map(|membrane| Some((membrane, of(bodies, membrane)?)));
    let (membrane, bad) = bad.min_by(|(one, _), (other, _)| one.name.cmp(&other.name))?;
    Some(bad.in_words(format_args!("membrane `{}`", membrane.name)))
}

fn of(bodies: &BodyTable, membrane: &Membrane) -> Option<Bad> {
    let is_wall = |id: BodyId| bodies.row(id).is_some_and(|row| bodies.wall(row as u32).is_some());
    let walls = || {
        let Course::Between { first, second, .. } = membrane.course else { return None };
        let ends = [("first", first), ("second", second)];
        let (end, id) = ends.into_iter().find(|(_, id)| !is_wall(*id))?;
        Some(Bad::new(end, id, "the identity of a wall that is in the world"))
    };
    let (from, to) = membrane.pressure;
    not_negative("pressure at the start", from, "a pressure in Pa, not below 0")
        .or_else(|| not_negative("pressure at the end", to, "a pressure in Pa, not below 0"))
        .or_else(|| outside("ball", membrane.ball?, RADIUS))
        .or_else(walls)
}
