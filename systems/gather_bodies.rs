//! Gathers bodies, intact bonds, controls and the memory of contacts into tables by identity.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use clastic_components::body::{
    AppliedLoad, BodyAngularVelocity, BodyDrives, BodyExternalForce, BodyId, BodyOrigin,
    BodyPosition, BodyRotation, BodyVelocity, LastMotion,
};
use clastic_components::bond::{Bond, BondId, BondState};
use clastic_components::cell::PeriodicCell;
use clastic_components::contact::{BodyTable, BondRow, WallRow};
use clastic_components::contact_history::{ContactHistory, DraftHistory, KeptRows};
use clastic_components::link::Link;
use clastic_components::material::ContactLaw;
use clastic_components::particle::{MaterialIndex, Particle, SetAside};
use clastic_components::rigid_group::{ContactForce, RigidGroup};
use clastic_components::wall::{Wall, WallControl, WallDrive, WallRotation};
use clastic_components::wall_shape::WallShape;

use crate::check_values::check_values;
use crate::links;
use crate::rigid_groups::{self, GroupQuery};
use crate::schedule::{ClasticHalted, Increment, IncrementSystems};
use crate::state::{RegisterState, StateOf};

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
        .register_state::<RowIds>("contact_history.rows")
        .register_resource::<ContactHistory>("contact_history");
}

/// The identities behind the rows of persistent tables.
#[derive(Serialize, Deserialize)]
struct RowIds(Vec<BodyId>);

impl StateOf for RowIds {
    fn take(world: &mut World) -> Option<Self> {
        world.get_resource::<KeptRows>().map(|kept| Self(kept.ids.clone()))
    }

    fn put(self, world: &mut World) {
        world.insert_resource(KeptRows::of(self.0));
    }
}

type ParticleQuery<'w, 's> = Query<
    'w,
    's,
    (
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
    ),
>;

type WallQuery<'w, 's> = Query<
    'w,
    's,
    (
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
    ),
>;

type BondQuery<'w, 's> =
    Query<'w, 's, (Entity, &'static BondId, &'static Bond, &'static BondState)>;

/// Fills [`BodyTable`] with one row per body: particles by identity, then walls by identity, then
/// rigid groups by identity.
///
/// A bond with a missing body has no row, nor has one between members of a rigid group.
pub fn gather_bodies(
    mut bodies: ResMut<BodyTable>,
    particles: ParticleQuery,
    walls: WallQuery,
    groups: GroupQuery,
    bonds: BondQuery,
    links: Query<(Entity, &Link)>,
    cell: Option<Res<PeriodicCell>>,
) {
    let bodies = &mut *bodies;
    number_rows(bodies, &particles, &walls, &groups);
    gather_particles(bodies, &particles);
    gather_walls(bodies, &walls);
    rigid_groups::gather(bodies, &groups);
    bodies.cell = cell.map(|cell| *cell);
    links::gather(bodies, &links);
    bodies.broken.clear();
    bodies.drives_stopped = false;
    gather_bonds(bodies, &bonds);
}

/// Sets the order of the rows and the lengths of the tables.
fn number_rows(
    bodies: &mut BodyTable,
    particles: &ParticleQuery,
    walls: &WallQuery,
    groups: &GroupQuery,
) {
    let n = particles.iter().len();
    let mut ids: Vec<BodyId> = particles.iter().map(|p| *p.1).collect();
    ids.sort_unstable();
    ids.extend(walls.iter().map(|w| *w.1));
    ids[n..].sort_unstable();
    let first_group = ids.len();
    ids.extend(groups.iter().map(|group| *group.1));
    ids[first_group..].sort_unstable();
    let all = ids.len();
    bodies.group_count = all - first_group;
    bodies.particles = n;
    bodies.ids = ids;
    bodies.entities.resize(all, Entity::PLACEHOLDER);
    bodies.positions.resize(all, DVec2::ZERO);
    bodies.rotations.resize(first_group, 0.0);
    bodies.velocities.resize(all, DVec2::ZERO);
    bodies.angular_velocities.resize(all, 0.0);
    bodies.last_motion.resize(all, [0.0; 3]);
    bodies.radii.resize(n, 0.0);
    bodies.masses.resize(n, 0.0);
    bodies.inertias.resize(n, 0.0);
    bodies.materials.resize(n, 0);
    bodies.drives.resize(n, Default::default());
    bodies.loads.resize(n, Default::default());
    bodies.set_aside.resize(n, false);
}

fn gather_particles(bodies: &mut BodyTable, particles: &ParticleQuery) {
    for (
        entity,
        id,
        particle,
        position,
        rotation,
        velocity,
        spin,
        motion,
        material,
        drives,
        load,
        set_aside,
    ) in particles
    {
        let Some(i) = bodies.row(*id) else { continue };
        bodies.entities[i] = entity;
        bodies.positions[i] = position.0;
        bodies.rotations[i] = rotation.0;
        bodies.velocities[i] = velocity.0;
        bodies.angular_velocities[i] = spin.0;
        bodies.last_motion[i] = motion.0;
        bodies.radii[i] = particle.radius;
        bodies.masses[i] = particle.mass;
        bodies.inertias[i] = particle.inertia;
        bodies.materials[i] = material.0;
        bodies.drives[i] = drives.0;
        bodies.loads[i] = load.ramps();
        bodies.set_aside[i] = set_aside;
    }
    let n = bodies.particles;
    bodies.mean_radius = if n == 0 { 1.0 } else { bodies.radii.iter().sum::<f64>() / n as f64 };
}

fn gather_walls(bodies: &mut BodyTable, walls: &WallQuery) {
    bodies.walls.clear();
    for (entity, id, wall, position, motion, law, control, drive, shape, rotation) in walls {
        let Some(i) = bodies.row(*id) else { continue };
        bodies.entities[i] = entity;
        bodies.positions[i] = position.0;
        bodies.rotations[i] = rotation.map_or(0.0, |rotation| rotation.0);
        // Only particles have a velocity in the tables.
        bodies.velocities[i] = DVec2::ZERO;
        bodies.angular_velocities[i] = 0.0;
        bodies.last_motion[i] = motion.0;
        bodies.walls.push(WallRow {
            body: i as u32,
            inward: wall.inward(),
            half_length: wall.half_length,
            shape: shape.copied().unwrap_or_default(),
            law: *law,
            control: *control,
            drive: *drive,
        });
    }
    bodies.walls.sort_unstable_by_key(|w| w.body);
}

/// Gathers the intact bonds between bodies that can move relative to each other.
fn gather_bonds(bodies: &mut BodyTable, bonds: &BondQuery) {
    let mut rows = std::mem::take(&mut bodies.bonds);
    rows.clear();
    let row = |id: BodyId| bodies.row(id).map(|row| row as u32);
    rows.extend(bonds.iter().filter(|(.., state)| **state == BondState::Intact).filter_map(
        |(entity, id, bond, _)| {
            let (a, b) = (row(bond.a)?, row(bond.b)?);
            let (a, b) = (a.min(b), a.max(b));
            if bodies.are_joined(a, b) {
                return None;
            }
            Some(BondRow { id: *id, entity, a, b, initial_gap: bond.initial_gap, law: bond.law })
        },
    ));
    bodies.bonds = rows;
    bodies.bonds.sort_unstable_by_key(|b| (b.a, b.b, b.id));
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
pub fn follow_rows(bodies: Res<BodyTable>, mut kept: ResMut<KeptRows>) {
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
