//! Rigid groups in the program: the forces on members act on the body of the group, with arms about
//! its centre. The rows of members are those of bodies whose motion is known.

use clastic_components::body::BodyDrive;
use clastic_components::contact::BodyTable;
use clastic_components::increment::{AnalysisKind, ClasticAnalysis};
use clastic_components::loads::AddedLoad;
use clastic_components::rigid_group::GroupRow;
use clastic_cone::program::{Dof, FreeDof, Interaction, ProgramBody};
use glam::DVec2;

/// Moves the forces on members of rigid groups to the bodies of the groups.
pub fn join(bodies: &BodyTable, interactions: &mut [Interaction]) {
    if bodies.groups.is_empty() {
        return;
    }
    for c in interactions {
        for (body, first) in [(c.a, true), (c.b, false)] {
            if let Some(group) = bodies.group(body as usize) {
                *c = c.carried_by(first, group.body, bodies.lever(group, body as usize));
            }
        }
    }
}

/// The body of a group: its loads, and its inertia in dynamics. `acts` tells whether interactions
/// act on its translations and on its rotation. `added` are the loads of an embedding program, by
/// row.
#[must_use]
pub fn body(
    bodies: &BodyTable,
    analysis: &ClasticAnalysis,
    fraction: f64,
    group: &GroupRow,
    acts: (bool, bool),
    added: impl Fn(usize) -> [AddedLoad; 3],
    mean: impl Fn(DVec2) -> DVec2,
) -> ProgramBody {
    let row = group.body as usize;
    let mut load = bodies.load_on_group(group, fraction, analysis.gravity);
    let mut stiffness = [0.0; 3];
    for k in 0..3 {
        load[k] += added(row)[k].force;
        stiffness[k] = added(row)[k].stiffness;
    }
    for i in group.members.iter().map(|i| *i as usize) {
        let lever = bodies.lever(group, i);
        let [x, y, moment] = added(i).map(|load| load.force);
        load[0] += x;
        load[1] += y;
        load[2] += moment + lever.perp_dot(DVec2::new(x, y));
    }
    let dof = |k: usize| {
        if let BodyDrive::Imposed(u) = bodies.group_drive(group, k) {
            return Dof::Fixed(fraction * u);
        }
        let mut free = FreeDof { load: load[k], ..FreeDof::default() };
        match analysis.kind {
            AnalysisKind::Static => {}
            AnalysisKind::Compaction { .. } => free = compaction_inertia(bodies, group, k, &mean),
            AnalysisKind::Dynamic { dt, theta } => {
                let dt = dt * fraction;
                let v =
                    if k < 2 { bodies.velocities[row][k] } else { bodies.angular_velocities[row] };
                free.inertia = group.mass_of(k) / (theta * dt * dt);
                free.momentum = free.inertia * v * dt;
                free.load += free.momentum;
            }
        }
        free.inertia += stiffness[k];
        let acted = if k < 2 { acts.0 } else { acts.1 };
        if acted || (free.inertia == 0.0 && free.load != 0.0) {
            Dof::Free(free)
        } else if free.inertia > 0.0 {
            Dof::Fixed(free.load / free.inertia)
        } else {
            Dof::Fixed(0.0)
        }
    };
    ProgramBody { axis: DVec2::X, dofs: [dof(0), dof(1), dof(2)] }
}

/// The degree of freedom of a compaction: the rigid motion that is nearest to the mean motion at
/// the members, with unit weight on each of them.
fn compaction_inertia(
    bodies: &BodyTable,
    group: &GroupRow,
    k: usize,
    mean: &impl Fn(DVec2) -> DVec2,
) -> FreeDof {
    let mut free = FreeDof::default();
    for i in bodies.particles_of(group) {
        let (u, lever) = (mean(bodies.positions[i]), bodies.lever(group, i));
        if k < 2 {
            free.load += u[k];
            free.inertia += 1.0;
        } else {
            free.load += lever.perp_dot(u);
            free.inertia += lever.length_squared() + bodies.radii[i] * bodies.radii[i];
        }
    }
    free
}
