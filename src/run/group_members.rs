//! Particles of the groups on which forces are measured: selected when a stage begins, or in every
//! increment.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use clastic_components::body::BodyId;
use clastic_components::measure::{NamedMeasures, Quantity};

use super::script::Script;
use super::select::selected;
use crate::scene::format as scene;

/// Name of [`GroupMembers`] in a state.
pub const GROUP_MEMBERS: &str = "measures.groups";

/// Particles that the measures of the scene have selected when the stage began, by the name of the
/// measure. A scene without such measures has no such resource.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroupMembers(pub BTreeMap<String, Vec<BodyId>>);

/// The measures of groups of the scene: name, selection, and whether it is live.
fn wanted(world: &World) -> Vec<(String, scene::Select, bool)> {
    let Some(script) = world.get_resource::<Script>() else { return Vec::new() };
    let of = |measure: &scene::Measure| match &measure.of {
        scene::Quantity::GroupForce { select, live, .. } => {
            Some((measure.name.clone(), select.clone(), *live))
        }
        _ => None,
    };
    script.scene.measures.iter().filter_map(of).collect()
}

/// The particles of a selection, in the order of identities.
pub(super) fn members(world: &mut World, select: &scene::Select) -> Vec<BodyId> {
    selected(world, select).into_iter().map(|(id, _)| id).collect()
}

/// Selects the particles of the stage that begins.
pub(super) fn begin_stage(world: &mut World) {
    let fixed: Vec<_> = wanted(world).into_iter().filter(|(.., live)| !live).collect();
    if fixed.is_empty() {
        return;
    }
    let of = |(name, select, _): (String, scene::Select, bool)| (name, members(world, &select));
    let all: BTreeMap<_, _> = fixed.into_iter().map(of).collect();
    world.insert_resource(GroupMembers(all));
}

/// Run condition: the scene measures forces on groups.
pub(super) fn are_measured(named: Res<NamedMeasures>) -> bool {
    named.list.iter().any(|(_, quantity)| matches!(quantity, Some(Quantity::GroupForce { .. })))
}

/// Selects the particles of the live groups for the increment that begins. Exclusive, because a
/// selection reads every particle of the world.
pub(super) fn begin_increment(world: &mut World) {
    for (name, select, _) in wanted(world).into_iter().filter(|(.., live)| *live) {
        let now = members(world, &select);
        let mut named = world.resource_mut::<NamedMeasures>();
        for (measure, quantity) in &mut named.list {
            if let Some(Quantity::GroupForce { select: members, .. }) = quantity
                && *measure == name
            {
                members.clone_from(&now);
            }
        }
    }
}
