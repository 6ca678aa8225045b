//! Moves bodies and updates velocities.
//!
//! With the theta-method (equations 2 and 3 of the paper) `v = (u/dt - (1 - theta) v_0)/theta`, and
//! likewise for rotations.

use crate::impacts::paths::paths;
use bevy_ecs::prelude::*;
use clastic_components::body::{
    BodyAngularVelocity, BodyDrive, BodyId, BodyPosition, BodyRotation, BodyVelocity, LastMotion,
};
use clastic_components::cell::PeriodicCell;
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::findings::{Impacts, Pushed};
use clastic_components::increment::{Acceptance, AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_components::particle::Particle;
use clastic_components::rigid_group::{GroupRow, RigidGroup};
use clastic_components::wall::{Wall, WallRotation};
use clastic_components::wall_shape::WallShape;
use clastic_cone::program::{ConeProgram, ConeSolution};
use glam::DVec2;

/// The rigid groups of the world.
type GroupsOfWorld<'w, 's> = Query<
    'w,
    's,
    (
        &'static BodyId,
        &'static RigidGroup,
        &'static mut BodyPosition,
        &'static mut BodyRotation,
        &'static mut LastMotion,
    ),
    (With<RigidGroup>, Without<Particle>, Without<Wall>),
>;

/// The walls of the world.
type WallsOfWorld<'w, 's> = Query<
    'w,
    's,
    (
        &'static BodyId,
        &'static mut BodyPosition,
        &'static mut LastMotion,
        &'static mut Wall,
        Option<&'static mut WallShape>,
        Option<&'static mut WallRotation>,
    ),
    (With<Wall>, Without<Particle>),
>;

/// Moves particles, walls and rigid groups and updates velocities.
pub fn move_bodies(
    bodies: Res<BodyTable>,
    analysis: Res<ClasticAnalysis>,
    acceptance: Res<Acceptance>,
    progress: Res<ClasticProgress>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    contacts: Res<ContactTable>,
    findings: (Res<Pushed>, Res<Impacts>),
    mut particles: Query<
        (
            &BodyId,
            &mut BodyPosition,
            &mut BodyRotation,
            &mut BodyVelocity,
            &mut BodyAngularVelocity,
            &mut LastMotion,
        ),
        With<Particle>,
    >,
    mut walls: WallsOfWorld,
    mut groups: GroupsOfWorld,
    cell: Option<ResMut<PeriodicCell>>,
) {
    // Displacements that separate rigid overlaps move bodies and give no velocity.
    let (pushed, impacts) = findings;
    let paths = || {
        paths(&bodies, &contacts, &analysis, &acceptance, &progress, &program, &solution, &impacts)
    };
    let paths = if pushed.0.is_none() { paths() } else { None };
    let motion = pushed.0.as_ref().or(paths.as_ref()).unwrap_or(&solution.displacements);
    let committed = Committed { bodies: &bodies, program: &program, solution: &solution, motion };
    let step = match analysis.kind {
        AnalysisKind::Dynamic { dt, theta } => Some(Step { dt: dt * progress.fraction, theta }),
        AnalysisKind::Static | AnalysisKind::Compaction { .. } => None,
    };
    for (id, x, rotation, v, spin, last) in &mut particles {
        let Some(i) = bodies.row(*id) else { continue };
        let moved = committed.moved(i);
        // A followed motion has moved the table but not the entity.
        write(x, BodyPosition(bodies.positions[i] + DVec2::new(moved[0], moved[1])), place);
        write(rotation, BodyRotation(bodies.rotations[i] + moved[2]), |rotation| [rotation.0]);
        write(last, LastMotion(moved), |last| last.0);
        if let Some(step) = step {
            let (velocity, turns) = match bodies.group(i) {
                Some(group) => committed.velocity_in_group(step, i, group),
                None => committed.velocity(step, i, v.0, spin.0),
            };
            write(v, BodyVelocity(velocity), |v| v.0.into());
            write(spin, BodyAngularVelocity(turns), |spin| [spin.0]);
        }
    }
    for (id, x, last, mut wall, shape, rotation) in &mut walls {
        let Some(i) = bodies.row(*id) else { continue };
        let moved = committed.moved(i);
        write(x, BodyPosition(bodies.positions[i] + DVec2::new(moved[0], moved[1])), place);
        write(last, LastMotion(moved), |last| last.0);
        committed.turn_wall(i, moved[2], &mut wall, shape, rotation);
    }
    if let Some(mut cell) = cell {
        committed.deform(&mut cell, analysis.thickness);
    }
    for (id, group, x, rotation, last) in &mut groups {
        let Some(i) = bodies.row(*id) else { continue };
        write(x, BodyPosition(bodies.positions[i] + DVec2::new(motion[i][0], motion[i][1])), place);
        // A followed motion has turned the members in the table.
        let first = bodies.groups.iter().find(|row| row.body as usize == i);
        let member = first.and_then(|row| row.members.first());
        if let Some(&member) = member {
            let turned = bodies.rotations[member as usize] + motion[i][2] - group.reference;
            write(rotation, BodyRotation(turned), |rotation| [rotation.0]);
        }
        write(last, LastMotion(motion[i]), |last| last.0);
    }
}

/// Writes a component if its numbers change, so that `Changed` finds the bodies that move. Bits are
/// compared, because 0 and -0 are equal and not the same state.
fn write<C, const N: usize>(mut to: Mut<C>, new: C, numbers: fn(&C) -> [f64; N]) {
    if numbers(&to).map(f64::to_bits) != numbers(&new).map(f64::to_bits) {
        *to = new;
    }
}

fn place(at: &BodyPosition) -> [f64; 2] {
    at.0.into()
}

/// The time step of the part of an increment that is committed.
#[derive(Clone, Copy)]
struct Step {
    /// s.
    dt: f64,
    theta: f64,
}

impl Step {
    /// Velocity at the end, from the displacement `u` and the velocity `v` at the start. An imposed
    /// motion follows no equation of motion, so its velocity is the imposed one.
    fn velocity(self, u: f64, v: f64, is_imposed: bool) -> f64 {
        let Self { dt, theta } = self;
        if is_imposed { u / dt } else { (u / dt - (1.0 - theta) * v) / theta }
    }
}

/// The solution that is committed.
struct Committed<'a> {
    bodies: &'a BodyTable,
    program: &'a ConeProgram,
    solution: &'a ConeSolution,
    /// Displacements of the bodies, in the axes of the program. They may differ from those of the
    /// solution, which give the velocities.
    motion: &'a [[f64; 3]],
}

