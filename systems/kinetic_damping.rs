//! Kinetic damping: the length of the steps of a followed motion, and the momentum that it keeps.
//!
//! The kinetic energy of a step is `E = W k_0 sum m_i u_i^2` (N m; see [`Motion`]). While it rises
//! the motion keeps its velocities; when it falls it has passed an equilibrium, and the velocities
//! are set to zero (Cundall 1982, "Adaptive density-scaling for time-explicit calculations").

use clastic_components::contact::BodyTable;
use clastic_components::motion::Motion;

use crate::motion_settings::MotionSettings;

/// Masses and moments of inertia over the mean mass. A wall under a load moves with the specimen:
/// it has the mass of all grains, as a group with walls does.
pub(crate) fn relative_masses(bodies: &BodyTable) -> Vec<[f64; 2]> {
    let n = bodies.particles;
    let all = n.max(1) as f64;
    let mean = bodies.masses.iter().sum::<f64>() / all;
    let mut masses = vec![[all, 0.0]; bodies.positions.len()];
    for i in 0..n {
        let r = bodies.radii[i];
        masses[i] = if mean > 0.0 {
            [bodies.masses[i] / mean, bodies.inertias[i] / mean]
        } else {
            [1.0, 0.5 * r * r]
        };
    }
    for group in &bodies.groups {
        // Its members move with it and have no kinetic energy of their own.
        group.members.iter().for_each(|member| masses[*member as usize] = [0.0; 2]);
        let has_wall = group.members.last().is_some_and(|last| *last as usize >= n);
        masses[group.body as usize] = if mean > 0.0 {
            [group.mass / mean, group.inertia / mean]
        } else {
            let n = group.members.len() as f64;
            [n, 0.5 * n * group.extent.max(bodies.mean_radius).powi(2)]
        };
        if has_wall {
            let [mass, inertia] = &mut masses[group.body as usize];
            *mass += all;
            *inertia += all * group.extent.max(bodies.mean_radius).powi(2);
        }
    }
    if bodies.cell.is_some() {
        // A cell under a stress moves with the specimen, as a wall under a load does.
        masses.push([all, all * bodies.mean_radius.powi(2)]);
    }
    masses
}

/// Gives a rejected step a shorter time. `too_far` is the travel of its furthest grain, in radii,
/// if the step was rejected for its length.
pub fn shorten(motion: &mut Motion, too_far: Option<f64>, settings: &MotionSettings) {
    motion.failures += 1;
    let ratio = match too_far {
        // Where inertia hardly counts, a slightly shorter step has the same travel.
        Some(far) => {
            let at_most = settings.max_shortened.powi(motion.failures as i32);
            stretch(motion, far, settings).min(at_most)
        }
        // The only information on the motion is that the step has no solution.
        None => settings.min_ratio,
    };
    motion.weight /= ratio * ratio;
}

/// Factor of the time of a step with the travel `far` with which its furthest grain would have
/// travelled the intended distance. Momentum moves it by `v dt`, and forces move it in proportion
/// to `dt^2`.
fn stretch(motion: &Motion, far: f64, settings: &MotionSettings) -> f64 {
    let momentum = (motion.speed * motion.dt()).min(far);
    let gained = (far - momentum).max(settings.min_gain * far);
    time_ratio(momentum, gained, motion.goal, settings)
}

/// The s > 0 with `momentum s + gained s^2 = goal`, within bounds.
fn time_ratio(momentum: f64, gained: f64, goal: f64, settings: &MotionSettings) -> f64 {
    let root = (momentum * momentum + 4.0 * gained * goal).sqrt();
    // The form without cancellation.
    (2.0 * goal / (momentum + root)).clamp(settings.min_ratio, settings.max_ratio)
}

/// Sets momentum and weight of the next step after one with these displacements (m, m, rad; by body
/// in its own axes), in which the furthest grain travelled `far` radii.
pub(crate) fn carry_on(
    motion: &mut Motion,
    displacements: &[[f64; 3]],
    far: f64,
    settings: &MotionSettings,
) {
    let energy: f64 = motion
        .masses
        .iter()
        .zip(displacements)
        .map(|(m, u)| m[0] * (u[0] * u[0] + u[1] * u[1]) + m[1] * u[2] * u[2])
        .sum::<f64>()
        * motion.weight
        * motion.stiffness;
    let dt = motion.dt();
    let gained = (far - motion.speed * dt).max(settings.min_gain * far);
    let ratio = if energy >= motion.kinetic {
        motion.kinetic = energy;
        motion.speed = far / dt;
        for (v, u) in motion.velocities.iter_mut().zip(displacements) {
            *v = u.map(|u| u / dt);
        }
        time_ratio(far, gained, motion.goal, settings)
    } else {
        motion.kinetic = 0.0;
        motion.speed = 0.0;
        motion.velocities.iter_mut().for_each(|v| *v = [0.0; 3]);
        time_ratio(0.0, far, motion.goal, settings)
    };
    motion.failures = 0;
    motion.steps += 1;
    motion.travelled += far;
    motion.free_steps += u32::from(motion.weight <= settings.min_weight);
    motion.weight = (motion.weight / (ratio * ratio)).max(settings.min_weight);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grain of relative mass 1 on a spring of k = 1 N/m and k_0 = 1 N/m under a load of 1 N,
    /// with a radius of 1 m: `W (u - v dt) + k (x + u) = f`. It has to come to rest at x = f/k = 1
    /// m.
    #[test]
    fn a_grain_on_a_spring_comes_to_rest_at_its_equilibrium() {
        let mut motion = Motion {
            weight: 1e2,
            stiffness: 1.0,
            masses: vec![[1.0, 0.0]],
            velocities: vec![[0.0; 3]],
            goal: 0.15,
            ..Motion::default()
        };
        let (mut x, mut turns) = (0.0, 0);
        for _ in 0..200 {
            let (weight, reference) = motion.inertia(0, 0);
            let u = (1.0 - x + weight * reference) / (weight + 1.0);
            carry_on(&mut motion, &[[u, 0.0, 0.0]], u.abs(), &MotionSettings::default());
            x += u;
            turns += u32::from(motion.kinetic == 0.0);
        }
        assert!((x - 1.0).abs() < 1e-9, "{x}");
        assert!(turns > 0, "the energy never fell");
    }

    #[test]
    fn a_step_that_went_too_far_is_shortened_to_what_it_aims_at() {
        // From rest the travel grows with the square of the time.
        let mut motion = Motion { weight: 1.0, goal: 0.15, ..Motion::default() };
        shorten(&mut motion, Some(0.6), &MotionSettings::default());
        assert!((motion.dt() - 0.5).abs() < 1e-12, "{}", motion.dt());
        // With momentum alone it grows with the time.
        let mut motion = Motion { weight: 1.0, goal: 0.15, speed: 0.3, ..Motion::default() };
        shorten(&mut motion, Some(0.3), &MotionSettings::default());
        assert!((motion.dt() - 0.5).abs() < 1e-3, "{}", motion.dt());
        assert_eq!(motion.failures, 1);
    }
}
