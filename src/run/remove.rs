//! `Remove` stages: particles that are taken away, for excavations and for specimens that are cut
//! out of a packing, also out of a periodic cell, which then ends.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use clastic_systems::tractions::{keep_tractions, loosened_wall, membrane_on};

use super::load_refusals::selects_none;
use super::select::{needs_forces, selected, selected_at};
use crate::scene::format::Remove;

/// Takes the selected particles away. Their bonds and the memory of their contacts go with them, by
/// the hooks of [`BodyId`]. Bonds that broke before stay in the record.
pub fn remove(world: &mut World, stage: &Remove) {
    if stage.open_cell {
        super::cell::open(world);
    }
    let (gone, entities): (Vec<_>, Vec<_>) = selected(world, &stage.select).into_iter().unzip();
    if stage.keep_tractions {
        keep_tractions(world, &gone);
    }
    for entity in entities {
        world.despawn(entity);
    }
}

/// Why the particles cannot be taken away; `None` if they can.
pub fn refusal(world: &mut World, stage: &Remove) -> Option<String> {
    let cell = world.get_resource::<PeriodicCell>().filter(|_| stage.open_cell).copied();
    let place = |place: DVec2| cell.map_or(place, |cell| cell.wrapped(place));
    let ids: Vec<BodyId> =
        selected_at(world, &stage.select, place).into_iter().map(|(id, _)| id).collect();
    if let (Some(cell), Some([low, high])) = (&cell, stage.select.left())
        && cell.tilt == 0.0
        && (low.0.min(low.1) < 0.0 || high.0 > cell.width || high.1 > cell.height)
    {
        return Some(format!(
            "what is left reaches from {low:?} to {high:?} m, and the cell from (0, 0) to ({:.4e}, {:.4e}) m; \
             cut within it, or give the packing more particles",
            cell.width, cell.height
        ));
    }
    if ids.is_empty() && !stage.open_cell && !needs_forces(world, &stage.select) {
        return Some(format!("select {}", selects_none(&stage.select)));
    }
    if ids.len() == world.query::<&Particle>().iter(world).len() {
        let what = "select selects every particle, so that nothing is left; select fewer";
        return Some(what.to_owned());
    }
    if stage.keep_tractions
        && let Some(wall) = loosened_wall(world, &ids)
    {
        return Some(format!(
            "keep_tractions holds particles only, and select takes particles that carry the wall \
             `{wall}`; select none that touches it, or hold that wall, outside of rigid groups, in a loading stage before"
        ));
    }
    if stage.keep_tractions
        && let Some(membrane) = membrane_on(world, &ids)
    {
        return Some(format!(
            "keep_tractions does not hold a membrane, and select takes particles on which the membrane \
             `{membrane}` presses, which would then press on those behind them too; select others, or end \
             the membrane in a loading stage before (`remove_membranes`)"
        ));
    }
    let mut groups = world.query::<&RigidGroup>();
    let member = |group: &RigidGroup| {
        let id = group.members.iter().find(|id| ids.binary_search(id).is_ok())?;
        Some((id.0, group.name.clone()))
    };
    let (id, group) = groups.iter(world).filter_map(member).min()?;
    Some(format!(
        "select selects particle {id}, which is a member of the rigid group `{group}`; select others, \
         or release `{group}` in a loading stage before"
    ))
}
