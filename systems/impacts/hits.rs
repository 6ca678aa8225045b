//! Collisions of two bodies under their loads alone, as restitution needs them.

use glam::DVec2;

use clastic_components::prelude::*;
use clastic_cone::program::{ConeProgram, Dof, FreeDof, Interaction};

/// Velocity at the start (m/s) and acceleration by the loads (m/s^2) of a body.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Velocity, m/s.
    pub velocity: DVec2,
    /// Acceleration, m/s^2.
    pub acceleration: DVec2,
    /// Angular velocity, rad/s, of a body on which normal forces have an arm.
    pub spin: f64,
    /// Its angular acceleration, rad/s^2.
    pub angular_acceleration: f64,
}

impl Motion {
    /// Motion of a body in a trial of `dt` within an increment of `whole` (s). `None` for a loaded
    /// wall: it has no mass, and a body that hits it does not rebound.
    pub fn of(
        bodies: &BodyTable,
        program: &ConeProgram,
        [dt, whole]: [f64; 2],
        i: usize,
    ) -> Option<Self> {
        let group = bodies.group_at(i);
        if i < bodies.particles || group.is_some() {
            let drive = |k| match group {
                Some(group) => bodies.group_drive(group, k),
                None => bodies.drive(i, k),
            };
            let is_free = |k| drive(k) == BodyDrive::Free;
            if group.is_some_and(|group| group.mass == 0.0) && (0..3).any(is_free) {
                // Walls without particles have no mass.
                return None;
            }
            let (mut rates, mut gains) = (bodies.rates(i), [0.0; 3]);
            for k in 0..3 {
                // A driven body has its velocity from the start of the increment on.
                if let BodyDrive::Imposed(u) = drive(k) {
                    rates[k] = u / whole;
                } else if let Dof::Free(free) = &program.bodies[i].dofs[k] {
                    gains[k] = load_acceleration(free, dt);
                }
            }
            // Normal forces have no arm on a particle.
            let turning = group.map_or([0.0; 2], |_| [rates[2], gains[2]]);
            return Some(Self {
                velocity: DVec2::new(rates[0], rates[1]),
                acceleration: DVec2::new(gains[0], gains[1]),
                spin: turning[0],
                angular_acceleration: turning[1],
            });
        }
        match bodies.wall_drive(bodies.wall(i as u32)?) {
            WallDrive::Imposed(u) => Some(Self { velocity: u / whole, ..Self::default() }),
            WallDrive::Turning { about, angle } => {
                let spin = angle / whole;
                let velocity = spin * (bodies.positions[i] - about).perp();
                Some(Self { velocity, spin, ..Self::default() })
            }
            WallDrive::Loaded(_) | WallDrive::Sliding { .. } => None,
        }
    }

    fn moved(&self, t: f64) -> DVec2 {
        t * self.velocity + 0.5 * t * t * self.acceleration
    }
}

/// Acceleration of a degree of freedom by its loads alone, m/s^2 or rad/s^2, with theta = 1.
pub(crate) fn load_acceleration(free: &FreeDof, dt: f64) -> f64 {
    (free.load - free.momentum) / (free.inertia * dt * dt)
}

/// Relative motion of two bodies along the normal at the start.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// Gap at the start, m. An overlap counts as 0.
    pub gap: f64,
    /// Closing speed at the start, m/s.
    pub speed: f64,
    /// Closing acceleration that the loads of the two bodies cause, m/s^2.
    pub acceleration: f64,
    /// Acceleration of each body towards the other by its loads, m/s^2. A load that pulls the body
    /// away counts as 0, because another contact may carry it.
    pub pressing: f64,
}

/// An impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Time from the start of the step, s.
    pub time: f64,
    /// Closing speed at the impact, m/s.
    pub speed: f64,
    /// Closing acceleration by the loads at the impact, m/s^2.
    pub acceleration: f64,
    /// Unit normal from a to b at the impact.
    pub normal: DVec2,
}

/// Maximum number of Newton steps to the time of an impact. They converge from below, since the
/// distance is convex.
const MAX_STEPS: u32 = 60;
/// Gap that counts as zero, over the sum of the radii: a few units of round-off.
const ROUND_OFF: f64 = 1e-15;
/// Overlap at an impact on the inside of an arc, over the radius. It is far below the tolerance of
/// gaps.
const RESIDUAL: f64 = 1e-12;

impl Approach {
    /// The approach of the two bodies of a contact.
    pub fn of(motions: &[Option<Motion>], contact: &Contact, c: &Interaction) -> Option<Self> {
        let (a, b) = (motions[c.a as usize]?, motions[c.b as usize]?);
        let turning = c.normal_arm_a * a.spin + c.normal_arm_b * b.spin;
        let (of_a, of_b) = (
            c.normal.dot(a.acceleration) + c.normal_arm_a * a.angular_acceleration,
            -c.normal.dot(b.acceleration) + c.normal_arm_b * b.angular_acceleration,
        );
        Some(Self {
            gap: contact.gap.max(0.0),
            speed: c.normal.dot(a.velocity - b.velocity) + turning,
            acceleration: of_a + of_b,
            pressing: of_a.max(0.0) + of_b.max(0.0),
        })
    }

