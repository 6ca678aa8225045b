//! Stresses between increments, from the forces that contacts and walls keep.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::body::{BodyId, LastMotion};
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::contact_history::{ContactHistory, KeptRows};
use clastic_components::membrane::{Membrane, MembraneShape};
use clastic_components::observation::Measures;
use clastic_cone::program::ConeSolution;

use super::stress::StressTables;
use crate::detect_contacts::gaps::{pair_contact, wall_contact};
use crate::gather_bodies::gather_bodies;

/// Axial and lateral stress of the forces that contacts and walls keep, Pa, as the last increment had
/// them: on lengths and branches at its start, but for those of a periodic cell or a membrane, which
/// are as they are now. `None` where a stress is not measured or one of its bodies is not there. The
/// world is left as it was.
pub fn kept_stresses(world: &mut World) -> [Option<f64>; 2] {
    let _ = world.run_system_cached(gather_bodies);
    let _ = world.run_system_cached(go_back);
    let mut membranes = world.query::<(&Membrane, &mut MembraneShape)>();
    for (membrane, mut shape) in membranes.iter_mut(world) {
        // At the start of a stage the pressure is the one that the stages before have reached.
        shape.pressure = membrane.pressure.0;
    }
    let (contacts, solution) = world.run_system_cached(kept_contacts).unwrap_or_default();
    let contacts = std::mem::replace(&mut *world.resource_mut::<Contacts>(), contacts);
    let solution = std::mem::replace(&mut *world.resource_mut::<ConeSolution>(), solution);
    let stresses = world.run_system_cached(read).unwrap_or_default();
    *world.resource_mut::<Contacts>() = contacts;
    *world.resource_mut::<ConeSolution>() = solution;
    let _ = world.run_system_cached(gather_bodies);
    stresses
}

/// Brings the bodies of the tables to where the last increment began.
fn go_back(mut bodies: ResMut<Bodies>, motions: Query<(&BodyId, &LastMotion)>) {
    if bodies.cell.is_some() {
        return;
    }
    for (id, LastMotion([x, y, _])) in &motions {
        if let Some(row) = bodies.row(*id) {
            bodies.positions[row] -= DVec2::new(*x, *y);
        }
    }
}

/// The contacts whose forces are kept, and these forces. One with a body that is gone is left out.
fn kept_contacts(
    bodies: Res<Bodies>,
    kept: Res<KeptRows>,
    history: Res<ContactHistory>,
) -> (Contacts, ConeSolution) {
    let row = |row: u32| Some(bodies.row(*kept.ids.get(row as usize)?)? as u32);
    let (mut contacts, mut solution) = (Contacts::default(), ConeSolution::default());
    for memory in &history.0 {
        let (Some(a), Some(b)) = (row(memory.a), row(memory.b)) else { continue };
        contacts.0.push(match bodies.walls.iter().find(|wall| wall.body == b) {
            Some(wall) => wall_contact(&bodies, a, wall),
            None => pair_contact(&bodies, a, b),
        });
        solution.forces.push([memory.p, memory.q, memory.tau]);
    }
    (contacts, solution)
}

fn read(tables: StressTables, measures: Res<Measures>) -> [Option<f64>; 2] {
    [&measures.axial_stress, &measures.lateral_stress]
        .map(|measure| tables.stress_now(measure.as_ref()?))
}
