//! Members and pivots of rigid groups.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

use super::bad::Bad;

/// The first group without a meaning, by name.
pub(super) fn bad(
    bodies: &BodyTable,
    kind: AnalysisKind,
    groups: &Query<(&BodyId, &RigidGroup)>,
) -> Option<String> {
    let bad =
        groups.iter().filter_map(|(id, group)| Some((id, group, of(bodies, kind, *id, group)?)));
    let (_, group, bad) = bad.min_by_key(|(id, ..)| **id)?;
    Some(bad.in_words(format_args!("rigid group `{}`", group.name)))
}

fn of(bodies: &BodyTable, kind: AnalysisKind, id: BodyId, group: &RigidGroup) -> Option<Bad> {
    let row = bodies.row(id)?;
    let own = bodies.group_at(row)?;
    let unknown = || {
        let known = |id: BodyId| bodies.row(id).is_some_and(|row| row < bodies.first_group());
        let member = group.members.iter().find(|member| !known(**member))?;
        Some(Bad::new(
            "a member",
            member,
            "the identity of a particle or wall that is in the world",
        ))
    };
    let shared = || {
        let is_own = |member: u32| {
            bodies.group(member as usize).is_some_and(|group| group.body as usize == row)
        };
        let member = own.members.iter().find(|member| !is_own(**member))?;
        let wanted = "a body that is a member of no other group";
        Some(Bad::new("a member", bodies.ids[*member as usize], wanted))
    };
    let pivot = || {
        let is_held = own.drives[..2].iter().all(|drive| *drive != BodyDrive::Free);
        let is_loose = group.has_pivot && !is_held && matches!(kind, AnalysisKind::Dynamic { .. });
        let wanted = "false, or `BodyDrives` that impose both translations of the pivot: a time step has no \
                      terms for a pivot that moves freely";
        is_loose.then(|| Bad::new("has_pivot", true, wanted))
    };
    unknown().or_else(shared).or_else(pivot)
}
