//! Paths of particles within a dynamic increment with restitution.
//!
//! The program finds the velocities v at the end of the increment, and moves bodies by `v dt`.
//! Particles without a sustained contact allow a better path:
//!
//! | particle | displacement in the increment |
//! |---|---|
//! | carries no contact force | `dt (theta v + (1 - theta) v_0)`, theta of the scene |
//! | has one impact, at t, no other contact | `t v_0 + (dt - t) v + a (t^2 - (dt - t)^2)/2` |
//! | has springs or bonds | `dt v` |
//! | any other | `dt (v + e v_0)/(1 + e)` where bodies are hit that touch others, else `dt v` |
//!
//! The second row, in which the loads cause the acceleration a, is the exact path of a single
//! impact under constant loads, friction and rotation included. It also holds for an impact after
//! the step, where `dt v` would overlap; then t = dt. In the last row the impact is at the start of
//! the increment and dissipates `m (1 - e^2) w_0^2/2`, whatever the loads. If a pair of the program
//! would overlap by these paths, both bodies move by `dt v`.

use std::borrow::Cow;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use clastic_components::prelude::*;
use clastic_cone::program::{Dof, Interaction};
use glam::DVec2;

use super::hits::load_acceleration;
use super::push_out::residual_overlap;
use crate::rigid_groups::carry;
use crate::solved::Solved;
use clastic_cone::residuals::Carrying;

/// Kind of path of a particle in an increment.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Path {
    Flight,
    Impact(f64),
    Contact,
    End,
}

/// What the displacements of bodies in an increment depend on beside the solution.
#[derive(SystemParam)]
pub struct Paths<'w> {
    analysis: Res<'w, ClasticAnalysis>,
    acceptance: Res<'w, Acceptance>,
    progress: Res<'w, ClasticProgress>,
    pushed: Res<'w, Pushed>,
    impacts: Res<'w, Impacts>,
}

impl Paths<'_> {
    /// Displacements (m, m, rad) by body in its axes: those that separate rigid overlaps, if any;
    /// otherwise those of the paths, without restitution those of the solution.
    pub fn motion<'a>(&'a self, solved: Solved<'a>) -> Cow<'a, [[f64; 3]]> {
        if let Some(pushed) = &self.pushed.0 {
            return pushed.into();
        }
        let Self { analysis, .. } = self;
        let (Some(theta), AnalysisKind::Dynamic { dt, .. }) = (analysis.path_theta, analysis.kind)
        else {
            return (&solved.solution.displacements).into();
        };
        let dt = dt * self.progress.fraction;
        let step = Step { solved, impacts: &self.impacts, theta, dt };
        let mut kinds = step.kinds();
        let mut out = solved.solution.displacements.clone();
        for (i, kind) in kinds.iter().enumerate() {
            out[i] = step.displacement(i, *kind);
        }
        step.move_groups(&mut out);
        carry(solved.bodies, &mut out);
        let allowed = residual_overlap(&self.acceptance, solved.bodies);
        while step.end_overlaps(allowed, &mut kinds, &mut out) {}
        out.into()
    }
}

/// A dynamic increment and its solution.
struct Step<'a> {
    solved: Solved<'a>,
    impacts: &'a Impacts,
    /// Theta of the scene, which applies to free flight.
    theta: f64,
    /// Time step, s.
    dt: f64,
}