    /// Closing in a step with the end velocity of free motion, m.
    pub(crate) fn free_closing(&self, dt: f64) -> f64 {
        (self.speed + self.acceleration * dt) * dt
    }

    /// Time and closing speed of the impact along the normal within a step, if any. The time is the
    /// first root of `g_0 = w_0 t + a t^2/2`.
    pub fn hit(&self, dt: f64) -> Option<[f64; 2]> {
        let speed = (self.speed * self.speed + 2.0 * self.acceleration * self.gap).sqrt();
        let time = if self.speed >= 0.0 {
            2.0 * self.gap / (self.speed + speed)
        } else if self.acceleration > 0.0 {
            (speed - self.speed) / self.acceleration
        } else {
            return None;
        };
        // The time is NaN if the bodies rest on each other, or if the loads separate them first.
        (time <= dt).then_some([time, speed])
    }

    /// Impact of two bodies without other interactions, on their parabolic paths under constant
    /// loads.
    pub fn impact(
        &self,
        bodies: &BodyTable,
        motions: &[Option<Motion>],
        (contact, c): (&Contact, &Interaction),
        dt: f64,
    ) -> Option<Hit> {
        let [mut time, speed] = self.hit(dt)?;
        let (a, b) = (c.a as usize, c.b as usize);
        let wall = bodies.wall(c.b);
        // The path of a point of a wall that turns is straight to first order.
        let turns = motions[b].is_some_and(|motion| motion.spin != 0.0);
        if wall.is_some_and(|wall| wall.is_line() || turns) {
            let acceleration = self.acceleration;
            return Some(Hit { time, speed, acceleration, normal: contact.normal });
        }
        let (of_a, of_b) = (motions[a]?, motions[b]?);
        let reach = bodies.radii[a] + bodies.radii.get(b).copied().unwrap_or(0.0);
        if self.speed > 0.0 {
            time = 0.0;
        }
        for _ in 0..MAX_STEPS {
            let d = bodies.positions[b] - bodies.positions[a] + of_b.moved(time) - of_a.moved(time);
            let (normal, gap, is_hollow) = match wall {
                Some(wall) => {
                    let near = wall.nearest(d, DVec2::ZERO);
                    let is_hollow = matches!(near.curve, Curve::Hollow(_));
                    (-near.outward, near.distance - reach, is_hollow)
                }
                None => (d.normalize_or(contact.normal), d.length() - reach, false),
            };
            let velocity = |m: &Motion| m.velocity + time * m.acceleration;
            let speed = normal.dot(velocity(&of_a) - velocity(&of_b));
            // Towards the inside of an arc the distance is concave: the first step may go too far.
            let too_far = is_hollow && time > 0.0 && gap < -RESIDUAL * reach;
            if gap <= ROUND_OFF * reach && !too_far {
                let acceleration = normal.dot(of_a.acceleration - of_b.acceleration);
                return (speed > 0.0).then_some(Hit { time, speed, acceleration, normal });
            }
            time += gap / speed;
            // The bodies pass each other, or meet later.
            if !(speed > 0.0 && time <= dt) {
                return None;
            }
        }
        None
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
        for (gap, v, a) in [(0.3, 2.0, 0.0), (0.3, 2.0, 9.81), (0.3, 2.0, -5.0), (0.1, -0.4, 9.81)]
        {
            let [time, speed] = approach(gap, v, a).hit(1.0).unwrap();
            assert!((v * time + 0.5 * a * time * time - gap).abs() < 1e-14);
            assert!((v + a * time - speed).abs() < 1e-14);
            assert!(speed > 0.0);
            assert_eq!(approach(gap, v, a).hit(0.99 * time), None);
        }
        assert_eq!(approach(0.0, 2.0, 9.81).hit(1.0), Some([0.0, 2.0]));
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

    #[test]
    fn disks_that_pass_each_other_do_not_meet() {
        let contact = |bodies: &BodyTable| crate::detect_contacts::gaps::pair_contact(bodies, 0, 1);
        for (offset, meets) in [(0.0, true), (1.9, true), (1.999, true), (2.001, false)] {
            let bodies = BodyTable {
                particles: 2,
                positions: vec![DVec2::ZERO, DVec2::new(3.0, offset)],
                radii: vec![1.0; 2],
                ..BodyTable::default()
            };
            let motions = [DVec2::X, -DVec2::X]
                .map(|velocity| Some(Motion { velocity, ..Motion::default() }));
            let contact = contact(&bodies);
            let c = Interaction { normal: contact.normal, ..Interaction::between(0, 1) };
            let hit = Approach::of(&motions, &contact, &c)
                .and_then(|x| x.impact(&bodies, &motions, (&contact, &c), 2.0));
            assert_eq!(hit.is_some(), meets, "{offset}: {hit:?}");
            if let Some(hit) = hit {
                let time = 0.5 * (3.0 - (4.0 - offset * offset).sqrt());
                assert!((hit.time - time).abs() < 1e-12, "{offset}: {hit:?}");
            }
        }
    }
}
