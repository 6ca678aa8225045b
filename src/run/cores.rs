//! How well contacts and bonds hold each particle, for selections of loose ones.

use std::collections::{BTreeMap, BTreeSet};

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;

/// The largest k for which each particle belongs to a part of the specimen in which every particle has
/// k neighbours or more (its core number). Neighbours have an intact bond or a contact that carries
/// force with it. Walls and members of rigid groups belong to every such part.
pub fn cores(world: &mut World) -> BTreeMap<BodyId, u32> {
    let mut neighbours: BTreeMap<BodyId, Vec<BodyId>> = world
        .query_filtered::<&BodyId, With<Particle>>()
        .iter(world)
        .map(|id| (*id, Vec::new()))
        .collect();
    let mut groups = world.query::<&RigidGroup>();
    for member in groups.iter(world).flat_map(|group| &group.members) {
        neighbours.remove(member);
    }
    let mut there = world.query::<&BodyId>();
    let there: BTreeSet<BodyId> = there.iter(world).copied().collect();
    let mut bonds = world.query::<(&Bond, &BondState)>();
    let intact = bonds.iter(world).filter(|(_, state)| **state == BondState::Intact);
    let intact = intact.map(|(bond, _)| (bond.a, bond.b));
    let ids = &world.resource::<KeptRows>().ids;
    // A bond that has just broken in tension has left its force there.
    let carrying = world.resource::<ContactHistory>().0.iter().filter(|m| m.p > 0.0);
    let carrying = carrying.map(|m| (ids[m.a as usize], ids[m.b as usize]));
    // A pair may have a bond that carries force. Contacts of particles that are gone have no body.
    let pairs: BTreeSet<_> = intact.chain(carrying).map(|(a, b)| (a.min(b), a.max(b))).collect();
    for (a, b) in pairs.into_iter().filter(|(a, b)| there.contains(a) && there.contains(b)) {
        for (one, other) in [(a, b), (b, a)] {
            if let Some(list) = neighbours.get_mut(&one) {
                list.push(other);
            }
        }
    }
    // The particle with the fewest neighbours goes first.
    let mut counts: BTreeMap<BodyId, u32> =
        neighbours.iter().map(|(id, list)| (*id, list.len() as u32)).collect();
    let mut queue: BTreeSet<(u32, BodyId)> = counts.iter().map(|(id, n)| (*n, *id)).collect();
    let (mut cores, mut core) = (BTreeMap::new(), 0);
    while let Some((count, id)) = queue.pop_first() {
        core = core.max(count);
        cores.insert(id, core);
        for other in &neighbours[&id] {
            if let Some(count) = counts.get_mut(other)
                && queue.remove(&(*count, *other))
            {
                *count -= 1;
                queue.insert((*count, *other));
            }
        }
    }
    cores
}
