//! Gathers bodies, intact bonds, controls and the memory of contacts into tables by identity.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use crate::check_values::check_values;
use crate::links;
use crate::passing_walls::refuse_passing_walls;
use crate::rigid_groups::{self, GroupData};
use crate::schedule::{ClasticHalted, Increment, IncrementSystems};
use crate::state::RegisterState;

/// Name of the [`PeriodicCell`] in a state.
pub const PERIODIC_CELL: &str = "periodic_cell";

/// Adds [`gather_bodies`] and [`draft_history`].
pub struct GatherBodiesPlugin;

impl Plugin for GatherBodiesPlugin {
    fn build(&self, app: &mut App) {
        register_bodies(app);
        app.init_resource::<BodyTable>()
            .init_resource::<KeptRows>()
            .init_resource::<ContactHistory>()
            .init_resource::<DraftHistory>()
            .add_systems(
                Increment,
                (
                    (
                        gather_bodies,
                        refuse_small_cells,
                        refuse_passing_walls,
                        check_values,
                        follow_rows.run_if(not(resource_exists::<ClasticHalted>)),
                    )
                        .chain()
                        .in_set(IncrementSystems::Gather),
                    renumber_contacts.in_set(IncrementSystems::Renumber),
                    draft_history.in_set(IncrementSystems::Draft),
                ),
            );
    }
}

/// Registers the persistent state of bodies and bonds.
fn register_bodies(app: &mut App) {
    app.register_component::<BodyId, Particle>("particle")
        .register_component::<BodyId, Wall>("wall")
        .register_component::<BodyId, WallShape>("wall_shape")
        .register_component::<BodyId, BodyPosition>("position")
        .register_component::<BodyId, BodyOrigin>("origin")
        .register_component::<BodyId, BodyRotation>("rotation")
        .register_component::<BodyId, BodyVelocity>("velocity")
        .register_component::<BodyId, BodyAngularVelocity>("angular_velocity")
        .register_component::<BodyId, LastMotion>("last_motion")
        .register_component::<BodyId, MaterialIndex>("material")
        .register_component::<BodyId, ContactLaw>("contact_law")
        .register_component::<BodyId, BodyDrives>("drives")
        .register_component::<BodyId, AppliedLoad>("applied_load")
        .register_component::<BodyId, SetAside>("set_aside")
        .register_component::<BodyId, BodyExternalForce>("external_force")
        .register_component::<BodyId, RigidGroup>("rigid_group")
        .register_component::<BodyId, ContactForce>("contact_force")
        .register_component::<BondId, Bond>("bond")
        .register_component::<BondId, BondState>("bond_state")
        .register_resource::<PeriodicCell>(PERIODIC_CELL)
        // The identities behind the rows of persistent tables.
        .register_part(
            "contact_history.rows",
            |world| world.get_resource::<KeptRows>().map(|kept| kept.ids.clone()),
            |ids, world| world.insert_resource(KeptRows::of(ids)),
        )
        .register_resource::<ContactHistory>("contact_history");
}

type ParticleData = (
    Entity,
    &'static BodyId,
    &'static Particle,
    &'static BodyPosition,
    &'static BodyRotation,
    &'static BodyVelocity,
    &'static BodyAngularVelocity,
    &'static LastMotion,
    &'static MaterialIndex,
    &'static BodyDrives,
    &'static AppliedLoad,
    Has<SetAside>,
);

type WallData = (
    Entity,
    &'static BodyId,
    &'static Wall,
    &'static BodyPosition,
    &'static LastMotion,
    &'static ContactLaw,
    &'static WallControl,
    &'static WallDrive,
    Option<&'static WallShape>,
    Option<&'static WallRotation>,
    Option<&'static WallName>,
);

