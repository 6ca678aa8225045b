//! Tables of bodies and potential contacts.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use glam::DVec2;

use crate::body::{BodyDrive, BodyId, Ramp};
use crate::bond::BondId;
use crate::cell::PeriodicCell;
use crate::link::LinkRow;
use crate::rigid_group::GroupRow;
pub use crate::rows::{BondRow, WallRow};
use crate::wall::WallDrive;

/// Bodies, intact bonds and controls in the order of identities, so that results do not depend on
/// the order of a query. Tables by body have `particles + walls + groups` entries.
///
/// The table is gathered once per increment. The trials of the increment read it. Each step of a
/// followed motion changes it. Entities keep the last committed state until a trial is committed.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct BodyTable {
    /// Number of particles; the rows of walls begin here.
    pub particles: usize,
    /// Identity of every body, ascending among particles and among walls.
    pub ids: Vec<BodyId>,
    /// Entity of every body.
    pub entities: Vec<Entity>,
    /// Names of walls and rigid groups, by row.
    pub names: BTreeMap<u32, String>,
    /// Centres of particles and middles of walls, m.
    pub positions: Vec<DVec2>,
    /// Rotations of particles and walls since the start, rad.
    pub rotations: Vec<f64>,
    /// Velocities, m/s.
    pub velocities: Vec<DVec2>,
    /// Angular velocities, rad/s.
    pub angular_velocities: Vec<f64>,
    /// Motion of the last committed increment, (m, m, rad).
    pub last_motion: Vec<[f64; 3]>,
    /// Radii of the particles, m.
    pub radii: Vec<f64>,
    /// Masses of the particles, kg.
    pub masses: Vec<f64>,
    /// Moments of inertia of the particles, kg m^2.
    pub inertias: Vec<f64>,
    /// Material indices of the particles.
    pub materials: Vec<u32>,
    /// Drives of the particles.
    pub drives: Vec<[BodyDrive; 3]>,
    /// Applied loads of the particles.
    pub loads: Vec<[Ramp; 3]>,
    /// Particles that are [set aside](crate::particle::SetAside).
    pub set_aside: Vec<bool>,
    /// The walls of the world, in the order of identities.
    pub walls: Vec<WallRow>,
    /// The rigid groups, in the order of identities; their rows follow those of the walls.
    pub groups: Vec<GroupRow>,
    /// Index in `groups` of the group of every particle and wall; empty without groups.
    pub group_of: Vec<Option<u32>>,
    /// The intact bonds, by (a, b). A bond within a rigid group has no row.
    pub bonds: Vec<BondRow>,
    /// The bonds that a motion has broken in this increment, in the order in which they broke.
    pub broken: Vec<BondRow>,
    /// The links, by the rows of their bodies and their points.
    pub links: Vec<LinkRow>,
    /// Mean radius of the particles, m; 1 without particles.
    pub mean_radius: f64,
    /// The periodic cell of the specimen, if it is in one. In the program its row follows those of
    /// all bodies.
    pub cell: Option<PeriodicCell>,
    /// Whether imposed motions stand still in the trial, because a step of a followed motion has
    /// made them or because a rupture released the motion. Loads then have their values at the end
    /// of the trial.
    pub drives_stopped: bool,
}

impl BodyTable {
    /// Name of a body in messages: its kind and its identity.
    pub fn name(&self, row: usize) -> String {
        match row.checked_sub(self.particles) {
            _ if row >= self.ids.len() => "the periodic cell".to_owned(),
            None => format!("particle {}", self.ids[row].0),
            Some(_) => {
                let kind = if row < self.first_group() { "wall" } else { "rigid group" };
                match self.names.get(&(row as u32)) {
                    Some(name) => format!("{kind} `{name}`"),
                    None => format!("{kind} (body {})", self.ids[row].0),
                }
            }
        }
    }

    /// Shift of that image of particle b which particle a may touch, m; zero without a cell.
    pub fn shift(&self, a: usize, b: usize) -> DVec2 {
        let apart = || self.positions[b] - self.positions[a];
        self.cell.as_ref().map_or(DVec2::ZERO, |cell| cell.shift(apart()))
    }

    /// Vector from particle a to the nearest image of particle b, m.
    pub fn way(&self, a: usize, b: usize) -> DVec2 {
        let apart = self.positions[b] - self.positions[a];
        self.cell.as_ref().map_or(apart, |cell| apart + cell.shift(apart))
    }

    /// Where the rows of rigid groups begin.
    pub fn first_group(&self) -> usize {
        self.ids.len() - self.groups.len()
    }

    /// Number of rows in the program.
    pub fn rows_in_program(&self) -> usize {
        self.positions.len() + usize::from(self.cell.is_some())
    }