impl Step<'_> {
    /// Displacement of a particle by a kind of path.
    fn displacement(&self, i: usize, kind: Path) -> [f64; 3] {
        let Self { solved: Solved { bodies, program, solution, .. }, dt, theta, .. } = *self;
        let mut u = solution.displacements[i];
        let v_0 = bodies.rates(i);
        for (k, dof) in program.bodies[i].dofs.iter().enumerate() {
            // The displacement of a degree of freedom without interactions is known from its load.
            let is_driven = bodies.drives[i][k] != Default::default();
            match kind {
                _ if is_driven => {}
                Path::End => {}
                Path::Flight => u[k] = theta * u[k] + (1.0 - theta) * v_0[k] * dt,
                Path::Contact => {
                    let share = self.impacts.end_share;
                    u[k] = share * u[k] + (1.0 - share) * v_0[k] * dt;
                }
                Path::Impact(t) => {
                    let left = dt - t;
                    let a = match dof {
                        Dof::Free(free) => load_acceleration(free, dt),
                        Dof::Fixed(u) => (u / dt - v_0[k]) / dt,
                    };
                    u[k] = t * v_0[k] + left * (u[k] / dt) + 0.5 * a * (t * t - left * left);
                }
            }
        }
        u
    }

    /// Moves the rigid groups, by the first row of the table or, with contact forces, the last.
    fn move_groups(&self, out: &mut [[f64; 3]]) {
        let Solved { bodies, program, solution, .. } = self.solved;
        if bodies.groups.is_empty() {
            return;
        }
        let carrying = Carrying::new(program, solution);
        for group in &bodies.groups {
            let row = group.body as usize;
            let is_carried = program.interactions.iter().enumerate().any(|(k, c)| {
                (c.a as usize == row || c.b as usize == row) && carrying.is_carrying(k)
            });
            let share = if is_carried { self.impacts.end_share } else { self.theta };
            let v_0 = bodies.rates(row);
            for k in (0..3).filter(|k| group.drives[*k] == BodyDrive::Free) {
                out[row][k] = share * out[row][k] + (1.0 - share) * v_0[k] * self.dt;
            }
        }
    }

    /// Moves the bodies of rigid pairs that overlap by more than `allowed` (m) by `v dt`. Returns
    /// whether this has changed any displacement.
    fn end_overlaps(&self, allowed: f64, kinds: &mut [Path], out: &mut [[f64; 3]]) -> bool {
        let mut changed = false;
        for (contact, c, _) in self.solved.contacts() {
            let is_rigid = !(c.normal_compliance > 0.0 || c.limits.has_strength());
            if !is_rigid || self.gap(contact, out) >= -allowed {
                continue;
            }
            for i in [contact.a, contact.b].map(|i| i as usize) {
                if kinds.get(i).is_some_and(|kind| *kind != Path::End) {
                    kinds[i] = Path::End;
                    changed = true;
                    self.move_to_end(i, out);
                }
            }
        }
        changed
    }

    /// Gap of a pair after these displacements, m.
    fn gap(&self, contact: &Contact, out: &[[f64; 3]]) -> f64 {
        let Solved { bodies, program, .. } = self.solved;
        let (a, b) = (contact.a as usize, contact.b as usize);
        let place = |u: &[f64; 3]| DVec2::new(u[0], u[1]);
        let moved = place(&program.bodies[b].to_global(out[b])) - place(&out[a]);
        if let Some(radius) = bodies.radii.get(b) {
            let distance = (bodies.positions[b] - bodies.positions[a] + moved).length();
            return distance - bodies.radii[a] - radius;
        }
        match bodies.wall(contact.b).filter(|wall| !wall.is_line() || out[b][2] != 0.0) {
            Some(wall) => {
                let place = bodies.positions[a] - moved;
                let wall = wall.turned(out[b][2]);
                wall.nearest(bodies.positions[b], place).distance - bodies.radii[a]
            }
            None => contact.gap + contact.normal.dot(moved),
        }
    }

    /// Moves a particle, or the group that it belongs to, by `v dt`.
    fn move_to_end(&self, i: usize, out: &mut [[f64; 3]]) {
        let Solved { bodies, solution, .. } = self.solved;
        let Some(group) = bodies.group(i) else {
            out[i] = self.displacement(i, Path::End);
            return;
        };
        for j in group.members.iter().chain([&group.body]).map(|j| *j as usize) {
            out[j] = solution.displacements[j];
        }
    }

    /// Kinds of the paths of the particles.
    fn kinds(&self) -> Vec<Path> {
        let Solved { bodies, program, solution, .. } = self.solved;
        let n = bodies.particles;
        let carrying = Carrying::new(program, solution);
        let mut carried = vec![0_u32; program.bodies.len()];
        for (k, c) in program.interactions.iter().enumerate() {
            if carrying.is_carrying(k) {
                carried[c.a as usize] += 1;
                carried[c.b as usize] += 1;
            }
        }
        let of = |carried: &u32| if *carried == 0 { Path::Flight } else { Path::Contact };
        let mut kinds: Vec<_> = carried[..n].iter().map(of).collect();
        for impact in &self.impacts.single {
            let c = &program.interactions[impact.interaction];
            let pair = [c.a as usize, c.b as usize];
            // A pair that would meet after the end of the step carries no force.
            let own = u32::from(carrying.is_carrying(impact.interaction));
            let is_alone =
                |i: &usize| *i >= n || !program.bodies[*i].is_free() || carried[*i] == own;
            if pair.iter().all(is_alone) {
                for i in pair.into_iter().filter(|i| *i < n) {
                    kinds[i] = Path::Impact(impact.time);
                }
            }
        }
        let is_soft = |c: &&Interaction| {
            c.normal_compliance > 0.0
                || c.tangential_compliance > 0.0
                || c.rolling_compliance > 0.0
                || c.limits.has_strength()
        };
        for c in program.interactions.iter().filter(is_soft) {
            for i in [c.a as usize, c.b as usize].into_iter().filter(|i| *i < n) {
                if carried[i] > 0 {
                    kinds[i] = Path::End;
                }
            }
        }
        kinds
    }
}
