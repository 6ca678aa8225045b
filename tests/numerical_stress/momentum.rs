//! Momentum of free assemblies over many increments.

use clastic::run::Simulation;
use clastic::scene::format::Scene;
use glam::DVec2;

use crate::common::{ELASTIC, RIGID, State, next, parse, states, swarm};
use crate::random::full;

/// Seven bonded disks that turn about their centre.
pub fn wheel(dt: f64, theta: f64, increments: u32) -> Scene {
    let spin = 10.0;
    let (mut disks, mut bonds) = (String::new(), String::new());
    for k in 0..7_u32 {
        let at = if k == 0 {
            DVec2::ZERO
        } else {
            0.02 * DVec2::from_angle(f64::from(k) * std::f64::consts::FRAC_PI_3)
        };
        let v = spin * at.perp();
        disks += &format!(
            "(position: ({:?}, {:?}), radius: 0.01, velocity: ({:?}, {:?}), angular_velocity: {spin:?}),",
            at.x, at.y, v.x, v.y
        );
        if k > 0 {
            bonds += &format!("(a: 0, b: {k}), (a: {k}, b: {}),", k % 6 + 1);
        }
    }
    parse(&format!(
        "(
            version: 1,
            title: \"wheel\",
            analysis: Dynamic(dt: {dt:?}, theta: {theta:?}),
            materials: {{ \"stone\": (bond: (normal_stiffness: 1.0e6, tangential_stiffness: 5.0e5, friction: 0.5,
                cohesion: 1.0e9, tensile_strength: 1.0e9)) }},
            specimen: Particles([{disks}]),
            bonds: [{bonds}],
            stages: [Load(name: \"turn\", increments: {increments})],
        )"
    ))
}

fn momentum(states: &[State]) -> (DVec2, f64) {
    (
        states.iter().map(|s| s.mass * s.velocity).sum(),
        states.iter().map(|s| s.mass * s.position.perp_dot(s.velocity) + s.inertia * s.spin).sum(),
    )
}

fn scales(states: &[State]) -> (f64, f64) {
    (
        states.iter().map(|s| s.mass * s.velocity.length()).sum(),
        states
            .iter()
            .map(|s| s.mass * s.position.length() * s.velocity.length() + s.inertia * s.spin.abs())
            .sum(),
    )
}

/// Greatest drift of momentum and angular momentum over their scales at the start. Disks that have
/// parted fly on: about a far origin angular momentum is a small difference of great numbers, so
/// its scale grows with theirs.
fn drift(scene: &Scene) -> (f64, f64, u64) {
    let mut simulation = Simulation::new(scene, None);
    let start = states(&mut simulation);
    let (p0, l0) = momentum(&start);
    let (mut p_drift, mut l_drift, mut contacts) = (0.0_f64, 0.0_f64, 0);
    while let Some(record) = next(&mut simulation) {
        contacts += record.contacts as u64;
        let now = states(&mut simulation);
        let ((p, l), (p_scale, l_scale)) = (momentum(&now), scales(&now));
        p_drift = p_drift.max((p - p0).length() / p_scale);
        l_drift = l_drift.max((l - l0).abs() / l_scale);
    }
    (p_drift, l_drift, contacts)
}

/// Errors of the sums add up like a random walk, at worst in proportion to the increments.
fn round_off(increments: u32) -> f64 {
    1e-15 * f64::from(increments).sqrt().max(10.0)
}

#[test]
fn momentum_of_swarms_and_wheels_holds_to_round_off() {
    let n = full(1_000, 10_000);
    for theta in [0.5, 0.75, 1.0] {
        for scene in [
            wheel(1e-4, theta, n),
            swarm("Associated", RIGID, 2e-4, theta, n),
            swarm("Associated", ELASTIC, 2e-4, theta, n),
        ] {
            let (p, l, contacts) = drift(&scene);
            println!("{}, theta {theta}: {p:.1e} and {l:.1e}, {contacts} contacts", scene.title);
            assert!(contacts > 100);
            assert!(p <= round_off(n), "{}, theta {theta}: {p:e}", scene.title);
            if theta == 1.0 {
                assert!(l <= 10.0 * round_off(n), "{}: {l:e}", scene.title);
            }
        }
    }
}