impl Committed<'_> {
    /// Displacement (x, y) and rotation of a body.
    fn moved(&self, i: usize) -> [f64; 3] {
        self.program.bodies[i].to_global(self.motion[i])
    }

    /// Velocity and angular velocity of a particle at the end, from those at the start.
    fn velocity(&self, step: Step, i: usize, v: DVec2, spin: f64) -> (DVec2, f64) {
        let u = self.program.bodies[i].to_global(self.solution.displacements[i]);
        let imposed = self.bodies.drives[i].map(|drive| drive != BodyDrive::Free);
        let end =
            DVec2::new(step.velocity(u[0], v.x, imposed[0]), step.velocity(u[1], v.y, imposed[1]));
        (end, step.velocity(u[2], spin, imposed[2]))
    }

    /// Velocity and angular velocity of a member of a rigid group.
    fn velocity_in_group(&self, step: Step, i: usize, group: &GroupRow) -> (DVec2, f64) {
        let row = group.body as usize;
        let (u, v) = (self.solution.displacements[row], self.bodies.velocities[row]);
        let is_driven = |k: usize| group.drives[k] != BodyDrive::Free;
        let turns = step.velocity(u[2], self.bodies.angular_velocities[row], is_driven(2));
        let moves = [0, 1].map(|k| step.velocity(u[k], v[k], is_driven(k)));
        // Positions may follow another path than the velocities of the program.
        let lever = self.bodies.lever(group, i);
        let turned = GroupRow::carried([0.0, 0.0, self.motion[row][2]], lever);
        let lever = lever + DVec2::new(turned[0], turned[1]);
        (DVec2::from(moves) + turns * lever.perp(), turns)
    }

    /// Turns a wall by an angle, rad.
    fn turn_wall(
        &self,
        i: usize,
        angle: f64,
        wall: &mut Wall,
        mut shape: Option<Mut<WallShape>>,
        mut rotation: Option<Mut<WallRotation>>,
    ) {
        let row = self.bodies.walls.iter().find(|row| row.body as usize == i);
        if let Some(row) = row {
            // A followed motion may have turned the wall in the table.
            wall.tangent = row.tangent();
            if let Some(shape) = &mut shape {
                **shape = row.shape;
            }
            if let Some(rotation) = &mut rotation {
                rotation.0 = self.bodies.rotations[i];
            }
        }
        if angle != 0.0 {
            let by = DVec2::from_angle(angle);
            *wall = wall.turned(by);
            if let Some(mut shape) = shape {
                *shape = shape.turned(by);
            }
            if let Some(mut rotation) = rotation {
                rotation.0 += angle;
            }
        }
    }

    /// Deforms the periodic cell and sets its stress, Pa.
    fn deform(&self, cell: &mut PeriodicCell, thickness: f64) {
        let (Some(start), Some(of)) = (&self.bodies.cell, &self.program.cell) else { return };
        let row = of.body as usize;
        *cell = start.deformed(self.moved(row), self.bodies.mean_radius);
        let mut rows = vec![[0.0; 3]; self.program.bodies.len()];
        self.program.add_forces(&self.solution.forces, &mut rows);
        let resisted = self.program.bodies[row].to_global(rows[row]);
        let loads = start.loads(self.bodies.mean_radius, thickness);
        cell.stress = [0, 1, 2].map(|k| resisted[k] / loads[k]);
    }
}
