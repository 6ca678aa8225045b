//! Cementing (3.4.1 of the paper): bonds between pairs that are close enough. What a contact
//! carries its bond goes on carrying, so that the state stays as it is.

use bevy_ecs::prelude::*;

use clastic_components::body::{BodyId, BodyOrigin};
use clastic_components::bond::Bond;
use clastic_components::contact::{BodyTable, Contact};
use clastic_components::contact_history::{ContactHistory, KeptRows};
use clastic_components::increment::{Analysis, AnalysisKind};
use clastic_components::material::{BondLaw, Materials};
use clastic_systems::assemble_program::interactions::contact_law;
use clastic_systems::detect_contacts::gaps::{pair_contact, wall_contact, wall_gap};
use clastic_systems::detect_contacts::grid::pairs_within;
use clastic_systems::detect_contacts::periodic;
use clastic_systems::gather_bodies::gather_bodies;

use super::laws::bond_law;
use super::scatter::scattered;
use super::select::selected;
use super::settings::BondsOfMaterials;
use super::walls::WallCatalogue;
use crate::scene::format::{Bond as BondOfScene, Cement};

/// Bonds every pair of the selected particles with `g_0 < length` whose materials form bonds and
/// that has no intact bond. A wall with a bond law of its own bonds to every particle within the
/// length.
pub fn cement(world: &mut World, stage: &Cement) {
    let (bodies, history) = gathered(world);
    let n = bodies.particles;
    let mut pairs = Vec::new();
    if stage.particles {
        let disks = &bodies.positions[..n];
        match &bodies.cell {
            Some(cell) => {
                pairs = periodic::pairs_within(cell, disks, &bodies.radii, stage.length);
            }
            None => pairs_within(disks, &bodies.radii, stage.length, &mut pairs),
        }
    }
    let mut contacts: Vec<Contact> =
        pairs.iter().map(|(a, b)| pair_contact(&bodies, *a, *b)).collect();
    if stage.walls {
        for wall in &bodies.walls {
            let gap = |i: usize| {
                wall_gap(
                    &bodies.walls,
                    &bodies.positions,
                    wall,
                    bodies.positions[i],
                    bodies.radii[i],
                )
            };
            let near = (0..n).filter(|i| gap(*i) < stage.length);
            contacts.extend(near.map(|i| wall_contact(&bodies, i as u32, wall)));
        }
    }
    contacts.retain(|c| c.gap < stage.length);
    if let Some(select) = &stage.select {
        let mut takes_part = vec![false; n];
        for (id, _) in selected(world, select) {
            if let Some(row) = bodies.row(id) {
                takes_part[row] = true;
            }
        }
        let has = |row: u32| takes_part.get(row as usize).is_none_or(|takes_part| *takes_part);
        contacts.retain(|c| has(c.a) && has(c.b));
    }
    contacts.sort_unstable_by_key(|c| (c.a, c.b));
    let law = stage.bond.as_ref();
    for contact in contacts {
        add(world, &bodies, &history, &contact, law);
    }
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

/// Normal force of the contact before it is bonded, N. A pair that no increment has loaded carries
/// nothing, whatever its overlap.
fn carried(world: &World, bodies: &BodyTable, history: &ContactHistory, contact: &Contact) -> f64 {
    let Some(memory) = history.get(contact.a, contact.b) else { return 0.0 };
    let analysis = world.resource::<Analysis>();
    let law = contact_law(bodies, world.resource::<Materials>(), analysis, contact);
    match analysis.kind {
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
    if bodies.bonds.binary_search_by_key(&(a, b), |bond| (bond.a, bond.b)).is_ok() {
        return;
    }
    let materials = world.resource::<Materials>();
    // A world without a scene has no laws that scatter.
    let of_scene = world.get_resource::<BondsOfMaterials>();
    let origin = |row: u32| {
        let origin = world.get::<BodyOrigin>(bodies.entities[row as usize]);
        origin.map_or(bodies.positions[row as usize], |origin| origin.0)
    };
    let places = [origin(a), origin(b)];
    let law_of = |body: u32| {
        let index = *bodies.materials.get(body as usize)? as usize;
        let bond = of_scene.and_then(|laws| laws.0.get(index).copied().flatten());
        match bond.filter(|bond| bond.scatter.is_some()) {
            Some(bond) => Some(scattered(&bond, places)),
            None => materials.0[index].bond,
        }
    };
    let of_bodies = || {
        if b as usize >= bodies.particles {
            law_of_wall(world, bodies.ids[b as usize]).or_else(|| law_of(a))
        } else {
            law_of(a).zip(law_of(b)).map(|(a, b)| BondLaw::between(a, b))
        }
    };
    let law = law.map(|law| scattered(law, places)).or_else(of_bodies);
    let Some(law) = law else { return };
    let [a, b] = [a, b].map(|row| bodies.ids[row as usize]);
    // A bond carries p = -(gap - initial_gap)/C_N: at this gap what the contact carries.
    let initial_gap =
        contact.gap + law.normal_compliance * carried(world, bodies, history, contact);
    world.spawn(Bond { a, b, initial_gap, law });
}

/// Bond law that the scene gives a wall.
fn law_of_wall(world: &World, wall: BodyId) -> Option<BondLaw> {
    // A world without a scene has no catalogue.
    let catalogue = world.get_resource::<WallCatalogue>()?;
    catalogue.wall(wall)?.bond.as_ref().map(bond_law)
}
