//! Momentum and energy of closed sets of bodies.

use crate::common::*;
use clastic::run::Simulation;
use clastic::scene::format::Scene;

/// Maximum drift of momentum and angular momentum, over their scales at the start.
fn drift(scene: &Scene) -> (f64, f64) {
    let mut simulation = Simulation::new(scene, None);
    let start = states(&mut simulation);
    let ((p0, l0), (p_scale, l_scale)) = (momentum(&start), momentum_scales(&start));
    let (mut p_drift, mut l_drift, mut contacts) = (0.0_f64, 0.0_f64, 0);
    while let Some(record) = next(&mut simulation) {
        contacts = contacts.max(record.contacts);
        let (p, l) = momentum(&states(&mut simulation));
        p_drift = p_drift.max((p - p0).length() / p_scale);
        l_drift = l_drift.max((l - l0).abs() / l_scale);
    }
    assert!(contacts >= 5, "the swarm must collide: {contacts} contacts at most");
    (p_drift, l_drift)
}

#[test]
fn momentum_is_conserved_to_round_off_for_every_theta() {
    for (law, contact) in [("Associated", RIGID), ("Associated", ELASTIC), ("Coulomb()", RIGID)] {
        for theta in [0.5, 0.7, 1.0] {
            let (p, _) = drift(&swarm(law, contact, 2e-4, theta, 60));
            assert!(p < 1e-14, "{law}, {contact}, theta {theta}: {p:e}");
        }
    }
}

#[test]
fn angular_momentum_is_conserved_to_round_off_at_theta_one() {
    for (law, contact) in [("Associated", RIGID), ("Associated", ELASTIC), ("Coulomb()", RIGID)] {
        let (_, l) = drift(&swarm(law, contact, 2e-4, 1.0, 60));
        assert!(l < 1e-13, "{law}, {contact}: {l:e}");
    }
}

#[test]
fn angular_momentum_of_a_wheel_is_conserved() {
    let mut simulation = Simulation::new(&wheel(2.5e-4, 1.0, 200), None);
    let start = momentum(&states(&mut simulation)).1;
    while next(&mut simulation).is_some() {}
    assert_relative(momentum(&states(&mut simulation)).1, start, 1e-13);
}
