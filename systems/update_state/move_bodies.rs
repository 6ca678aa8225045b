//! Moves bodies and updates velocities.
//!
//! With the theta-method (equations 2 and 3 of the paper) `v = (u/dt - (1 - theta) v_0)/theta`, and
//! likewise for rotations.

use crate::paths::paths;
use bevy_ecs::prelude::*;
use clastic_components::body::{
    AngularVelocity, BodyId, Drive, LastMotion, Position, Rotation, Velocity,
};
use clastic_components::cell::PeriodicCell;
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::findings::{Impacts, Pushed};
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind, Progress};
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
        &'static mut Position,
        &'static mut Rotation,
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
        &'static mut Position,
        &'static mut LastMotion,
        &'static mut Wall,
        Option<&'static mut WallShape>,
        Option<&'static mut WallRotation>,
    ),
    (With<Wall>, Without<Particle>),
>;

/// Moves particles, walls and rigid groups and updates velocities.
pub fn move_bodies(
    bodies: Res<Bodies>,
    analysis: Res<Analysis>,
    acceptance: Res<Acceptance>,
    progress: Res<Progress>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    contacts: Res<Contacts>,
    findings: (Res<Pushed>, Res<Impacts>),
    mut particles: Query<
        (
            &BodyId,
            &mut Position,
            &mut Rotation,
            &mut Velocity,
            &mut AngularVelocity,
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
    for (id, mut x, mut rotation, mut v, mut spin, mut last) in &mut particles {
        let Some(i) = bodies.row(*id) else { continue };
        let u = program.bodies[i].to_global(solution.displacements[i]);
        let step = DVec2::new(u[0], u[1]);
        let moved = program.bodies[i].to_global(motion[i]);
        // A followed motion has moved the table but not the entity.
        x.0 = bodies.positions[i] + DVec2::new(moved[0], moved[1]);
        rotation.0 = bodies.rotations[i] + moved[2];
        last.0 = moved;
        if let AnalysisKind::Dynamic { dt, theta } = analysis.kind {
            let dt = dt * progress.fraction;
            let next = |u: f64, v: f64, imposed: bool| {
                // An imposed motion follows no equation of motion, so its velocity is the imposed
                // one.
                if imposed { u / dt } else { (u / dt - (1.0 - theta) * v) / theta }
            };
            if let Some(group) = bodies.group(i) {
                let row = group.body as usize;
                let (u, v_0) = (solution.displacements[row], bodies.velocities[row]);
                let is_driven = |k: usize| group.drives[k] != Drive::Free;
                let turns = next(u[2], bodies.angular_velocities[row], is_driven(2));
                let moves = [0, 1].map(|k| next(u[k], v_0[k], is_driven(k)));
                // Positions may follow another path than the velocities of the program.
                let turned = GroupRow::carried([0.0, 0.0, motion[row][2]], bodies.lever(group, i));
                let lever = bodies.lever(group, i) + DVec2::new(turned[0], turned[1]);
                v.0 = DVec2::from(moves) + turns * lever.perp();
                spin.0 = turns;
                continue;
            }
            let imposed = bodies.drives[i].map(|d| d != Default::default());
            v.0 = DVec2::new(next(step.x, v.0.x, imposed[0]), next(step.y, v.0.y, imposed[1]));
            spin.0 = next(u[2], spin.0, imposed[2]);
        }
    }
    for (id, mut x, mut last, mut wall, mut shape, mut rotation) in &mut walls {
        let Some(i) = bodies.row(*id) else { continue };
        let u = program.bodies[i].to_global(motion[i]);
        x.0 = bodies.positions[i] + DVec2::new(u[0], u[1]);
        last.0 = u;
        let row = bodies.walls.iter().find(|row| row.body as usize == i);
        if let Some(row) = row.filter(|_| bodies.group(i).is_some()) {
            // A followed motion has turned the wall in the table.
            wall.tangent = row.tangent();
            if let Some(shape) = &mut shape {
                **shape = row.shape;
            }
            if let Some(rotation) = &mut rotation {
                rotation.0 = bodies.rotations[i];
            }
        }
        if u[2] != 0.0 {
            let by = DVec2::from_angle(u[2]);
            *wall = wall.turned(by);
            if let Some(mut shape) = shape {
                *shape = shape.turned(by);
            }
            if let Some(mut rotation) = rotation {
                rotation.0 += u[2];
            }
        }
    }
    if let (Some(mut cell), Some(start), Some(of)) = (cell, &bodies.cell, &program.cell) {
        let row = of.body as usize;
        *cell = start.deformed(program.bodies[row].to_global(motion[row]), bodies.mean_radius);
        let mut rows = vec![[0.0; 3]; program.bodies.len()];
        program.add_forces(&solution.forces, &mut rows);
        let resisted = program.bodies[row].to_global(rows[row]);
        let loads = start.loads(bodies.mean_radius, analysis.thickness);
        cell.stress = [0, 1, 2].map(|k| resisted[k] / loads[k]);
    }
    for (id, group, mut x, mut rotation, mut last) in &mut groups {
        let Some(i) = bodies.row(*id) else { continue };
        x.0 = bodies.positions[i] + DVec2::new(motion[i][0], motion[i][1]);
        // A followed motion has turned the members in the table.
        let first = bodies.groups.iter().find(|row| row.body as usize == i);
        let member = first.and_then(|row| row.members.first());
        if let Some(&member) = member {
            rotation.0 = bodies.rotations[member as usize] + motion[i][2] - group.reference;
        }
        last.0 = motion[i];
    }
}
