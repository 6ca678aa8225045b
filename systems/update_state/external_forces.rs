//! Forces and moments of the outside world on bodies.

use bevy_ecs::prelude::*;
use clastic_components::prelude::*;
use clastic_cone::program::Dof;
use glam::DVec2;

use crate::solved::{Solved, SolvedTables};

/// Computes [`BodyExternalForce`]: the force that the motion requires in addition to contact forces and
/// gravity.
pub fn external_forces(
    tables: SolvedTables,
    analysis: Res<ClasticAnalysis>,
    progress: Res<ClasticProgress>,
    loads: Res<TrialLoads>,
    mut out: Query<(&BodyId, &mut BodyExternalForce)>,
    mut of_contacts: Query<(&BodyId, &mut ContactForce)>,
) {
    let solved = tables.get();
    let Solved { bodies, program, solution, .. } = solved;
    let fraction = progress.fraction;
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(&solution.forces, &mut rows);
    // The moment of a wall refers to the middle of its drawn segment.
    let mut moments = vec![0.0; program.bodies.len()];
    let mut on_walls = vec![DVec2::ZERO; program.bodies.len()];
    for (contact, c, f) in solved.contacts() {
        if contact.b as usize >= bodies.particles {
            let arm = contact.point(bodies) - bodies.positions[contact.b as usize];
            let resisted = -c.force(f);
            moments[contact.b as usize] += arm.perp_dot(resisted) - f[2];
            on_walls[contact.b as usize] += resisted;
        }
    }
    let sums = if loads.is_empty() { Vec::new() } else { loads.sums(bodies) };
    let added = |i: usize, k: usize, u: f64| {
        let added = sums.get(i).copied().unwrap_or_default()[k];
        (added.force, added.stiffness * u)
    };
    // A driven body has the velocity u/dt over the whole increment, whatever theta.
    let inertial = |i: usize, k: usize, mass: f64, u: f64| match analysis.kind {
        AnalysisKind::Dynamic { dt, .. } => {
            let dt = dt * fraction;
            mass * (u - bodies.rates(i)[k] * dt) / (dt * dt)
        }
        AnalysisKind::Static | AnalysisKind::Compaction { .. } => 0.0,
    };
    for (id, mut external) in &mut out {
        let Some(i) = bodies.row(*id) else { continue };
        let (body, u) = (&program.bodies[i], solution.displacements[i]);
        if let Some(group) = bodies.group_at(i) {
            let all = bodies.load_on_group(group, fraction, analysis.gravity);
            external.0 = [0, 1, 2].map(|k| {
                let own = group.loads[k].at(fraction);
                let (force, sprung) = added(i, k, u[k]);
                if group.drives[k] == BodyDrive::Free {
                    own + (force - sprung)
                } else {
                    // The reaction acts on the group; the loads of its members are not part of it.
                    inertial(i, k, group.mass_of(k), u[k]) + rows[i][k] - (all[k] - own)
                }
            });
        } else if i < bodies.particles {
            external.0 = [0, 1, 2].map(|k| {
                let (force, sprung) = added(i, k, u[k]);
                let mass = bodies.mass_of(i, k);
                let weight = if k < 2 { mass * analysis.gravity[k] } else { 0.0 };
                match body.dofs[k] {
                    Dof::Fixed(u) if bodies.drives[i][k] != BodyDrive::Free => {
                        inertial(i, k, mass, u) + rows[i][k] - weight
                    }
                    _ => bodies.loads[i][k].at(fraction) + force - sprung,
                }
            });
        } else if bodies.group(i).is_some() {
            // The program has the forces on a member in the row of the group.
            external.0 = [on_walls[i].x, on_walls[i].y, moments[i]];
        } else {
            let force = body.to_global(rows[i]);
            external.0 = [force[0], force[1], moments[i]];
        }
    }
    for (id, mut force) in &mut of_contacts {
        if let Some(i) = bodies.row(*id) {
            force.0 = rows[i].map(|resisted| -resisted);
        }
    }
}