    /// The row of a body; `None` if it is not in the table.
    pub fn row(&self, id: BodyId) -> Option<usize> {
        // If identities have no gap, the identity is the row.
        let row = id.0 as usize;
        if self.ids.get(row) == Some(&id) {
            return Some(row);
        }
        let (particles, others) = self.ids.split_at(self.particles);
        let (walls, groups) = others.split_at(others.len() - self.groups.len());
        let wall = || walls.binary_search(&id).ok().map(|k| self.particles + k);
        let group = || groups.binary_search(&id).ok().map(|k| self.particles + walls.len() + k);
        particles.binary_search(&id).ok().or_else(wall).or_else(group)
    }

    /// The wall in a row; `None` for another body.
    pub fn wall(&self, row: u32) -> Option<&WallRow> {
        self.walls.binary_search_by_key(&row, |wall| wall.body).ok().map(|k| &self.walls[k])
    }

    /// The rigid group in a row; `None` for another body.
    pub fn group_at(&self, row: usize) -> Option<&GroupRow> {
        self.groups.get(row.checked_sub(self.first_group())?)
    }

    /// Velocity (x, y; m/s) and angular velocity (rad/s) at the start of the trial.
    pub fn rates(&self, row: usize) -> [f64; 3] {
        [self.velocities[row].x, self.velocities[row].y, self.angular_velocities[row]]
    }

    /// Mass of degree of freedom `k` of a particle: kg, or kg m^2 of the rotation.
    pub fn mass_of(&self, i: usize, k: usize) -> f64 {
        if k < 2 { self.masses[i] } else { self.inertias[i] }
    }

    /// The rigid group of the body of a row; `None` for a body that belongs to none.
    pub fn group(&self, row: usize) -> Option<&GroupRow> {
        let index = self.group_of.get(row).copied().flatten()?;
        self.groups.get(index as usize)
    }

    /// Whether two bodies, `a < b`, have no contact with each other: members of one rigid group,
    /// and linked bodies.
    pub fn are_joined(&self, a: u32, b: u32) -> bool {
        if self.links.binary_search_by_key(&[a, b], |link| link.rows).is_ok() {
            return true;
        }
        let of = |row: u32| self.group_of.get(row as usize).copied().flatten();
        of(a).is_some_and(|group| of(b) == Some(group))
    }

    /// Rows of the particles of a group; its other members are walls.
    pub fn particles_of<'a>(&'a self, group: &'a GroupRow) -> impl Iterator<Item = usize> + 'a {
        group.members.iter().map(|i| *i as usize).take_while(|i| *i < self.particles)
    }

    /// Position of a member relative to the centre of its group, m.
    pub fn lever(&self, group: &GroupRow, member: usize) -> DVec2 {
        self.positions[member] - self.positions[group.body as usize]
    }

    /// Drive of degree of freedom `k` of a rigid group in the trial. Imposed displacements are
    /// those of a whole increment.
    pub fn group_drive(&self, group: &GroupRow, k: usize) -> BodyDrive {
        self.in_trial(group.drives[k])
    }

    /// Maximum displacement that the drives of a rigid group impose on one of its points in a whole
    /// increment, m.
    pub fn imposed_motion(&self, group: &GroupRow) -> f64 {
        let [x, y, turn] =
            [0, 1, 2].map(|k| self.group_drive(group, k).imposed().unwrap_or_default());
        x.hypot(y) + turn.abs() * group.extent
    }

    /// Drive of degree of freedom `k` of particle `i` in the trial. Imposed displacements are those
    /// of a whole increment.
    pub fn drive(&self, i: usize, k: usize) -> BodyDrive {
        self.in_trial(self.drives[i][k])
    }

    fn in_trial(&self, drive: BodyDrive) -> BodyDrive {
        match drive {
            BodyDrive::Imposed(_) if self.drives_stopped => BodyDrive::Imposed(0.0),
            drive => drive,
        }
    }

    /// Drive of a wall in the trial. Imposed displacements are those of a whole increment.
    pub fn wall_drive(&self, wall: &WallRow) -> WallDrive {
        match wall.drive {
            WallDrive::Imposed(_) | WallDrive::Turning { .. } if self.drives_stopped => {
                WallDrive::default()
            }
            WallDrive::Sliding { load, .. } if self.drives_stopped => WallDrive::Loaded(load),
            drive => drive,
        }
    }

    /// Displacement of the position of a wall that turns about a point by an angle (rad), m.
    pub fn swing(&self, wall: &WallRow, about: DVec2, angle: f64) -> DVec2 {
        let arm = self.positions[wall.body as usize] - about;
        let [x, y, _] = GroupRow::carried([0.0, 0.0, angle], arm);
        DVec2::new(x, y)
    }

