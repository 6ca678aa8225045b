//! Rigid groups in the program: the forces on members act on the body of the group, with arms about
//! its centre. The rows of members are those of bodies whose motion is known.

use clastic_components::body::BodyDrive;
use clastic_components::contact::BodyTable;
use clastic_components::increment::{AnalysisKind, ClasticAnalysis};
use clastic_components::rigid_group::GroupRow;
use clastic_cone::program::{Dof, FreeDof, Interaction, ProgramBody};
use glam::DVec2;

use super::balance::Rows;

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

/// What the moment of weight and loads of the members about the body of a group loses with its
/// rotation in a time step, N m/rad: they keep their directions while the levers turn.
///
/// The moment is the one where the geometry of the step is, after the part 1 - theta of the rotation.
/// With that of the start and theta = 1/2 a pendulum gains energy. Half of the inertia is always left.
pub(crate) fn turning_stiffness(
    bodies: &BodyTable,
    group: &GroupRow,
    fraction: f64,
    analysis: &ClasticAnalysis,
) -> f64 {
    let AnalysisKind::Dynamic { dt, theta } = analysis.kind else { return 0.0 };
    let of = |i: usize| {
        let [x, y, _] = bodies.loads[i].map(|ramp| ramp.at(fraction));
        bodies.lever(group, i).dot(DVec2::new(x, y) + bodies.masses[i] * analysis.gravity)
    };
    let lost: f64 = bodies.particles_of(group).map(of).sum();
    let inertia = group.mass_of(2) / (theta * (fraction * dt).powi(2));
    ((1.0 - theta) * lost).max(-0.5 * inertia)
}

impl Rows<'_> {
    /// The body of a group: its loads, and its inertia in dynamics.
    pub(super) fn group(&self, group: &GroupRow) -> ProgramBody {
        let (bodies, row) = (self.bodies, group.body as usize);
        let fraction = self.progress.fraction;
        let mut load = bodies.load_on_group(group, fraction, self.analysis.gravity);
        for k in 0..3 {
            load[k] += self.added(row)[k].force;
        }
        for i in group.members.iter().map(|i| *i as usize) {
            let lever = bodies.lever(group, i);
            let [x, y, moment] = self.added(i).map(|load| load.force);
            load[0] += x;
            load[1] += y;
            load[2] += moment + lever.perp_dot(DVec2::new(x, y));
        }
        let dof = |k: usize| {
            if let BodyDrive::Imposed(u) = bodies.group_drive(group, k) {
                return Dof::Fixed(fraction * u);
            }
            let mut free = match self.analysis.kind {
                AnalysisKind::Compaction { .. } => self.compaction_of(group, k),
                _ => FreeDof { load: load[k], ..FreeDof::default() },
            };
            self.add_inertia(row, k, group.mass_of(k), &mut free);
            if k == 2 {
                free.inertia += turning_stiffness(bodies, group, fraction, self.analysis);
            }
            free.inertia += self.added(row)[k].stiffness;
            self.undriven(row, k, free)
        };
        ProgramBody { axis: DVec2::X, dofs: [dof(0), dof(1), dof(2)] }
    }

    /// The degree of freedom of a compaction: the rigid motion that is nearest to the mean motion at
    /// the members, with unit weight on each of them.
    fn compaction_of(&self, group: &GroupRow, k: usize) -> FreeDof {
        let bodies = self.bodies;
        let mut free = FreeDof::default();
        for i in bodies.particles_of(group) {
            let (u, lever) = (self.mean(bodies.positions[i]), bodies.lever(group, i));
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
}
