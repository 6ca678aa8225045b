//! Commits an accepted attempt: moves bodies, updates velocities and contact history, and records
//! the external forces.
//!
//! With the theta-method (equations 2 and 3 of the paper) `v = (u/dt - (1 - theta) v_0)/theta`, and
//! likewise for rotations.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::body::{
    AngularVelocity, BodyId, Drive, ExternalForce, LastMotion, Position, Rotation, Velocity,
};
use clastic_components::cell::PeriodicCell;
use clastic_components::contact::{Bodies, ContactHistory, ContactMemory, Contacts, DraftHistory};
use clastic_components::findings::{
    Corrections, EventSearch, Impacts, Pushed, Restraints, Ruptures,
};
use clastic_components::increment::{
    Acceptance, Analysis, AnalysisKind, Avalanche, Progress, RuptureOrder, RuptureRules,
};
use clastic_components::loads::TrialLoads;
use clastic_components::particle::{Particle, Swinging};
use clastic_components::rigid_group::{ContactForce, GroupRow, RigidGroup};
use clastic_components::wall::{Wall, WallRotation};
use clastic_components::wall_shape::WallShape;
use clastic_cone::program::{ConeProgram, ConeSolution, Dof};

use crate::paths::paths;
use crate::schedule::{Increment, IncrementSystems, lap};
use clastic_cone::residuals::Carrying;

/// Adds the systems of the update.
pub struct UpdateStatePlugin;

impl Plugin for UpdateStatePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Increment,
            (
                external_forces,
                move_bodies,
                remember_contacts,
                remember_swinging,
                advance_progress,
                lap(|t| &mut t.update),
            )
                .chain()
                .in_set(IncrementSystems::Update),
        );
    }
}

/// Computes [`ExternalForce`]: the force that the motion requires in addition to contact forces and
/// gravity.
pub fn external_forces(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    analysis: Res<Analysis>,
    progress: Res<Progress>,
    loads: Res<TrialLoads>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut out: Query<(&BodyId, &mut ExternalForce)>,
    mut of_contacts: Query<(&BodyId, &mut ContactForce)>,
) {
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(&solution.forces, &mut rows);
    // The moment of a wall refers to the middle of its drawn segment.
    let mut moments = vec![0.0; program.bodies.len()];
    let mut on_walls = vec![DVec2::ZERO; program.bodies.len()];
    for ((contact, c), f) in contacts.0.iter().zip(&program.interactions).zip(&solution.forces) {
        if contact.b as usize >= bodies.particles {
            let arm = contact.point(&bodies) - bodies.positions[contact.b as usize];
            let resisted = -(c.normal * f[0] + c.normal.perp() * f[1]);
            moments[contact.b as usize] += arm.perp_dot(resisted) - f[2];
            on_walls[contact.b as usize] += resisted;
        }
    }
    let added = if loads.is_empty() { Vec::new() } else { loads.sums(&bodies) };
    let added = |i: usize| added.get(i).copied().unwrap_or_default();
    for (id, mut external) in &mut out {
        let Some(i) = bodies.row(*id) else { continue };
        let body = &program.bodies[i];
        if let Some(group) = bodies.groups.iter().find(|group| group.body as usize == i) {
            external.0 = [0, 1, 2].map(|k| {
                let (u, resisted) = (solution.displacements[i][k], rows[i][k]);
                let added = added(i)[k].force - added(i)[k].stiffness * u;
                let is_free = group.drives[k] == Drive::Free;
                force_on_group(&bodies, &analysis, &progress, group, k, [u, resisted])
                    + if is_free { added } else { 0.0 }
            });
            continue;
        }
        if i >= bodies.particles {
            let force = body.to_global(rows[i]);
            external.0 = [force[0], force[1], moments[i]];
            if bodies.group(i).is_some() {
                // The program has the forces on a member in the row of the group.
                external.0 = [on_walls[i].x, on_walls[i].y, moments[i]];
            }
            continue;
        }
        for k in 0..3 {
            let applied = bodies.loads[i][k].at(progress.fraction) + added(i)[k].force
                - added(i)[k].stiffness * solution.displacements[i][k];
            external.0[k] = match body.dofs[k] {
                Dof::Free(_) => applied,
                Dof::Fixed(u) => match analysis.kind {
                    AnalysisKind::Dynamic { dt, .. }
                        if bodies.drives[i][k] != Default::default() =>
                    {
                        let dt = dt * progress.fraction;
                        let mass = if k < 2 { bodies.masses[i] } else { bodies.inertias[i] };
                        let v = if k < 2 {
                            bodies.velocities[i][k]
                        } else {
                            bodies.angular_velocities[i]
                        };
                        let weight = if k < 2 { mass * analysis.gravity[k] } else { 0.0 };
                        // A driven body has the velocity u/dt over the whole increment, whatever
                        // theta.
                        mass * (u - v * dt) / (dt * dt) + rows[i][k] - weight
                    }
                    AnalysisKind::Dynamic { .. } => applied,
                    AnalysisKind::Static | AnalysisKind::Compaction { .. } => {
                        let weight =
                            if k < 2 { bodies.masses[i] * analysis.gravity[k] } else { 0.0 };
                        if bodies.drives[i][k] == Default::default() {
                            applied
                        } else {
                            rows[i][k] - weight
                        }
                    }
                },
            };
        }
    }
    for (id, mut force) in &mut of_contacts {
        if let Some(i) = bodies.row(*id) {
            force.0 = rows[i].map(|resisted| -resisted);
        }
    }
}

