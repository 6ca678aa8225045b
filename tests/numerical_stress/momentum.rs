//! Momentum of free assemblies over many increments.

use clastic::run::Simulation;
use clastic::scene::format::Scene;

use crate::common::{ELASTIC, RIGID, momentum, momentum_scales, next, states, swarm, wheel};
use crate::random::full;

/// Maximum drift of momentum and angular momentum over their scales at the start. Disks that have
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
        let ((p, l), (p_scale, l_scale)) = (momentum(&now), momentum_scales(&now));
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
