//! Loads on the particles that are in a selection when an increment begins.

use crate::common::*;
use clastic::components::energy::EnergyLedger;
use clastic::run::Simulation;

const G: f64 = 9.81;

fn mass() -> f64 {
    2000.0 * std::f64::consts::PI * 0.01 * 0.01
}

/// A disk that flies through a field gains the impulse of the force over the increments that begin
/// in it, and, to first order in the time step, the work of the force over the width of the field.
#[test]
fn a_disk_gains_the_work_of_the_field_that_it_crosses() {
    let mut errors = Vec::new();
    for dt in [1.0e-3, 0.5e-3] {
        let scene = parse(&format!(
            "(version: 1, title: \"field\", analysis: Dynamic(dt: {dt:?}, theta: 0.5), output: (energy: true),
              materials: {{ \"m\": (density: 2000.0) }},
              specimen: Particles([(position: (0.0, 0.0), radius: 0.01, velocity: (1.0, 0.0))]),
              stages: [
                // The load is there in full from the start of the second stage on.
                Load(name: \"rise\", increments: 1, particles: [
                    (select: Box(min: (0.1, -1.0), max: (0.3, 1.0)), live: true, force: (2.0, 0.0))]),
                Load(name: \"fly\", increments: {}, particles: [
                    (select: Box(min: (0.1, -1.0), max: (0.3, 1.0)), live: true, force: (2.0, 0.0))]),
              ])",
            (0.35 / dt) as u32
        ));
        let mut simulation = Simulation::new(&scene, None);
        let mut inside = 0;
        loop {
            let x = states(&mut simulation)[0].position.x;
            if next(&mut simulation).is_none() {
                break;
            }
            inside += u32::from((0.1..=0.3).contains(&x));
        }
        let disk = states(&mut simulation)[0];
        assert!(disk.position.x > 0.31, "{disk:?}");
        assert_relative(disk.velocity.x, 1.0 + f64::from(inside) * 2.0 * dt / mass(), 1e-12);
        let expected = (1.0 + 2.0 * 2.0 * 0.2 / mass()).sqrt();
        errors.push((disk.velocity.x / expected - 1.0).abs());
        let total = simulation.world().resource::<EnergyLedger>().total;
        assert!(total.error().abs() < 1e-12 * total.throughput(), "{total:?}");
        assert_relative(total.kinetic, 0.5 * mass() * (disk.velocity.x.powi(2) - 1.0), 1e-12);
    }
    // By one increment too many or too few.
    for (error, dt) in errors.iter().zip([1.0e-3, 0.5e-3]) {
        assert!(*error < 2.0 * dt * 2.0 / mass(), "{errors:?}");
    }
}

/// A disk that is led over a floor carries the load of a strip while it is in it, and no load
/// before and afterwards; the load rises over its stage, holds in the next, and ends.
#[test]
fn a_disk_carries_the_load_of_a_strip_while_it_is_in_it() {
    let weight = mass() * G;
    for law in ["Associated", "Coulomb()"] {
        let strip = "select: Layer(normal: (1.0, 0.0), from: 0.0995, to: 0.1995), live: true";
        let lead = "(select: All, x: Displacement(0.01), rotation: Held)";
        let scene = parse(&format!(
            "(version: 1, title: \"strip\", friction_law: {law}, gravity: (0.0, -9.81),
              materials: {{ \"m\": (density: 2000.0) }},
              specimen: Particles([(position: (0.0, 0.01), radius: 0.01)]),
              walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0), probe: \"floor\")],
              stages: [
                Load(name: \"rise\", increments: 14, particles: [{lead}, ({strip}, force: (0.0, -7.0))]),
                Load(name: \"hold\", increments: 3, particles: [{lead}, ({strip}, force: (0.0, -7.0))]),
                Load(name: \"fall\", increments: 8, particles: [{lead}, ({strip}, force: (0.0, 0.0))]),
                Load(name: \"none\", increments: 2, particles: [{lead}]),
              ])"
        ));
        let (records, _) = run(&scene);
        assert_eq!(records.len(), 27, "{law}");
        for (n, record) in records.iter().enumerate() {
            // The place at the start of the increment, and the load at its end.
            let x = n as f64 * 0.01;
            let load = match n {
                0..14 => 7.0 * (n + 1) as f64 / 14.0,
                14..17 => 7.0,
                17..25 => 7.0 * (25 - n - 1) as f64 / 8.0,
                _ => 0.0,
            };
            let carried = if (0.0995..0.1995).contains(&x) { load } else { 0.0 };
            assert_relative(probe(record, "floor").force[1], weight + carried, 1e-10);
        }
    }
}
