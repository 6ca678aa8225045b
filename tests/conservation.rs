//! Momentum and energy of closed sets of bodies.

mod common;

use clastic::run::Simulation;
use clastic::scene::format::{Analysis, Scene};
use common::*;
use glam::DVec2;

/// Nineteen disks of three sizes on a jittered hexagonal grid fly into each other, turning.
fn swarm(law: &str, contact: &str, dt: f64, theta: f64, increments: u32) -> Scene {
    let mut disks = String::new();
    let mut k = 0;
    for row in -2_i32..=2 {
        for column in 0..(5 - row.abs()) {
            let x = 0.021 * (f64::from(column) - 0.5 * f64::from(4 - row.abs()));
            let y = 0.021 * 0.75_f64.sqrt() * f64::from(row);
            // Any deterministic disorder will do.
            let wiggle = |p: f64| 4e-4 * (p * f64::from(k + 1)).sin();
            let (x, y) = (x + wiggle(12.9), y + wiggle(78.2));
            let radius = 0.01 - 4e-4 * f64::from(k % 3);
            let (vx, vy) = (-20.0 * x + 0.3 * wiggle(3.7) * 1e3, -20.0 * y + 8.0 * x);
            let spin = 3e4 * wiggle(5.3);
            disks += &format!(
                "(position: ({x:?}, {y:?}), radius: {radius:?}, velocity: ({vx:?}, {vy:?}), angular_velocity: {spin:?}),"
            );
            k += 1;
        }
    }
    parse(&format!(
        "(
            version: 1,
            title: \"swarm\",
            analysis: Dynamic(dt: {dt:?}, theta: {theta:?}),
            friction_law: {law},
            materials: {{ \"stone\": (contact: ({contact})) }},
            specimen: Particles([{disks}]),
            stages: [Load(name: \"free\", increments: {increments})],
        )"
    ))
}

/// Momentum, and angular momentum about the origin.
fn momentum(states: &[State]) -> (DVec2, f64) {
    (
        states.iter().map(|s| s.mass * s.velocity).sum(),
        states.iter().map(|s| s.mass * s.position.perp_dot(s.velocity) + s.inertia * s.spin).sum(),
    )
}

/// What they are measured by: the sums of the absolute values.
fn scales(states: &[State]) -> (f64, f64) {
    (
        states.iter().map(|s| s.mass * s.velocity.length()).sum(),
        states
            .iter()
            .map(|s| s.mass * s.position.length() * s.velocity.length() + s.inertia * s.spin.abs())
            .sum(),
    )
}

const RIGID: &str = "friction: 0.4, rolling_friction: 0.05";
const ELASTIC: &str =
    "normal_stiffness: 1.0e7, tangential_stiffness: 5.0e6, friction: 0.4, rolling_friction: 0.05";

/// Greatest drift of momentum and angular momentum, over their scales at the start.
fn drift(scene: &Scene) -> (f64, f64) {
    let mut simulation = Simulation::new(scene, None);
    let start = states(&mut simulation);
    let ((p0, l0), (p_scale, l_scale)) = (momentum(&start), scales(&start));
    let (mut p_drift, mut l_drift, mut contacts) = (0.0_f64, 0.0_f64, 0);
    while let Some(record) = next(&mut simulation) {
        contacts = contacts.max(record.contacts);
        let (p, l) = momentum(&states(&mut simulation));
        p_drift = p_drift.max((p - p0).length() / p_scale);
        l_drift = l_drift.max((l - l0).abs() / l_scale);
    }
    assert!(contacts >= 10, "the swarm must collide: {contacts} contacts at most");
    (p_drift, l_drift)
}

#[test]
fn momentum_is_conserved_to_round_off_for_every_theta() {
    for (law, contact) in
        [("Associated", RIGID), ("Associated", ELASTIC), ("Coulomb(tolerance: 1e-6)", RIGID)]
    {
        for theta in [0.5, 0.7, 1.0] {
            let (p, _) = drift(&swarm(law, contact, 2e-4, theta, 60));
            assert!(p < 1e-14, "{law}, {contact}, theta {theta}: {p:e}");
        }
    }
}

#[test]
fn angular_momentum_is_conserved_to_round_off_at_theta_one() {
    for (law, contact) in
        [("Associated", RIGID), ("Associated", ELASTIC), ("Coulomb(tolerance: 1e-6)", RIGID)]
    {
        let (_, l) = drift(&swarm(law, contact, 2e-4, 1.0, 60));
        assert!(l < 1e-13, "{law}, {contact}: {l:e}");
    }
}

/// Seven bonded disks that turn about their centre: a smooth motion, so that an order can be seen.
fn wheel(dt: f64, theta: f64, increments: u32) -> Scene {
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

#[test]
fn angular_momentum_converges_at_first_order_for_other_thetas() {
    // Normals and arms are those of the start of the increment.
    for theta in [0.5, 0.75] {
        let error = |n: u32| {
            let mut simulation = Simulation::new(&wheel(0.05 / f64::from(n), theta, n), None);
            let start = momentum(&states(&mut simulation)).1;
            while next(&mut simulation).is_some() {}
            momentum(&states(&mut simulation)).1 / start - 1.0
        };
        let (coarse, fine) = (error(200), error(400));
        assert!(fine.abs() > 1e-9, "there is an error to speak of: {fine:e}");
        assert_within(coarse / fine, 2.0, 0.1);
    }
    let mut scene = wheel(2.5e-4, 1.0, 200);
    scene.analysis = Analysis::Dynamic { dt: 2.5e-4, theta: 1.0 };
    let mut simulation = Simulation::new(&scene, None);
    let start = momentum(&states(&mut simulation)).1;
    while next(&mut simulation).is_some() {}
    assert_relative(momentum(&states(&mut simulation)).1, start, 1e-13);
}