/// A bond with its identity and its state.
pub(crate) type BondData = (Entity, &'static BondId, &'static Bond, &'static BondState);

/// Fills [`BodyTable`] with one row per body: particles by identity, then walls by identity, then
/// rigid groups by identity.
///
/// A bond with a missing body has no row, nor has one between members of a rigid group.
pub fn gather_bodies(
    mut bodies: ResMut<BodyTable>,
    particles: Query<ParticleData>,
    walls: Query<WallData>,
    groups: Query<GroupData>,
    bonds: Query<BondData>,
    links: Query<(Entity, &Link)>,
    cell: Option<Res<PeriodicCell>>,
) {
    let bodies = &mut *bodies;
    *bodies = BodyTable { cell: cell.map(|cell| *cell), ..BodyTable::default() };
    gather_particles(bodies, &particles);
    gather_walls(bodies, &walls);
    rigid_groups::gather(bodies, &groups);
    bodies.links = links::gather(bodies, &links);
    bodies.bonds = gather_bonds(bodies, &bonds);
}

fn gather_particles(bodies: &mut BodyTable, particles: &Query<ParticleData>) {
    let mut sorted: Vec<_> = particles.iter().collect();
    sorted.sort_unstable_by_key(|row| *row.1);
    for (entity, id, disk, x, turned, v, spin, motion, material, drives, load, aside) in sorted {
        bodies.ids.push(*id);
        bodies.entities.push(entity);
        bodies.positions.push(x.0);
        bodies.rotations.push(turned.0);
        bodies.velocities.push(v.0);
        bodies.angular_velocities.push(spin.0);
        bodies.last_motion.push(motion.0);
        bodies.radii.push(disk.radius);
        bodies.masses.push(disk.mass);
        bodies.inertias.push(disk.inertia);
        bodies.materials.push(material.0);
        bodies.drives.push(drives.0);
        bodies.loads.push(load.ramps());
        bodies.set_aside.push(aside);
    }
    let n = bodies.ids.len();
    bodies.particles = n;
    bodies.mean_radius = if n == 0 { 1.0 } else { bodies.radii.iter().sum::<f64>() / n as f64 };
}

fn gather_walls(bodies: &mut BodyTable, walls: &Query<WallData>) {
    let mut sorted: Vec<_> = walls.iter().collect();
    sorted.sort_unstable_by_key(|row| *row.1);
    for (entity, id, wall, position, motion, law, control, drive, shape, rotation, name) in sorted {
        if let Some(WallName(name)) = name {
            bodies.names.insert(bodies.ids.len() as u32, name.clone());
        }
        bodies.walls.push(WallRow {
            body: bodies.ids.len() as u32,
            inward: wall.inward(),
            half_length: wall.half_length,
            shape: shape.copied().unwrap_or_default(),
            law: *law,
            control: *control,
            drive: *drive,
        });
        bodies.ids.push(*id);
        bodies.entities.push(entity);
        bodies.positions.push(position.0);
        bodies.rotations.push(rotation.map_or(0.0, |rotation| rotation.0));
        // Only particles have a velocity in the tables.
        bodies.velocities.push(DVec2::ZERO);
        bodies.angular_velocities.push(0.0);
        bodies.last_motion.push(motion.0);
    }
}

/// The intact bonds between bodies that can move relative to each other.
fn gather_bonds(bodies: &BodyTable, bonds: &Query<BondData>) -> Vec<BondRow> {
    let row = |id: BodyId| bodies.row(id).map(|row| row as u32);
    let intact = bonds.iter().filter(|(.., state)| **state == BondState::Intact);
    let rows = intact.filter_map(|(entity, id, bond, _)| {
        let (a, b) = (row(bond.a)?, row(bond.b)?);
        let (a, b) = (a.min(b), a.max(b));
        let gathered =
            BondRow { id: *id, entity, a, b, initial_gap: bond.initial_gap, law: bond.law };
        (!bodies.are_joined(a, b)).then_some(gathered)
    });
    let mut rows: Vec<BondRow> = rows.collect();
    rows.sort_unstable_by_key(|b| (b.a, b.b, b.id));
    rows
}

/// Halts a run in whose periodic cell two particles could touch twice.
fn refuse_small_cells(bodies: Res<BodyTable>, mut commands: Commands) {
    let Some(cell) = &bodies.cell else { return };
    let largest = bodies.radii.iter().copied().fold(0.0, f64::max);
    if cell.max_branch() < MIN_CELL * 2.0 * largest {
        commands.insert_resource(ClasticHalted(format!(
            "the periodic cell is {:.4e} m wide and {:.4e} m high, less than {} times the maximum \
             diameter: two particles could touch twice; begin with a larger cell and more particles",
            cell.width,
            cell.height,
            2.0 * MIN_CELL
        )));
    }
}

/// Minimum of the maximum length of a contact in a periodic cell, in maximum diameters: contacts
/// are found a quarter of a diameter before they close.
const MIN_CELL: f64 = 1.25;

/// Records the new rows of persistent tables.
pub(crate) fn follow_rows(bodies: Res<BodyTable>, mut kept: ResMut<KeptRows>) {
    if kept.ids != bodies.ids || kept.is_needed() || kept.has_changed() {
        kept.follow(&bodies);
    }
}

fn renumber_contacts(rows: Res<KeptRows>, mut history: ResMut<ContactHistory>) {
    history.renumber(&rows);
}

/// Sets the draft of the contact memory to the memory after the last increment.
pub fn draft_history(history: Res<ContactHistory>, mut draft: ResMut<DraftHistory>) {
    draft.0.clone_from(&history);
}
