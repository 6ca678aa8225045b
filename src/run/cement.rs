//! Cementing (3.4.1 of the paper): bonds between pairs that are close enough. A bond carries on the
//! force of its contact, so that the state does not change. A bond whose law names no stiffness
//! therefore has that of its contact: rigid bonds on elastic contacts would carry whatever balances
//! the loads.

use bevy_ecs::prelude::*;

use clastic_components::body::{BodyId, BodyOrigin};
use clastic_components::bond::{Bond, BondState};
use clastic_components::contact::{BodyTable, Contact};
use clastic_components::contact_history::{ContactHistory, KeptRows};
use clastic_components::increment::{AnalysisKind, ClasticAnalysis};
use clastic_components::material::{BondLaw, ContactLaw, Materials};
use clastic_systems::contact_laws::law_of_pair;
use clastic_systems::detect_contacts::gaps::{pair_contact, wall_contact, wall_gap};
use clastic_systems::detect_contacts::grid::pairs_within;
use clastic_systems::detect_contacts::periodic;
use clastic_systems::gather_bodies::gather_bodies;

use super::laws::bond_law;
use super::scatter::scattered;
use super::script::Script;
use super::select::selected;
use super::walls::WallCatalogue;
use crate::scene::format::{Bond as BondOfScene, Cement};

/// Bonds pairs of the selected particles whose materials form bonds and that have no intact bond:
/// those with `g_0 < length`, or the nearest ones. A wall with a bond law of its own bonds to every
/// particle within the length.
pub fn cement(world: &mut World, stage: &Cement) {
    let (bodies, history) = gathered(world);
    let takes_part = members(world, &bodies, stage);
    let contacts = match stage.coordination {
        None => near(&bodies, stage, &takes_part, stage.length.unwrap_or_default()),
        Some(_) => nearest(&bodies, stage, &takes_part),
    };
    for contact in contacts {
        add(world, &bodies, &history, &contact, stage.bond.as_ref());
    }
}

/// Whether a particle can be bonded, by row.
fn members(world: &mut World, bodies: &BodyTable, stage: &Cement) -> Vec<bool> {
    let Some(select) = &stage.select else { return vec![true; bodies.particles] };
    let chosen = selected(world, select);
    let is_chosen = |id: &BodyId| chosen.binary_search_by_key(id, |(id, _)| *id).is_ok();
    bodies.ids[..bodies.particles].iter().map(is_chosen).collect()
}

/// Why there are not as many pairs as are to be bonded, or none.
pub(super) fn refusal(world: &mut World, stage: &Cement) -> Option<String> {
    let (bodies, _) = gathered(world);
    let takes_part = members(world, &bodies, stage);
    if let Some(length) = stage.length {
        let pairs = near(&bodies, stage, &takes_part, length);
        let is_empty = pairs.iter().all(|contact| is_bonded(&bodies, contact));
        let to_walls = !stage.particles && bodies.walls.is_empty();
        let what = if to_walls {
            "no wall is there"
        } else {
            "no gap of a pair without a bond that it selects is below that"
        };
        return is_empty.then(|| {
            format!(
                "it would bond nothing: its length is {length:?} m, and {what}; give a greater one, or \
                 cement when there is something to bond"
            )
        });
    }
    let wanted = number(stage, &takes_part);
    let n = takes_part.iter().filter(|takes_part| **takes_part).count();
    let pairs = n * n.saturating_sub(1) / 2;
    (wanted > pairs).then(|| {
        format!(
            "{wanted} bonds between {n} particles, which have {pairs} pairs; give a smaller \
             `coordination`"
        )
    })
}

/// Number of bonds that a coordination asks for.
fn number(stage: &Cement, takes_part: &[bool]) -> usize {
    let n = takes_part.iter().filter(|takes_part| **takes_part).count();
    (0.5 * stage.coordination.unwrap_or_default() * n as f64).round() as usize
}

/// The pairs without a bond that have the smallest gaps.
fn nearest(bodies: &BodyTable, stage: &Cement, takes_part: &[bool]) -> Vec<Contact> {
    let wanted = number(stage, takes_part);
    let mut length = bodies.mean_radius;
    loop {
        let mut contacts = near(bodies, stage, takes_part, length);
        contacts.retain(|c| !is_bonded(bodies, c));
        let spread = bodies.positions.iter().map(|x| x.length()).fold(0.0, f64::max);
        if contacts.len() >= wanted || length > 2.0 * spread {
            contacts.sort_by(|a, b| a.gap.total_cmp(&b.gap));
            contacts.truncate(wanted);
            contacts.sort_unstable_by_key(|c| (c.a, c.b));
            return contacts;
        }
        length *= 2.0;
    }
}

