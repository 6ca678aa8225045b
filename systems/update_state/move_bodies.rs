//! Moves bodies and updates velocities.
//!
//! With the theta-method (equations 2 and 3 of the paper) `v = (u/dt - (1 - theta) v_0)/theta`, and
//! likewise for rotations.

use crate::impacts::paths::Paths;
use crate::solved::{Solved, SolvedTables};
use bevy_ecs::prelude::*;
use clastic_components::prelude::*;
use glam::DVec2;

/// Moves particles, walls and rigid groups and updates velocities.
pub fn move_bodies(
    tables: SolvedTables,
    analysis: Res<ClasticAnalysis>,
    progress: Res<ClasticProgress>,
    paths: Paths,
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
    mut walls: Query<
        (
            &BodyId,
            &mut BodyPosition,
            &mut LastMotion,
            &mut Wall,
            Option<&mut WallShape>,
            Option<&mut WallRotation>,
        ),
        Without<Particle>,
    >,
    mut groups: Query<
        (&BodyId, &RigidGroup, &mut BodyPosition, &mut BodyRotation, &mut LastMotion),
        (Without<Particle>, Without<Wall>),
    >,
    cell: Option<ResMut<PeriodicCell>>,
) {
    let solved = tables.get();
    let bodies = solved.bodies;
    // Displacements that separate rigid overlaps move bodies and give no velocity.
    let motion = &*paths.motion(solved);
    let committed = Committed { solved, motion };
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
        let member = bodies.group_at(i).and_then(|row| row.members.first());
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
    /// Duration, s.
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
    solved: Solved<'a>,
    /// Displacements of the bodies, in the axes of the program. They may differ from those of the
    /// solution, which give the velocities.
    motion: &'a [[f64; 3]],
}

impl Committed<'_> {
    /// Displacement (x, y) and rotation of a body.
    fn moved(&self, i: usize) -> [f64; 3] {
        self.solved.program.bodies[i].to_global(self.motion[i])
    }

    /// Velocity and angular velocity of a particle at the end, from those at the start.
    fn velocity(&self, step: Step, i: usize, v: DVec2, spin: f64) -> (DVec2, f64) {
        let Solved { bodies, program, solution, .. } = self.solved;
        let u = program.bodies[i].to_global(solution.displacements[i]);
        let imposed = bodies.drives[i].map(|drive| drive != BodyDrive::Free);
        let end =
            DVec2::new(step.velocity(u[0], v.x, imposed[0]), step.velocity(u[1], v.y, imposed[1]));
        (end, step.velocity(u[2], spin, imposed[2]))
    }

    /// Velocity and angular velocity of a member of a rigid group.
    fn velocity_in_group(&self, step: Step, i: usize, group: &GroupRow) -> (DVec2, f64) {
        let row = group.body as usize;
        let (bodies, u) = (self.solved.bodies, self.solved.solution.displacements[row]);
        let v = bodies.rates(row);
        let [x, y, turns] =
            [0, 1, 2].map(|k| step.velocity(u[k], v[k], group.drives[k] != BodyDrive::Free));
        // Positions may follow another path than the velocities of the program.
        let lever = bodies.lever(group, i);
        let turned = GroupRow::carried([0.0, 0.0, self.motion[row][2]], lever);
        let lever = lever + DVec2::new(turned[0], turned[1]);
        (DVec2::new(x, y) + turns * lever.perp(), turns)
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
        let bodies = self.solved.bodies;
        if let Some(row) = bodies.wall(i as u32) {
            // A followed motion may have turned the wall in the table.
            wall.tangent = row.tangent();
            if let Some(shape) = &mut shape {
                **shape = row.shape;
            }
            if let Some(rotation) = &mut rotation {
                rotation.0 = bodies.rotations[i];
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
        let Solved { bodies, program, solution, .. } = self.solved;
        let (Some(start), Some(of)) = (&bodies.cell, &program.cell) else { return };
        let row = of.body as usize;
        *cell = start.deformed(self.moved(row), bodies.mean_radius);
        let mut rows = vec![[0.0; 3]; program.bodies.len()];
        program.add_forces(&solution.forces, &mut rows);
        let resisted = program.bodies[row].to_global(rows[row]);
        let loads = start.loads(bodies.mean_radius, thickness);
        cell.stress = [0, 1, 2].map(|k| resisted[k] / loads[k]);
    }
}
