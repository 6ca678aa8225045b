//! Paths of particles within a dynamic increment with restitution.
//!
//! The program has velocities and moves bodies by `v dt` with the velocity v at the end. Particles
//! without a sustained contact allow a better path:
//!
//! | particle | displacement in the increment |
//! |---|---|
//! | carries no contact force | `dt (theta v + (1 - theta) v_0)`, theta of the scene |
//! | has one impact, at t, no other contact | `t v_0 + (dt - t) v + a (t^2 - (dt - t)^2)/2` |
//! | has springs or bonds | `dt v` |
//! | any other | `dt (v + e v_0)/(1 + e)` where bodies are hit that touch others, else `dt v` |
//!
//! The second row, with the acceleration a by the loads, is the exact path of a single impact under
//! constant loads, friction and rotation included. It also holds for an impact after the step,
//! where `dt v` would overlap; then t = dt. In the last row the impact is at the start of the
//! increment and dissipates `m (1 - e^2) w_0^2/2`, whatever the loads. If a pair of the program
//! would overlap by these paths, both bodies move by `dt v`.

use clastic_components::body::Drive;
use clastic_components::contact::{Bodies, Contacts};
use clastic_components::findings::Impacts;
use clastic_components::increment::{Acceptance, Analysis, AnalysisKind, Progress};
use clastic_cone::program::{ConeProgram, ConeSolution, Dof, Interaction};
use glam::DVec2;

use crate::assemble_program::hits::load_acceleration;
use crate::attempt::push_out::residual_overlap;
use crate::rigid_groups::carry;
use clastic_cone::residuals::Carrying;

/// Kind of path of a particle in an increment.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Path {
    Flight,
    Impact(f64),
    Contact,
    End,
}

/// Displacements by body in the axes of the body; `None` if no contact has restitution.
#[must_use]
pub fn paths(
    bodies: &Bodies,
    contacts: &Contacts,
    analysis: &Analysis,
    acceptance: &Acceptance,
    progress: &Progress,
    program: &ConeProgram,
    solution: &ConeSolution,
    impacts: &Impacts,
) -> Option<Vec<[f64; 3]>> {
    let (Some(theta), AnalysisKind::Dynamic { dt, .. }) = (analysis.path_theta, analysis.kind)
    else {
        return None;
    };
    let dt = dt * progress.fraction;
    let n = bodies.particles;
    let mut kinds = kinds(n, program, solution, impacts);
    let displacement = |i: usize, kind: Path| {
        let mut u = solution.displacements[i];
        let v_0 = [bodies.velocities[i].x, bodies.velocities[i].y, bodies.angular_velocities[i]];
        for (k, dof) in program.bodies[i].dofs.iter().enumerate() {
            // The displacement of a degree of freedom without interactions is known from its load.
            let is_driven = bodies.drives[i][k] != Default::default();
            match kind {
                _ if is_driven => {}
                Path::End => {}
                Path::Flight => u[k] = theta * u[k] + (1.0 - theta) * v_0[k] * dt,
                Path::Contact => {
                    let share = impacts.end_share;
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
    };
    let mut out = solution.displacements.clone();
    for i in 0..n {
        out[i] = displacement(i, kinds[i]);
    }
    let carrying = (!bodies.groups.is_empty()).then(|| Carrying::new(program, solution));
    for group in &bodies.groups {
        let row = group.body as usize;
        let acts = |k: usize| {
            let c = &program.interactions[k];
            c.a as usize == row || c.b as usize == row
        };
        let is_carried = carrying.as_ref().is_some_and(|carrying| {
            (0..program.interactions.len()).any(|k| acts(k) && carrying.is_carrying(k))
        });
        let share = if is_carried { impacts.end_share } else { theta };
        let v_0 = bodies.velocities[row];
        let v_0 = [v_0.x, v_0.y, bodies.angular_velocities[row]];
        for k in (0..3).filter(|k| group.drives[*k] == Drive::Free) {
            out[row][k] = share * out[row][k] + (1.0 - share) * v_0[k] * dt;
        }
    }
    carry(bodies, &mut out);
    let place = |u: &[f64; 3]| DVec2::new(u[0], u[1]);
    loop {
        let mut changed = false;
        for (contact, c) in contacts.0.iter().zip(&program.interactions) {
            let (a, b) = (contact.a as usize, contact.b as usize);
            if c.normal_compliance > 0.0 || c.limits.has_strength() {
                continue;
            }
            let moved = place(&program.bodies[b].to_global(out[b])) - place(&out[a]);
            let gap = match bodies.radii.get(b) {
                Some(radius) => {
                    let distance = (bodies.positions[b] - bodies.positions[a] + moved).length();
                    distance - bodies.radii[a] - radius
                }
                None => match bodies
                    .walls
                    .iter()
                    .find(|w| w.body as usize == b && (!w.is_line() || out[b][2] != 0.0))
                {
                    Some(wall) => {
                        let place = bodies.positions[a] - moved;
                        let wall = wall.turned(out[b][2]);
                        wall.nearest(bodies.positions[b], place).distance - bodies.radii[a]
                    }
                    None => contact.gap + contact.normal.dot(moved),
                },
            };
            if gap >= -residual_overlap(acceptance, bodies) {
                continue;
            }
            for i in [a, b].into_iter().filter(|i| *i < n) {
                if kinds[i] != Path::End {
                    kinds[i] = Path::End;
                    changed = true;
                    let Some(group) = bodies.group(i) else {
                        out[i] = displacement(i, Path::End);
                        continue;
                    };
                    let row = group.body as usize;
                    out[row] = solution.displacements[row];
                    for j in group.members.iter().map(|j| *j as usize) {
                        out[j] = solution.displacements[j];
                    }
                }
            }
        }
        if !changed {
            return Some(out);
        }
    }
}

fn kinds(n: usize, program: &ConeProgram, solution: &ConeSolution, impacts: &Impacts) -> Vec<Path> {
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
    for impact in &impacts.single {
        let c = &program.interactions[impact.interaction];
        let pair = [c.a as usize, c.b as usize];
        // A pair that would meet after the end of the step carries no force.
        let own = u32::from(carrying.is_carrying(impact.interaction));
        let is_alone = |i: &usize| *i >= n || !program.bodies[*i].is_free() || carried[*i] == own;
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
