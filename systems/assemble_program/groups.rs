//! Rigid groups in the program: the forces on members act on the body of the group, with arms about
//! its centre. The rows of members are those of bodies whose motion is known.

use clastic_components::body::BodyDrive;
use clastic_components::contact::BodyTable;
use clastic_components::increment::{AnalysisKind, ClasticAnalysis};
use clastic_components::rigid_group::GroupRow;
use clastic_cone::program::{Dof, FreeDof, Interaction, ProgramBody};
use glam::DVec2;

use super::balance::Rows;

/// Moves the forces on members of rigid groups to the bodies of the groups. A time step that keeps the
/// energy has a `guess` of the displacements, by body in its own axes; empty otherwise.
pub fn join(bodies: &BodyTable, guess: &[[f64; 3]], interactions: &mut [Interaction]) {
    if bodies.groups.is_empty() {
        return;
    }
    for c in interactions {
        for (body, first) in [(c.a, true), (c.b, false)] {
            if let Some(group) = bodies.group(body as usize) {
                let lever = lever(bodies, group, body as usize, guess);
                *c = c.carried_by(first, group.body, lever);
            }
        }
    }
}

/// Lever of a member about the centre of its group in the program: that of the start without a `guess`,
/// and for a wall, whose arm from its contacts to its place is of the start too.
///
/// If the group turns by the angle a of the guess, a particle has the lever l' with which the motion to
/// first order is the finite one, `a perp(l') = (R - 1) l`: forces do the work of the finite motion.
pub(crate) fn lever(
    bodies: &BodyTable,
    group: &GroupRow,
    member: usize,
    guess: &[[f64; 3]],
) -> DVec2 {
    let lever = bodies.lever(group, member);
    match guess.get(group.body as usize) {
        Some([_, _, angle]) if *angle != 0.0 && member < bodies.particles => {
            let half = (0.5 * angle).sin();
            (angle.sin() * lever + 2.0 * half * half * lever.perp()) / *angle
        }
        _ => lever,
    }
}

/// What the moment of weight and loads of the members about the body of a group loses in a time step,
/// N m, and loses with the rotation, N m/rad: they keep their directions while the levers turn.
///
/// With theta = 1/2 the moment is the work along the finite rotation over the rotation: with the moment
/// of the start a pendulum would gain energy. With theta = 1, which takes energy, it is that of the
/// start. Half of the inertia is always left.
pub(crate) fn lost_by_turning(
    bodies: &BodyTable,
    group: &GroupRow,
    fraction: f64,
    analysis: &ClasticAnalysis,
) -> [f64; 2] {
    let AnalysisKind::Dynamic { dt, theta } = analysis.kind else { return [0.0; 2] };
    let (dt, inertia) = (fraction * dt, group.mass_of(2));
    if !(inertia > 0.0) {
        // A group of walls has no weight either.
        return [0.0; 2];
    }
    let (mut along, mut across) = (0.0, 0.0);
    for i in bodies.particles_of(group) {
        let [x, y, _] = bodies.loads[i].map(|ramp| ramp.at(fraction));
        let force = DVec2::new(x, y) + bodies.masses[i] * analysis.gravity;
        let lever = bodies.lever(group, i);
        along += lever.dot(force);
        across += lever.perp_dot(force);
    }
    // The work along a rotation a is `across sin a - along (1 - cos a)`. The angle is predicted with
    // the acceleration: without it the pendulum would still gain energy, of third order.
    let rate = bodies.rates(group.body as usize)[2] + 0.5 * dt * across / inertia;
    let angle = 2.0 * (1.0 - theta) * rate * dt;
    let (sine, cosine) = if angle.abs() > 1e-4 {
        (angle.sin() / angle, (1.0 - angle.cos()) / angle.powi(2))
    } else {
        (1.0, 0.5)
    };
    let stiffness = 2.0 * (1.0 - theta) * along * cosine;
    [across * (1.0 - sine), stiffness.max(-0.5 * inertia / (theta * dt * dt))]
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
                let [moment, stiffness] = lost_by_turning(bodies, group, fraction, self.analysis);
                free.load -= moment;
                free.inertia += stiffness;
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
