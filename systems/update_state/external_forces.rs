//! Forces and moments of the outside world on bodies.

use bevy_ecs::prelude::*;
use clastic_components::body::{BodyDrive, BodyExternalForce, BodyId};
use clastic_components::contact::{BodyTable, ContactTable};
use clastic_components::increment::{AnalysisKind, ClasticAnalysis, ClasticProgress};
use clastic_components::loads::TrialLoads;
use clastic_components::rigid_group::{ContactForce, GroupRow};
use clastic_cone::program::{ConeProgram, ConeSolution, Dof};
use glam::DVec2;

/// Computes [`BodyExternalForce`]: the force that the motion requires in addition to contact forces and
/// gravity.
pub fn external_forces(
    bodies: Res<BodyTable>,
    contacts: Res<ContactTable>,
    analysis: Res<ClasticAnalysis>,
    progress: Res<ClasticProgress>,
    loads: Res<TrialLoads>,
    program: Res<ConeProgram>,
    solution: Res<ConeSolution>,
    mut out: Query<(&BodyId, &mut BodyExternalForce)>,
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
            let resisted = -c.force(f);
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
                let is_free = group.drives[k] == BodyDrive::Free;
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
    bodies: &BodyTable,
    analysis: &ClasticAnalysis,
    progress: &ClasticProgress,
    group: &GroupRow,
    k: usize,
    [u, resisted]: [f64; 2],
) -> f64 {
    let fraction = progress.fraction;
    if group.drives[k] == BodyDrive::Free {
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
