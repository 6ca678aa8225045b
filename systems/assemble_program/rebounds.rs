//! Rebounds: what a rigid contact with restitution is hit with, and the offset that makes it rebound.
//!
//! Where a scene has restitution, velocities are those of theta = 1: the displacement of the program is
//! `u = v dt`, v the velocity at the end, and an offset g bounds the closing speed at the end, `w <= g/dt`.
//! Newton's law of restitution at the velocity level (Moreau 1988) is then an offset. With e of the contact,
//! w_0 the closing speed at the start and a the closing acceleration by the loads of both bodies:
//!
//! | contact | bound of the closing speed w at the end |
//! |---|---|
//! | hit at the time t of the step, by bodies that touch nothing else | `-(e w_i - a (dt - t))`, `w_i^2 = w_0^2 + 2 a g_0` |
//! | hit, by bodies of which one touches others | `-(e w_0 - a_p dt)`, a_p what presses of a |
//! | not hit, separating at the start | `max(g_0, e \|w_0\| dt)/dt` |
//! | any other | `g_0/dt` |
//!
//! A rebound that the loads turn round before the step ends, the bracket at most zero, is none: the contact stays
//! closed. So a grain comes to rest under gravity, and no speed has to be called small.
//!
//! Contacts of the third kind may approach as fast as Newton's law lets them, so that bodies between walls always
//! have a solution, `v = -e v_0`. What they overlap by is taken out by the next increment
//! ([`push_out`](crate::attempt::push_out)).

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::body::Drive;
use clastic_components::contact::{Bodies, Contact, Contacts};
use clastic_components::findings::{Impact, Impacts, Pushed};
use clastic_components::increment::{Analysis, AnalysisKind, Progress};
use clastic_components::material::Materials;
use clastic_components::program::{ConeProgram, Dof, FreeDof, Interaction};
use clastic_components::wall::WallDrive;

use super::interactions::contact_law;
use crate::attempt::push_out::{LEAST, overlaps};

/// Run condition: contacts have restitution in this stage.
pub fn has_restitution(analysis: Res<Analysis>) -> bool {
    analysis.path_theta.is_some() && matches!(analysis.kind, AnalysisKind::Dynamic { .. })
}

/// Sets the offsets of contacts that are hit, and fills [`Impacts`].
pub fn assemble_rebounds(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    materials: Res<Materials>,
    analysis: Res<Analysis>,
    progress: Res<Progress>,
    pushed: Res<Pushed>,
    mut program: ResMut<ConeProgram>,
    mut impacts: ResMut<Impacts>,
) {
    impacts.0.clear();
    let AnalysisKind::Dynamic { dt, .. } = analysis.kind else { return };
    let step = Step { dt: dt * progress.fraction, whole: dt };
    if pushed.0.is_none() && overlaps(&bodies, &contacts, &program) {
        // This solution takes out overlaps. The next one has the velocities.
        return;
    }
    let touch = LEAST * bodies.mean_radius;
    let motions: Vec<_> =
        (0..bodies.positions.len()).map(|i| step.motion(&bodies, &program, i)).collect();
    let approaches: Vec<_> = contacts
        .0
        .iter()
        .zip(&program.interactions)
        .map(|(contact, c)| Approach::of(&motions, contact, c))
        .collect();
    // How many others each body touches, or would hit.
    let mut touched = vec![0_u32; bodies.positions.len()];
    for ((contact, c), approach) in contacts.0.iter().zip(&program.interactions).zip(&approaches) {
        let hit = approach.and_then(|x| x.hit(step.dt)).is_some();
        if c.limits.has_strength() || contact.gap <= touch || hit {
            touched[c.a as usize] += 1;
            touched[c.b as usize] += 1;
        }
    }
    let ConeProgram { bodies: rows, interactions, .. } = &mut *program;
    for (k, (contact, c)) in contacts.0.iter().zip(interactions).enumerate() {
        let is_free = |body: u32| rows[body as usize].is_free();
        let Some(approach) = approaches[k].filter(|_| is_free(c.a) || is_free(c.b)) else {
            continue;
        };
        let law = contact_law(&bodies, &materials, &analysis, contact);
        if c.normal_compliance > 0.0 || c.limits.has_strength() || law.restitution == 0.0 {
            continue;
        }
        let is_alone = |body: u32| !is_free(body) || touched[body as usize] == 1;
        let alone = is_alone(c.a) && is_alone(c.b);
        match approach.hit(step.dt) {
            Some(hit) if alone => {
                let left = step.dt - hit.time;
                let rebound = law.restitution * hit.speed - approach.acceleration * left;
                if rebound > 0.0 {
                    c.offset = -rebound * step.dt;
                    impacts.0.push(Impact { interaction: k, time: hit.time });
                }
            }
            Some(_) => {
                let rebound = law.restitution * approach.speed - approach.pressing * step.dt;
                if rebound > 0.0 {
                    c.offset = -rebound * step.dt;
                }
            }
            None => c.offset = c.offset.max(-law.restitution * approach.speed * step.dt),
        }
    }
}

