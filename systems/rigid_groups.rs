//! Rigid groups in the tables of an increment. The members follow their group by finite rotations,
//! in every trial and when it is committed.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, ConeSolution};

/// What the row of a rigid group follows from, besides its members.
pub(crate) type GroupData = (
    Entity,
    &'static BodyId,
    &'static RigidGroup,
    &'static BodyPosition,
    &'static LastMotion,
    &'static BodyDrives,
    &'static AppliedLoad,
);

/// Adds the rows of the groups, which follow from those of the particles and walls. The state of motion of a group follows
/// from its members: their centre of mass, and a velocity and spin with their linear and angular
/// momentum.
pub fn gather(bodies: &mut BodyTable, groups: &Query<GroupData>) {
    let first_group = bodies.ids.len();
    if !groups.is_empty() {
        bodies.group_of.resize(first_group, None);
    }
    let mut sorted: Vec<_> = groups.iter().collect();
    sorted.sort_unstable_by_key(|group| *group.1);
    for (index, (entity, id, group, position, motion, drives, load)) in
        sorted.into_iter().enumerate()
    {
        bodies.names.insert(bodies.ids.len() as u32, group.name.clone());
        let mut members: Vec<u32> = group
            .members
            .iter()
            .filter_map(|member| bodies.row(*member))
            .filter(|member| *member < first_group)
            .map(|member| member as u32)
            .collect();
        // Poured particles have identities after those of walls.
        members.sort_unstable();
        for &member in &members {
            bodies.group_of[member as usize].get_or_insert(index as u32);
        }
        let about = group.has_pivot.then_some(position.0);
        let member = |i: usize| Member {
            mass: bodies.masses[i],
            inertia: bodies.inertias[i],
            radius: bodies.radii[i],
            position: bodies.positions[i],
            velocity: bodies.velocities[i],
            spin: bodies.angular_velocities[i],
        };
        let particles = members.iter().map(|i| *i as usize).filter(|i| *i < bodies.particles);
        let mut state = State::of(particles.map(member), about);
        for wall in bodies.walls.iter().filter(|wall| members.binary_search(&wall.body).is_ok()) {
            let place = bodies.positions[wall.body as usize];
            state.extent = state.extent.max(place.distance(state.centre) + wall.extent());
        }
        bodies.groups.push(GroupRow {
            body: bodies.ids.len() as u32,
            members,
            mass: state.mass,
            inertia: state.inertia,
            extent: state.extent,
            drives: drives.0,
            loads: load.ramps(),
        });
        bodies.ids.push(*id);
        bodies.entities.push(entity);
        bodies.positions.push(state.centre);
        bodies.velocities.push(state.velocity);
        bodies.angular_velocities.push(state.spin);
        bodies.last_motion.push(motion.0);
    }
}

/// A member of a group.
#[derive(Clone, Copy, Debug)]
pub struct Member {
    /// Mass, kg.
    pub mass: f64,
    /// Moment of inertia about its centre, kg m^2.
    pub inertia: f64,
    /// Radius, m.
    pub radius: f64,
    /// Centre, m.
    pub position: DVec2,
    /// Velocity, m/s.
    pub velocity: DVec2,
    /// Angular velocity, rad/s.
    pub spin: f64,
}

/// Mass and motion of a group.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// Its centre, m.
    pub centre: DVec2,
    /// Mass, kg.
    pub mass: f64,
    /// Moment of inertia about the centre, kg m^2.
    pub inertia: f64,
    /// Maximum distance of a member's centre from the centre, m.
    pub extent: f64,
    /// Velocity of the centre, m/s.
    pub velocity: DVec2,
    /// Angular velocity, rad/s.
    pub spin: f64,
}

impl State {
    /// Mass and motion about a pivot, or about the centre of mass. Velocity and spin have the
    /// linear momentum of the members and their angular momentum about the centre of mass.
    pub fn of(members: impl Iterator<Item = Member> + Clone, about: Option<DVec2>) -> Self {
        let mass: f64 = members.clone().map(|m| m.mass).sum();
        // Particles without mass count alike.
        let weight = |m: &Member| if mass > 0.0 { m.mass } else { 1.0 };
        let own = |m: &Member| if mass > 0.0 { m.inertia } else { m.radius * m.radius };
        let total: f64 = members.clone().map(|m| weight(&m)).sum::<f64>().max(f64::MIN_POSITIVE);
        let middle = members.clone().map(|m| weight(&m) * m.position).sum::<DVec2>() / total;
        let velocity = members.clone().map(|m| weight(&m) * m.velocity).sum::<DVec2>() / total;
        let (mut momentum, mut inertia) = (0.0, 0.0);
        for m in members.clone() {
            let lever = m.position - middle;
            momentum += weight(&m) * lever.perp_dot(m.velocity - velocity) + own(&m) * m.spin;
            inertia += weight(&m) * lever.length_squared() + own(&m);
        }
        let spin = if inertia > 0.0 { momentum / inertia } else { 0.0 };
        let centre = about.unwrap_or(middle);
        let arm = centre - middle;
        Self {
            centre,
            mass,
            inertia: if mass > 0.0 { inertia + mass * arm.length_squared() } else { 0.0 },
            extent: members.map(|m| m.position.distance(centre)).fold(0.0, f64::max),
            velocity: velocity + spin * arm.perp(),
            spin,
        }
    }
}

/// Run condition: there are rigid groups.
pub(crate) fn has_groups(bodies: Res<BodyTable>) -> bool {
    !bodies.groups.is_empty()
}

/// Writes the displacements of members into the solution of the program, which has those of the
/// groups. A mechanism is a motion to first order.
pub(crate) fn carry_members(
    bodies: Res<BodyTable>,
    program: Res<ConeProgram>,
    mut solution: ResMut<ConeSolution>,
) {
    if solution.displacements.len() == program.bodies.len() {
        carry(&bodies, &mut solution.displacements);
    }
    if let Some(certificate) = &mut solution.certificate
        && certificate.mechanism.len() == program.bodies.len()
    {
        for group in &bodies.groups {
            let u = certificate.mechanism[group.body as usize];
            for i in group.members.iter().map(|i| *i as usize) {
                certificate.mechanism[i] = GroupRow::carried_linearly(u, bodies.lever(group, i));
            }
        }
    }
}

/// Sets the displacements of members to those that follow from the displacements of their groups.
pub fn carry(bodies: &BodyTable, displacements: &mut [[f64; 3]]) {
    for group in &bodies.groups {
        let u = displacements[group.body as usize];
        for i in group.members.iter().map(|i| *i as usize) {
            displacements[i] = GroupRow::carried(u, bodies.lever(group, i));
        }
    }
}
