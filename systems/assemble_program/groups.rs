//! Rigid groups in the program: the forces on members act on the body of the group, with arms about
//! its centre. The rows of members are those of bodies whose motion is known.

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Dof, FreeDof, Interaction, ProgramBody};
use glam::DVec2;

use super::balance::Rows;

/// Moves the forces on members of rigid groups to the bodies of the groups, with their levers.
pub fn join(
    bodies: &BodyTable,
    theta: Option<f64>,
    guess: &[[f64; 3]],
    interactions: &mut [Interaction],
) {
    if bodies.groups.is_empty() {
        return;
    }
    for c in interactions {
        for (body, first) in [(c.a, true), (c.b, false)] {
            if let Some(group) = bodies.group(body as usize) {
                let lever = lever(bodies, group, body as usize, theta, guess);
                *c = c.carried_by(first, group.body, lever);
            }
        }
    }
}

/// Lever of a member about the centre of its group in the program: that of the start without a `guess` of
/// the displacements, by body in its own axes, and for a wall, whose arm from its contacts to its place is
/// of the start too.
///
/// If the group turns by the angle a of the guess, a particle has in statics (`theta` is `None`) the
/// lever R l of the end, where moments are in equilibrium. In a time step with theta < 1 it has the lever
/// l' with which the motion to first order is the finite one, `a perp(l') = (R - 1) l`: forces do the work
/// of the finite motion.
pub(crate) fn lever(
    bodies: &BodyTable,
    group: &GroupRow,
    member: usize,
    theta: Option<f64>,
    guess: &[[f64; 3]],
) -> DVec2 {
    let lever = bodies.lever(group, member);
    let angle = guess.get(group.body as usize).map_or(0.0, |u| u[2]);
    if angle == 0.0 || member >= bodies.particles {
        return lever;
    }
    match theta {
        None => DVec2::from_angle(angle).rotate(lever),
        Some(theta) if theta < 1.0 => {
            let half = (0.5 * angle).sin();
            (angle.sin() * lever + 2.0 * half * half * lever.perp()) / angle
        }
        Some(_) => lever,
    }
}

/// What the moment of weight and loads of the members about the body of a group loses in a time step,
/// N m, and loses with the rotation, N m/rad: they keep their directions while the levers turn.
///
/// With theta = 1/2 the moment is the work along the finite rotation over the rotation: with the moment
/// of the start a pendulum would gain energy. With theta = 1, which dissipates energy, it is that
/// of the start. Half of the inertia is always left.
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
        let force = bodies.force_on(i, fraction, analysis.gravity);
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

/// How a rigid group turns in statics: forces keep their directions while its levers turn.
pub(crate) struct Turning<'a> {
    /// The group.
    pub group: &'a GroupRow,
    /// Rotation of the guess, rad, about which the program has the moment to first order.
    angle: f64,
    /// Moment, N m, that weight and loads of the members have lost there.
    lost: f64,
    /// Geometric stiffness, N m/rad. A rotation meets the moment `sum l . F` a radian, with the levers l
    /// of the members and all forces F on them, so that a group that hangs is turned back. Those of
    /// contacts and bonds are of the last increment. A negative sum would make the program non-convex
    /// and counts as zero, as for compressed [bonds](super::taut).
    stiffness: f64,
}

impl Turning<'_> {
    /// Moment, N m, that the group loses in the program where it turns by `angle`, rad.
    pub(crate) fn lost_at(&self, angle: f64) -> f64 {
        self.lost + self.stiffness * (angle - self.angle)
    }
}

/// Moment, N m, that weight and loads of the members lose where the group turns by `angle`, rad.
pub(crate) fn lost_at(
    bodies: &BodyTable,
    group: &GroupRow,
    fraction: f64,
    gravity: DVec2,
    angle: f64,
) -> f64 {
    let moment = |i: usize| {
        let lever = bodies.lever(group, i);
        let left = lever - DVec2::from_angle(angle).rotate(lever);
        left.perp_dot(bodies.force_on(i, fraction, gravity))
    };
    if angle == 0.0 { 0.0 } else { bodies.particles_of(group).map(moment).sum() }
}

/// The turning of every rigid group about a `guess` of the displacements, by body in its own axes.
pub(crate) fn turning<'a>(
    bodies: &'a BodyTable,
    contacts: &ContactTable,
    program: &ConeProgram,
    fraction: f64,
    gravity: DVec2,
    guess: &[[f64; 3]],
) -> Vec<Turning<'a>> {
    let of_loads = |group: &'a GroupRow| {
        let along = |i| bodies.lever(group, i).dot(bodies.force_on(i, fraction, gravity));
        let angle = guess.get(group.body as usize).map_or(0.0, |u| u[2]);
        Turning {
            group,
            angle,
            lost: lost_at(bodies, group, fraction, gravity, angle),
            stiffness: bodies.particles_of(group).map(along).sum(),
        }
    };
    let mut all: Vec<_> = bodies.groups.iter().map(of_loads).collect();
    if all.is_empty() {
        return all;
    }
    let first = bodies.first_group();
    let interactions = program.interactions.iter().zip(&program.last_forces);
    for (contact, (c, [p, q, _])) in contacts.0.iter().zip(interactions) {
        let force = *p * c.normal + *q * c.normal.perp();
        for (member, sign) in [(contact.a, -1.0), (contact.b, 1.0)] {
            let member = member as usize;
            if let Some(group) = bodies.group(member).filter(|_| member < bodies.particles) {
                let along = sign * bodies.lever(group, member).dot(force);
                all[group.body as usize - first].stiffness += along;
            }
        }
    }
    all.iter_mut().for_each(|turning| turning.stiffness = turning.stiffness.max(0.0));
    all
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
                let [moment, stiffness] = self.by_turning(group);
                free.load -= moment;
                free.inertia += stiffness;
            }
            free.inertia += self.added(row)[k].stiffness;
            self.undriven(row, k, free)
        };
        ProgramBody { axis: DVec2::X, dofs: [dof(0), dof(1), dof(2)] }
    }

    /// What the moment of a group loses by its turn, N m, and loses with its rotation, N m/rad.
    fn by_turning(&self, group: &GroupRow) -> [f64; 2] {
        let Self { bodies, analysis, .. } = *self;
        let fraction = self.progress.fraction;
        if analysis.kind != AnalysisKind::Static {
            return lost_by_turning(bodies, group, fraction, analysis);
        }
        let turning = &self.turning[group.body as usize - bodies.first_group()];
        [turning.lost_at(0.0), turning.stiffness]
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