    /// Maximum displacement that a drive imposes on a drawn point of a wall in a whole increment,
    /// m.
    pub fn wall_travel(&self, wall: &WallRow, drive: WallDrive) -> f64 {
        match drive {
            WallDrive::Turning { about, angle } => {
                let arm = self.positions[wall.body as usize].distance(about);
                angle.abs() * (arm + wall.extent())
            }
            other => other.imposed(wall.tangent()).length(),
        }
    }

    /// Moves these bonds from `bonds` to `broken`.
    pub fn break_bonds(&mut self, broken: &[BondId]) {
        self.broken.extend(self.bonds.extract_if(.., |bond| broken.contains(&bond.id)));
    }

    /// Whether a particle has a load of its own.
    pub fn has_load(&self, i: usize) -> bool {
        self.loads[i].iter().any(|load| load.from != 0.0 || load.to != 0.0)
    }

    /// Weight of a particle in a static increment under the acceleration `gravity` (m/s^2), N. It
    /// is 0 for a particle that is set aside, unless that has become part of a rigid group.
    pub fn static_weight(&self, i: usize, gravity: DVec2) -> DVec2 {
        if self.set_aside[i] && self.group(i).is_none() {
            DVec2::ZERO
        } else {
            self.masses[i] * gravity
        }
    }

    /// Load of a rigid group in the trial at the given part of the increment, N and N m: its own,
    /// that of its members, and their weight under the acceleration `gravity` (m/s^2).
    pub fn load_on_group(&self, group: &GroupRow, part: f64, gravity: DVec2) -> [f64; 3] {
        let mut sum = group.loads.map(|ramp| ramp.at(part));
        for i in self.particles_of(group) {
            let force = self.force_on(i, part, gravity);
            sum[0] += force.x;
            sum[1] += force.y;
            sum[2] += self.loads[i][2].at(part) + self.lever(group, i).perp_dot(force);
        }
        sum
    }

    /// Weight and load of particle `i` at a part of the increment, N.
    pub fn force_on(&self, i: usize, part: f64, gravity: DVec2) -> DVec2 {
        let [x, y, _] = self.loads[i].map(|ramp| ramp.at(part));
        DVec2::new(x, y) + self.masses[i] * gravity
    }

    /// The periodic cell after the displacement of its body (m, m, rad).
    pub fn deformed_cell(&self, u: Option<[f64; 3]>) -> Option<PeriodicCell> {
        self.cell.zip(u).map(|(cell, u)| cell.deformed(u, self.mean_radius))
    }

    /// Moves the bodies by displacements (m, m, rad), one entry per body, then one for the cell.
    pub fn move_by(&mut self, displacements: impl Iterator<Item = [f64; 3]>) {
        for (i, u) in displacements.enumerate() {
            if i == self.positions.len() {
                self.cell = self.deformed_cell(Some(u));
                break;
            }
            self.positions[i] += DVec2::new(u[0], u[1]);
            if let Some(rotation) = self.rotations.get_mut(i) {
                *rotation += u[2];
            }
            self.last_motion[i] = u;
        }
        // A wall that turns has its rotation in the table.
        for wall in &mut self.walls {
            let [_, _, angle] = self.last_motion[wall.body as usize];
            if angle != 0.0 {
                *wall = wall.turned(angle);
            }
        }
    }
}

/// A pair of bodies that carries force or may carry force within the increment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Contact {
    /// Row of the first body, always a particle.
    pub a: u32,
    /// Row of the second body: a particle with `b > a`, or a wall.
    pub b: u32,
    /// Unit normal from a to b at the start of the increment.
    pub normal: DVec2,
    /// Gap `g_0` at the start of the increment, m; negative is overlap.
    pub gap: f64,
    /// Index into [`BodyTable::bonds`] of the intact bond that joins the two bodies.
    pub bond: Option<u32>,
}

impl Contact {
    /// The contact point, the middle of the gap, m.
    pub fn point(&self, bodies: &BodyTable) -> DVec2 {
        let a = self.a as usize;
        bodies.positions[a] + self.normal * (bodies.radii[a] + 0.5 * self.gap)
    }

    /// Common radius r^I, m: the smaller radius of two particles, or the radius of the particle at
    /// a wall.
    pub fn common_radius(&self, bodies: &BodyTable) -> f64 {
        let ra = bodies.radii[self.a as usize];
        bodies.radii.get(self.b as usize).map_or(ra, |rb| ra.min(*rb))
    }
}

/// Potential contacts of the attempt, sorted by (a, b).
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct ContactTable(pub Vec<Contact>);