/// Pairs that take part with a gap below a length, in the order of their bodies.
fn near(bodies: &BodyTable, stage: &Cement, takes_part: &[bool], length: f64) -> Vec<Contact> {
    let n = bodies.particles;
    let mut pairs = Vec::new();
    if stage.particles {
        let disks = &bodies.positions[..n];
        match &bodies.cell {
            Some(cell) => pairs = periodic::pairs_within(cell, disks, &bodies.radii, length),
            None => pairs = pairs_within(disks, &bodies.radii, length),
        }
    }
    let mut contacts: Vec<Contact> =
        pairs.iter().map(|(a, b)| pair_contact(bodies, *a, *b)).collect();
    if stage.walls {
        for wall in &bodies.walls {
            let gap = |i: usize| {
                let (x, r) = (bodies.positions[i], bodies.radii[i]);
                wall_gap(&bodies.walls, &bodies.positions, wall, x, r)
            };
            let near = (0..n).filter(|i| gap(*i) < length);
            contacts.extend(near.map(|i| wall_contact(bodies, i as u32, wall)));
        }
    }
    let has = |row: u32| takes_part.get(row as usize).is_none_or(|takes_part| *takes_part);
    contacts.retain(|c| c.gap < length && has(c.a) && has(c.b));
    contacts.sort_unstable_by_key(|c| (c.a, c.b));
    contacts
}

fn is_bonded(bodies: &BodyTable, contact: &Contact) -> bool {
    let pair = (contact.a, contact.b);
    bodies.bonds.binary_search_by_key(&pair, |bond| (bond.a, bond.b)).is_ok()
}

/// Bonds pairs of particles at their current positions.
pub fn bond_pairs(world: &mut World, pairs: impl Iterator<Item = (u32, u32)>) {
    let (bodies, history) = gathered(world);
    for (a, b) in pairs {
        let contact = pair_contact(&bodies, a.min(b), a.max(b));
        add(world, &bodies, &history, &contact, None);
    }
}

/// The bodies, and the memory of their contacts by their rows.
fn gathered(world: &mut World) -> (BodyTable, ContactHistory) {
    // The system is registered once and cached, so that only one function gathers the tables.
    let _ = world.run_system_cached(gather_bodies);
    let bodies = world.resource::<BodyTable>().clone();
    let mut history = world.resource::<ContactHistory>().clone();
    // The rows of the memory are those of the last increment.
    let mut rows = world.resource::<KeptRows>().clone();
    rows.follow(&bodies);
    if rows.is_needed() {
        history.renumber(&rows);
    }
    (bodies, history)
}

/// Number of intact bonds.
pub(super) fn intact(world: &mut World) -> usize {
    let mut bonds = world.query::<&BondState>();
    bonds.iter(world).filter(|state| **state == BondState::Intact).count()
}

/// Normal force of a contact before it is bonded, N. A pair that no increment has loaded carries
/// nothing, whatever its overlap.
fn carried(world: &World, history: &ContactHistory, contact: &Contact, law: &ContactLaw) -> f64 {
    let Some(memory) = history.get(contact.a, contact.b) else { return 0.0 };
    match world.resource::<ClasticAnalysis>().kind {
        // The memory of a time step is the mean over the step.
        AnalysisKind::Dynamic { .. } if law.normal_compliance > 0.0 => {
            (-contact.gap / law.normal_compliance).max(0.0)
        }
        // A bond that has just broken in tension carries nothing.
        _ => memory.p.max(0.0),
    }
}

fn add(
    world: &mut World,
    bodies: &BodyTable,
    history: &ContactHistory,
    contact: &Contact,
    law: Option<&BondOfScene>,
) {
    let (a, b) = (contact.a, contact.b);
    if is_bonded(bodies, contact) {
        return;
    }
    let materials = world.resource::<Materials>();
    // A world without a scene has no laws that scatter.
    let scene = world.get_resource::<Script>().map(|script| &script.scene);
    let origin = |row: u32| {
        let origin = world.get::<BodyOrigin>(bodies.entities[row as usize]);
        origin.map_or(bodies.positions[row as usize], |origin| origin.0)
    };
    let places = [origin(a), origin(b)];
    let law_of = |body: u32| {
        let index = *bodies.materials.get(body as usize)? as usize;
        let bond = scene.and_then(|scene| scene.materials.values().nth(index)?.bond);
        let law = match bond.filter(|bond| bond.scatter.is_some()) {
            Some(bond) => scattered(&bond, places),
            None => materials.0[index].bond?,
        };
        // Each material first: the mean of a stiffness and none would be twice the one.
        Some(law.on(&materials.0[index].contact))
    };
    let of_bodies = || {
        if b as usize >= bodies.particles {
            // A world without a scene has no catalogue.
            let catalogue = world.get_resource::<WallCatalogue>();
            let wall = catalogue.and_then(|catalogue| catalogue.wall(bodies.ids[b as usize]));
            wall.and_then(|wall| wall.bond.as_ref()).map(bond_law).or_else(|| law_of(a))
        } else {
            law_of(a).zip(law_of(b)).map(|(a, b)| BondLaw::between(a, b))
        }
    };
    let law = law.map(|law| scattered(law, places)).or_else(of_bodies);
    let Some(law) = law else { return };
    let [a, b] = [a, b].map(|row| bodies.ids[row as usize]);
    let of_contact = law_of_pair(bodies, materials, contact);
    let law = law.on(&of_contact);
    // A bond carries p = -(gap - initial_gap)/C_N: at this gap what the contact carries.
    let initial_gap =
        contact.gap + law.normal_compliance * carried(world, history, contact, &of_contact);
    world.spawn(Bond { a, b, initial_gap, law });
}
