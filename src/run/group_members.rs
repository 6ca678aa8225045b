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

/// The measures of groups of the scene, of those that are live or of the others: name and selection.
fn wanted(world: &World, are_live: bool) -> Vec<(String, scene::Select)> {
    let of = |measure: &scene::Measure| match &measure.of {
        scene::Quantity::GroupForce { select, live, .. } if *live == are_live => {
            Some((measure.name.clone(), select.clone()))
        }
        _ => None,
    };
    world.resource::<Script>().scene.measures.iter().filter_map(of).collect()
}

/// The particles of a selection, in the order of identities.
pub(super) fn members(world: &mut World, select: &scene::Select) -> Vec<BodyId> {
    selected(world, select).into_iter().map(|(id, _)| id).collect()
}

/// Selects the particles of the stage that begins.
pub(super) fn begin_stage(world: &mut World) {
    let fixed = wanted(world, false).into_iter();
    let all: BTreeMap<_, _> = fixed.map(|(name, select)| (name, members(world, &select))).collect();
    if !all.is_empty() {
        world.insert_resource(GroupMembers(all));
    }
}

/// Selects the particles of the live groups for the increment that begins. Exclusive, because a
/// selection reads every particle of the world.
pub(super) fn begin_increment(world: &mut World) {
    for (name, select) in wanted(world, true) {
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
