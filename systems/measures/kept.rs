//! Readings between increments, from the places of bodies and the forces that contacts and walls
//! keep. They follow from what a saved state has.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, ConeSolution, Interaction};

use super::EndTables;
use super::stress::StressTables;
use crate::detect_contacts::gaps::{pair_contact, wall_contact};
use crate::gather_bodies::gather_bodies;

/// Axial and lateral stress of the forces that contacts and walls keep, Pa, as the last increment
/// had them: on lengths and branches at its start, but for those of a periodic cell or a membrane,
/// which are as they are now. `None` where a stress is not measured or one of its bodies is not
/// there. The world is left as it was.
pub fn kept_stresses(world: &mut World) -> [Option<f64>; 2] {
    with_kept_forces(world, |world| world.run_system_cached(read).unwrap_or_default())
}

/// Reading of a measure of the state between two increments, as the last increment had it but for
/// round-off. `reference` is the distance to which a strain refers, m. `None` where it is not
/// defined, and for a measure that needs the solution or the counts of an increment.
pub fn kept_reading(world: &mut World, quantity: &Quantity, reference: Option<f64>) -> Option<f64> {
    let asked = (quantity.clone(), reference);
    match quantity {
        Quantity::Stress(_) | Quantity::GroupForce { .. } => with_kept_forces(world, |world| {
            world.run_system_cached_with(read_force, asked.0).ok().flatten()
        }),
        Quantity::Strain(_)
        | Quantity::Porosity(_)
        | Quantity::Fragments(_)
        | Quantity::Cracks { .. }
        | Quantity::WallForce { .. }
        | Quantity::Membrane { .. }
        | Quantity::Grains { .. }
        | Quantity::Front { .. }
        | Quantity::Ring { .. }
        | Quantity::Poured(_) => {
            let _ = world.run_system_cached(gather_bodies);
            world.run_system_cached_with(read_place, asked).ok().flatten()
        }
        Quantity::KineticEnergy => {
            let mut moving = world.query::<Moving>();
            Some(kinetic_energy(moving.iter(world)))
        }
        _ => None,
    }
}

/// What the kinetic energy of a particle depends on.
pub type Moving =
    (&'static BodyId, &'static Particle, &'static BodyVelocity, &'static BodyAngularVelocity);

/// Kinetic energy of the particles, J. The sum runs in the order of identities, because it depends
/// on the order and query order may vary.
pub fn kinetic_energy<'a>(
    moving: impl Iterator<Item = (&'a BodyId, &'a Particle, &'a BodyVelocity, &'a BodyAngularVelocity)>,
) -> f64 {
    let mut energy: Vec<(BodyId, f64)> = moving
        .map(|(id, p, v, w)| (*id, 0.5 * (p.mass * v.0.length_squared() + p.inertia * w.0 * w.0)))
        .collect();
    energy.sort_unstable_by_key(|(id, _)| *id);
    energy.iter().map(|(_, e)| e).sum()
}

/// Runs something with the tables of the contacts whose forces are kept.
fn with_kept_forces<T>(world: &mut World, then: impl FnOnce(&mut World) -> T) -> T {
    let _ = world.run_system_cached(gather_bodies);
    let _ = world.run_system_cached(go_back);
    let mut membranes = world.query::<(&Membrane, &mut MembraneShape)>();
    for (membrane, mut shape) in membranes.iter_mut(world) {
        // At the start of a stage the pressure is the one that the stages before have reached.
        shape.pressure = membrane.pressure.0;
    }
    let (mut contacts, mut program, mut solution) =
        world.run_system_cached(kept_contacts).unwrap_or_default();
    let mut exchange = |world: &mut World| {
        std::mem::swap(&mut *world.resource_mut::<ContactTable>(), &mut contacts);
        std::mem::swap(&mut *world.resource_mut::<ConeProgram>(), &mut program);
        std::mem::swap(&mut *world.resource_mut::<ConeSolution>(), &mut solution);
    };
    exchange(world);
    let found = then(world);
    exchange(world);
    let _ = world.run_system_cached(gather_bodies);
    found
}

/// Brings the bodies of the tables to where the last increment began.
fn go_back(mut bodies: ResMut<BodyTable>, motions: Query<(&BodyId, &LastMotion)>) {
    if bodies.cell.is_some() {
        return;
    }
    for (id, LastMotion([x, y, _])) in &motions {
        if let Some(row) = bodies.row(*id) {
            bodies.positions[row] -= DVec2::new(*x, *y);
        }
    }
}

/// The contacts whose forces are kept, a program with their normals, and these forces. One with a
/// body that is gone is left out.
pub(crate) fn kept_contacts(
    bodies: Res<BodyTable>,
    kept: Res<KeptRows>,
    history: Res<ContactHistory>,
) -> (ContactTable, ConeProgram, ConeSolution) {
    let row = |row: u32| Some(bodies.row(*kept.ids.get(row as usize)?)? as u32);
    let (mut contacts, mut program, mut solution) =
        (ContactTable::default(), ConeProgram::default(), ConeSolution::default());
    for memory in &history.0 {
        let (Some(a), Some(b)) = (row(memory.a), row(memory.b)) else { continue };
        let contact = match bodies.wall(b) {
            Some(wall) => wall_contact(&bodies, a, wall),
            None => pair_contact(&bodies, a, b),
        };
        contacts.0.push(contact);
        let normal = contact.normal;
        program.interactions.push(Interaction { normal, ..Interaction::between(a, b) });
        solution.forces.push([memory.p, memory.q, memory.tau]);
    }
    (contacts, program, solution)
}

fn read(tables: StressTables, measures: Res<Measures>) -> [Option<f64>; 2] {
    [&measures.axial_stress, &measures.lateral_stress]
        .map(|measure| tables.stress_now(measure.as_ref()?))
}

fn read_force(In(quantity): In<Quantity>, tables: StressTables) -> Option<f64> {
    tables.reading_now(&quantity)
}

fn read_place(
    In((quantity, reference)): In<(Quantity, Option<f64>)>,
    tables: EndTables,
) -> Option<f64> {
    tables.read(&quantity, reference)
}