/// Force of the outside world on degree of freedom k of a group besides the loads of its members:
/// its own load, or the reaction to its imposed motion. `moved` are k, its displacement and the
/// force of the interactions that it resists.
fn force_on_group(
    bodies: &Bodies,
    analysis: &Analysis,
    progress: &Progress,
    group: &GroupRow,
    k: usize,
    [u, resisted]: [f64; 2],
) -> f64 {
    let fraction = progress.fraction;
    if group.drives[k] == Drive::Free {
        return group.loads[k].at(fraction);
    }
    let all = bodies.load_on_group(group, fraction, analysis.gravity)[k];
    let by_others = all - group.loads[k].at(fraction);
    let inertial = match analysis.kind {
        AnalysisKind::Dynamic { dt, .. } => {
            let dt = dt * fraction;
            let row = group.body as usize;
            let v = if k < 2 { bodies.velocities[row][k] } else { bodies.angular_velocities[row] };
            // A driven body has the velocity u/dt over the whole increment, whatever theta.
            group.mass_of(k) * (u - v * dt) / (dt * dt)
        }
        AnalysisKind::Static | AnalysisKind::Compaction { .. } => 0.0,
    };
    inertial + resisted - by_others
}

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

/// Stores the forces of contacts that persist.
pub fn remember_contacts(
    bodies: Res<Bodies>,
    analysis: Res<Analysis>,
    corrections: Res<Corrections>,
    contacts: Res<Contacts>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    draft: Res<DraftHistory>,
    mut history: ResMut<ContactHistory>,
) {
    *history =
        remembered(&bodies, &analysis, &corrections, &contacts, &program, &solution, &draft.0);
}

/// Forces of the persistent contacts after a solution, given those `before` it. The shear force of
/// the program is the average over the increment, so the force at its end is
/// `q = q_0 + (q_program - q_0)/theta`.
#[must_use]
pub fn remembered(
    bodies: &Bodies,
    analysis: &Analysis,
    corrections: &Corrections,
    contacts: &Contacts,
    program: &ConeProgram,
    solution: &ConeSolution,
    before: &ContactHistory,
) -> ContactHistory {
    let theta = match analysis.kind {
        AnalysisKind::Dynamic { theta, .. } => theta,
        AnalysisKind::Static | AnalysisKind::Compaction { .. } => 1.0,
    };
    let carrying = Carrying::new(program, solution);
    let mut history = ContactHistory(Vec::with_capacity(contacts.0.len()));
    let is_known = |body: u32| !program.bodies[body as usize].is_free();
    let forces = program.interactions.iter().zip(&solution.forces);
    for (k, (contact, (c, f))) in contacts.0.iter().zip(forces).enumerate() {
        // The force between two rigid bodies with known motion is not unique. It may be large, and
        // as a scale it would hide the errors of other forces.
        if c.normal_compliance == 0.0 && is_known(c.a) && is_known(c.b) {
            history.0.extend(before.get(contact.a, contact.b).copied());
            continue;
        }
        let is_kept = c.limits.has_strength() || (f[0] > 0.0 && carrying.is_carrying(k));
        if !is_kept {
            continue;
        }
        let q = if c.tangential_compliance > 0.0 {
            let shift = corrections.shear_shift((contact.a, contact.b), c.tangential_compliance);
            let before = c.previous_shear - shift;
            before + (f[1] - before) / theta
        } else {
            f[1]
        };
        history.0.push(ContactMemory { a: contact.a, b: contact.b, p: f[0], q, tau: f[2] });
    }
    if !bodies.groups.is_empty() {
        // Within a group nothing moves, and forces stay as they were.
        history.0.extend(before.0.iter().filter(|m| bodies.are_joined(m.a, m.b)));
        history.0.sort_unstable_by_key(|m| (m.a, m.b));
    }
    history
}

/// Marks particles that the attempts found to be [`Swinging`].
pub fn remember_swinging(bodies: Res<Bodies>, found: Res<Restraints>, mut commands: Commands) {
    for (i, _) in found.swinging.iter().enumerate().filter(|(i, s)| **s && !bodies.swinging[*i]) {
        commands.entity(bodies.entities[i]).insert(Swinging);
    }
}

/// Adds the committed fraction of the increment to the progress.
pub fn advance_progress(
    analysis: Res<Analysis>,
    rules: Res<RuptureRules>,
    search: Res<EventSearch>,
    ruptures: Res<Ruptures>,
    mut progress: ResMut<Progress>,
) {
    // A released motion ends at rest without the bonds that broke in it.
    let is_settled = match (rules.order, rules.avalanche) {
        (RuptureOrder::Events, Avalanche::Dynamic) => ruptures.on_the_way,
        _ => 0,
    };
    progress.relaxing = (search.active || search.leaves) && ruptures.list.len() > is_settled;
    let fraction = progress.fraction;
    progress.done += fraction;
    if (progress.done - progress.done.round()).abs() < 1e-9 {
        progress.done = progress.done.round();
    }
    if let AnalysisKind::Dynamic { dt, .. } = analysis.kind {
        progress.time += dt * fraction;
    }
}
