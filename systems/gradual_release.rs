//! Gradual release of the forces of broken bonds, with
//! [`Avalanche::Gradual`](clastic_components::increment::Avalanche).
//!
//! The force that a rupture takes away, that of the bond less what the contact keeps of it, goes on
//! acting on the two bodies as long as it is not released. It is a pair of opposite forces through
//! the place of the bond, with its moment, in the axes of the pair, so that it turns with the pair
//! and balances by itself. An increment of fraction 0 takes it back from its full value to the
//! [share](clastic_components::findings::EventSearch::kept) at which the next bond reaches its
//! limit, or to zero.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use clastic_components::attempt::{Attempt, IncrementStatus};
use clastic_components::contact::{Bodies, Contact};
use clastic_components::contact_history::ContactHistory;
use clastic_components::findings::{EventSearch, Ruptures};
use clastic_components::increment::{Analysis, Avalanche, RuptureRules};
use clastic_components::material::{ContactLaw, Materials};
use clastic_components::release::{BondForce, Release};
use clastic_cone::program::{ConeProgram, Dof, Interaction};

use crate::assemble_program::interactions::{contact_law, shear_after_rupture};
use crate::assemble_program::{cell, groups};
use crate::detect_contacts::gaps::{pair_contact, wall_contact};
use crate::schedule::{Increment, IncrementSystems};
use crate::state::RegisterState;

/// Adds [`note_ruptures`] and [`begin_release`].
pub struct GradualReleasePlugin;

impl Plugin for GradualReleasePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Release>().register_resource::<Release>("release").add_systems(
            Increment,
            (
                begin_release
                    .in_set(IncrementSystems::Draft)
                    .before(crate::gather_bodies::draft_history),
                note_ruptures
                    .in_set(IncrementSystems::Rupture)
                    .after(crate::rupture_bonds::rupture_bonds),
            ),
        );
    }
}

/// Notes the share of the forces that still acts at the end of a committed increment, and the
/// forces of the bonds that broke. A collapse ends the release.
pub fn note_ruptures(
    rules: Res<RuptureRules>,
    search: Res<EventSearch>,
    ruptures: Res<Ruptures>,
    attempt: Res<Attempt>,
    mut release: ResMut<Release>,
) {
    if attempt.status == IncrementStatus::Collapsed {
        *release = Release::default();
        return;
    }
    if rules.avalanche != Avalanche::Gradual && !release.goes_on() {
        return;
    }
    // What a motion breaks it has released.
    let broken = ruptures.list.iter().skip(ruptures.on_the_way);
    let broken = broken.map(|r| BondForce { a: r.a, b: r.b, forces: [r.p, r.q, r.tau] });
    let broken = if search.active { broken.collect() } else { Vec::new() };
    release.end_increment(search.kept, broken);
}

/// Begins the increment with the forces that are not yet released. Contacts of bonds that broke at
/// the end of the last increment take their part of the force now.
pub fn begin_release(
    bodies: Res<Bodies>,
    materials: Res<Materials>,
    analysis: Res<Analysis>,
    mut history: ResMut<ContactHistory>,
    mut release: ResMut<Release>,
) {
    if !release.goes_on() && release.forces.is_empty() {
        return;
    }
    let first = release.begin_increment();
    for force in &mut release.forces[first..] {
        let Some(contact) = contact(&bodies, force) else { continue };
        let law = contact_law(&bodies, &materials, &analysis, &contact);
        let at = history.0.binary_search_by_key(&(contact.a, contact.b), |m| (m.a, m.b));
        // The shear force is that of the contact already, with the gap before the increment.
        let q = at.map_or(0.0, |k| history.0[k].q);
        let taken = taken([force.forces[0], q, force.forces[2]], &contact, &law, &bodies);
        for (force, taken) in force.forces.iter_mut().zip(taken) {
            *force -= taken;
        }
        if let Ok(k) = at {
            if taken[0] > 0.0 {
                let memory = &mut history.0[k];
                [memory.p, memory.q, memory.tau] = taken;
            } else {
                history.0.remove(k);
            }
        }
    }
}

/// Forces of a contact where the bond was that carried (p, q, tau).
fn taken([p, q, tau]: [f64; 3], contact: &Contact, law: &ContactLaw, bodies: &Bodies) -> [f64; 3] {
    let p = if law.normal_compliance > 0.0 {
        (-contact.gap / law.normal_compliance).max(0.0)
    } else if contact.gap <= 0.0 {
        p.max(0.0)
    } else {
        0.0
    };
    let moment = law.rolling_friction * contact.common_radius(bodies) * p;
    [p, shear_after_rupture(q, contact.gap, law), tau.clamp(-moment, moment)]
}

/// The pair as a contact, wherever its bodies are; `None` if one of them is gone.
fn contact(bodies: &Bodies, force: &BondForce) -> Option<Contact> {
    let (a, b) = (bodies.row(force.a)?, bodies.row(force.b)?);
    let (a, b) = (a as u32, b as u32);
    Some(match bodies.walls.binary_search_by_key(&b, |wall| wall.body) {
        Ok(k) => wall_contact(bodies, a, &bodies.walls[k]),
        Err(_) => pair_contact(bodies, a, b),
    })
}

/// The interaction that carries the force of a broken bond, in the rows of the program. It has no
/// law: its force is given.
#[must_use]
pub fn joint(bodies: &Bodies, force: &BondForce) -> Option<Interaction> {
    let contact = contact(bodies, force)?;
    let b = contact.b as usize;
    let half_gap = 0.5 * contact.gap;
    let mut joint = [Interaction {
        normal: contact.normal,
        arm_a: bodies.radii[contact.a as usize] + half_gap,
        arm_b: bodies.radii.get(b).map_or(0.0, |r| r + half_gap),
        ..Interaction::between(contact.a, contact.b)
    }];
    cell::set_images(bodies, &mut joint);
    if b >= bodies.particles && bodies.group(b).is_some() {
        let lever = contact.point(bodies) - bodies.positions[b];
        joint[0] = joint[0].carried_by(false, contact.b, lever);
    }
    groups::join(bodies, &mut joint);
    let [joint] = joint;
    Some(joint)
}

/// Adds the forces that are not yet released to the loads of the program.
pub fn add_loads(bodies: &Bodies, release: &Release, kept: f64, program: &mut ConeProgram) {
    if kept == 0.0 {
        return;
    }
    for force in &release.forces {
        let Some(c) = joint(bodies, force) else { continue };
        let of_bodies = [(c.a as usize, true), (c.b as usize, false)];
        let rows = of_bodies.map(|(i, first)| (i, c.rows(program.bodies[i].axis, first)));
        for (i, rows) in rows.into_iter().chain(program.rows_of_cell(&c)) {
            for (dof, row) in program.bodies[i].dofs.iter_mut().zip(rows) {
                if let Dof::Free(free) = dof {
                    free.load -= kept * dot(row, force.forces);
                }
            }
        }
    }
}

/// Work that a constant share 1 of the forces takes from the bodies in a solution, J.
#[must_use]
pub fn work(
    bodies: &Bodies,
    release: &Release,
    program: &ConeProgram,
    displacements: &[[f64; 3]],
) -> f64 {
    let work = |force: &BondForce| {
        let c = joint(bodies, force)?;
        Some(dot(program.kinematics(&c, displacements), force.forces))
    };
    release.forces.iter().filter_map(work).sum()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