/// Time of the trial, and of a whole increment, s.
struct Step {
    dt: f64,
    whole: f64,
}

/// Velocity at the start (m/s) and acceleration by the loads (m/s^2) of a body.
#[derive(Clone, Copy)]
struct Motion {
    velocity: DVec2,
    acceleration: DVec2,
}

impl Step {
    /// None for a wall under a load: it has no mass, and what hits it does not rebound.
    fn motion(&self, bodies: &Bodies, program: &ConeProgram, i: usize) -> Option<Motion> {
        if i < bodies.particles {
            let mut motion = Motion { velocity: bodies.velocities[i], acceleration: DVec2::ZERO };
            for k in 0..2 {
                // What is driven has its velocity from the start of the increment on.
                if let Drive::Imposed(u) = bodies.drive(i, k) {
                    motion.velocity[k] = u / self.whole;
                } else if let Dof::Free(free) = &program.bodies[i].dofs[k] {
                    motion.acceleration[k] = load_acceleration(free, self.dt);
                }
            }
            return Some(motion);
        }
        let wall = bodies.walls.iter().find(|wall| wall.body as usize == i)?;
        match bodies.wall_drive(wall) {
            WallDrive::Imposed(u) => {
                Some(Motion { velocity: u / self.whole, acceleration: DVec2::ZERO })
            }
            WallDrive::Loaded(_) => None,
        }
    }
}

/// Acceleration of a degree of freedom by its loads alone, m/s^2 or rad/s^2, with theta = 1.
#[must_use]
pub fn load_acceleration(free: &FreeDof, dt: f64) -> f64 {
    (free.load - free.momentum) / (free.inertia * dt * dt)
}

/// How two bodies approach each other.
#[derive(Clone, Copy)]
struct Approach {
    /// Gap at the start, m; overlaps are a touch.
    gap: f64,
    /// Closing speed at the start, m/s.
    speed: f64,
    /// Closing acceleration by the loads of both, m/s^2.
    acceleration: f64,
    /// Of it what presses: another contact may take what pulls a body away.
    pressing: f64,
}

/// Where the loads alone bring two bodies together.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hit {
    /// From the start of the step, s.
    time: f64,
    /// Closing speed there, m/s.
    speed: f64,
}

impl Approach {
    fn of(motions: &[Option<Motion>], contact: &Contact, c: &Interaction) -> Option<Self> {
        let (a, b) = (motions[c.a as usize]?, motions[c.b as usize]?);
        let (of_a, of_b) = (c.normal.dot(a.acceleration), -c.normal.dot(b.acceleration));
        Some(Self {
            gap: contact.gap.max(0.0),
            speed: c.normal.dot(a.velocity - b.velocity),
            acceleration: of_a + of_b,
            pressing: of_a.max(0.0) + of_b.max(0.0),
        })
    }

    /// The hit within a step, if there is one: the first root of `g_0 = w_0 t + a t^2/2`.
    fn hit(&self, dt: f64) -> Option<Hit> {
        let speed = (self.speed * self.speed + 2.0 * self.acceleration * self.gap).sqrt();
        let time = if self.speed >= 0.0 {
            2.0 * self.gap / (self.speed + speed)
        } else if self.acceleration > 0.0 {
            (speed - self.speed) / self.acceleration
        } else {
            return None;
        };
        // Not a number where the bodies rest on each other, or where the loads part them before.
        (time <= dt).then_some(Hit { time, speed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn approach(gap: f64, speed: f64, acceleration: f64) -> Approach {
        Approach { gap, speed, acceleration, pressing: acceleration.max(0.0) }
    }

    #[test]
    fn a_hit_is_where_the_parabola_meets_the_gap() {
        for (gap, speed, a) in
            [(0.3, 2.0, 0.0), (0.3, 2.0, 9.81), (0.3, 2.0, -5.0), (0.1, -0.4, 9.81)]
        {
            let hit = approach(gap, speed, a).hit(1.0).unwrap();
            assert!((speed * hit.time + 0.5 * a * hit.time * hit.time - gap).abs() < 1e-14);
            assert!((speed + a * hit.time - hit.speed).abs() < 1e-14);
            assert!(hit.speed > 0.0);
            assert_eq!(approach(gap, speed, a).hit(0.99 * hit.time), None);
        }
        assert_eq!(approach(0.0, 2.0, 9.81).hit(1.0), Some(Hit { time: 0.0, speed: 2.0 }));
    }

    #[test]
    fn what_rests_parts_or_stops_before_hits_nothing() {
        for (gap, speed, a) in [
            (0.0, 0.0, 9.81),
            (0.0, 0.0, 0.0),
            (0.3, 0.0, 0.0),
            (0.3, 2.0, -9.81),
            (0.0, -1.0, 0.0),
        ] {
            assert_eq!(approach(gap, speed, a).hit(1.0), None);
        }
    }
}
