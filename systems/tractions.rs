//! Tractions on the surface of a part that is taken out of a specimen.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_cone::program::Interaction;

use crate::gather_bodies::gather_bodies;
use crate::measures::kept::kept_contacts;

/// A contact across the surface: the body that stays, and what acts on it: force (x, y; N) and moment
/// about its centre (N m).
type Traction = (BodyId, [f64; 3]);

/// Loads the particles beside the particles `gone` (ascending) with what these exert on them through
/// contacts and bonds: the forces of the last increment, in a time step their mean over it, along the
/// normals of now. Loads keep their directions.
pub fn keep_tractions(world: &mut World, gone: &[BodyId]) {
    let mut loads = BTreeMap::<BodyId, [f64; 3]>::new();
    for (body, traction) in tractions(world, gone) {
        let load = loads.entry(body).or_default();
        *load = std::array::from_fn(|k| load[k] + traction[k]);
    }
    let mut bodies = world.query::<(&BodyId, &mut LoadControl)>();
    for (body, mut control) in bodies.iter_mut(world) {
        for (value, load) in control.0.iter_mut().zip(loads.remove(body).unwrap_or_default()) {
            *value = (value.1 + load, value.1 + load);
        }
    }
}

/// The name of a membrane that presses on one of the particles `gone` (ascending): it would press on
/// what is behind them too.
pub fn membrane_on(world: &mut World, gone: &[BodyId]) -> Option<String> {
    let mut membranes = world.query::<(&Membrane, &MembraneShape)>();
    let is_gone = |id: &BodyId| gone.binary_search(id).is_ok();
    let presses = |shape: &MembraneShape| shape.chains.iter().any(|c| c.bodies.iter().any(is_gone));
    let names = membranes.iter(world).filter(|(_, shape)| presses(shape));
    names.map(|(membrane, _)| membrane.name.clone()).min()
}

/// The name of a wall beside the particles `gone` (ascending) that is not held: a load on it cannot take
/// the place of these particles.
pub fn loosened_wall(world: &mut World, gone: &[BodyId]) -> Option<String> {
    let touched = tractions(world, gone);
    let mut groups = world.query::<&RigidGroup>();
    let members: Vec<_> = groups.iter(world).flat_map(|group| group.members.clone()).collect();
    let mut walls = world.query::<(&BodyId, &WallName, &WallControl)>();
    let loosened = walls.iter(world).filter(|(id, _, control)| {
        let is_loaded = matches!(
            control,
            WallControl::Force { .. } | WallControl::Stress { .. } | WallControl::Custom
        );
        (is_loaded || members.contains(id)) && touched.iter().any(|(body, _)| body == *id)
    });
    loosened.min_by_key(|(id, ..)| **id).map(|(_, name, _)| name.0.clone())
}

fn tractions(world: &mut World, gone: &[BodyId]) -> Vec<Traction> {
    let _ = world.run_system_cached(gather_bodies);
    let (contacts, program, solution) = world.run_system_cached(kept_contacts).unwrap_or_default();
    let bodies = world.resource::<BodyTable>();
    let is_gone = |row: u32| gone.binary_search(&bodies.ids[row as usize]).is_ok();
    let is_bonded = |pair| bodies.bonds.binary_search_by_key(&pair, |b| (b.a, b.b)).is_ok();
    let forces = program.interactions.iter().zip(&solution.forces);
    let crossing = contacts.0.iter().zip(forces);
    // A bond that has just broken in tension carries nothing.
    let crossing = crossing.filter(|(c, (_, f))| {
        is_gone(c.a) != is_gone(c.b) && (f[0] >= 0.0 || is_bonded((c.a, c.b)))
    });
    let on_the_rest = |(contact, (c, f)): (&Contact, (&Interaction, &[f64; 3]))| {
        let Contact { a, b, normal, gap, .. } = *contact;
        // The second body is pushed along the normal.
        let (row, sign) = if is_gone(a) { (b, 1.0) } else { (a, -1.0) };
        let force = sign * c.force(f);
        let radius = bodies.radii.get(row as usize).map_or(0.0, |radius| radius + 0.5 * gap);
        let moment = (-sign * radius * normal).perp_dot(force) + sign * f[2];
        (bodies.ids[row as usize], [force.x, force.y, moment])
    };
    crossing.map(on_the_rest).collect()
}
