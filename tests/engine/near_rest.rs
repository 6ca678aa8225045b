//! Dynamic increments near rest. A spring turns the error of a displacement into `k` times as much
//! force, and inertia turns that of a force into its ratio to `m/dt^2`. With `k dt^2/m >> 1` the
//! round-off of a contact force moves a grain by more than the tolerance of its contact.

use clastic::run::{Outcome, Simulation};

use crate::common::*;

/// Two elastic disks are pressed together and then left under constant forces. Increments were
/// halved down to the last option: with dt = 1 s and k = 1e5 N/m the run was undecided in increment
/// 25. Under Coulomb's law increment 22 was capped, since its solver took displacements from the
/// forces only.
#[test]
fn two_disks_pressed_together_rest_at_any_time_step() {
    let (radius, force) = (0.01, 1000.0);
    let laws = ["Associated", "Coulomb()"];
    for (dt, law) in [1e-2, 1e-1, 1.0].into_iter().flat_map(|dt| laws.map(|law| (dt, law))) {
        for k in [1e5, 1e7, 1e8, 1e10, 1e12] {
            let scene = parse(&format!(
                "(
                    version: 1,
                    title: \"two disks\",
                    friction_law: {law},
                    analysis: Dynamic(dt: {dt:e}, theta: 1.0),
                    materials: {{ \"stone\": (density: 2650.0, contact: (
                        normal_stiffness: {k:e})) }},
                    specimen: Particles([
                        (position: (0.0, 0.0), radius: {radius}),
                        (position: (0.02, 0.0), radius: {radius}),
                    ]),
                    stages: [
                        Load(name: \"press\", increments: 20, particles: [
                            (select: Index([0]), force: ({force:e}, 0.0)),
                            (select: Index([1]), force: (-{force:e}, 0.0)),
                        ]),
                        Load(name: \"rest\", increments: 60),
                    ],
                )"
            ));
            let mut simulation = Simulation::new(&scene, None);
            for increment in 1..=80 {
                let record = next(&mut simulation).unwrap();
                assert_eq!(record.fraction, 1.0, "{law} k {k:e} dt {dt}: increment {increment}");
            }
            assert_eq!(simulation.run(), Outcome::Completed);
            let disks = states(&mut simulation);
            let overlap = 2.0 * radius - (disks[1].position.x - disks[0].position.x);
            // Of the round-off of a position.
            assert_within(overlap, force / k, 1e-9 * force / k + 1e-17);
        }
    }
}

/// Sixty grains between walls under a stress. The increments at rest were halved: with dt = 0.1 s
/// and k = 1e8 N/m the run was undecided.
#[test]
fn a_packing_under_constant_stress_rests_at_any_time_step() {
    let stress = 1e5;
    let cases = [(1e-2, 1e6, 0.0), (1e-1, 1e6, 0.0), (1e-2, 1e8, 0.1), (1e-1, 1e8, 0.1)];
    let both = |case| ["Associated", "Coulomb()"].map(|friction_law| (case, friction_law));
    for ((dt, k, rolling), friction_law) in cases.into_iter().flat_map(both) {
        let law = format!("contact: (normal_stiffness: {k:e}, friction: 0.4)");
        let sides = |a: &str, b: &str| format!("Stress(stress: {stress}, between: ({a:?}, {b:?}))");
        let scene = parse(&format!(
            "(
                version: 1,
                title: \"pressed\",
                friction_law: {friction_law},
                analysis: Dynamic(dt: {dt:e}, theta: 1.0),
                materials: {{ \"grains\": (density: 2650.0, contact: (normal_stiffness: {k:e},
                    tangential_stiffness: {k:e}, friction: 0.5, rolling_friction: {rolling})) }},
                specimen: Packing(count: 60, columns: 6, spacing: 0.0303, origin: (0.0037, 0.0),
                    sizes: Uniform(radius: (0.005, 0.015)), seed: 4),
                walls: [
                    (name: \"bottom\", start: (0.0, 0.0), end: (0.185, 0.0), {law}),
                    (name: \"top\", start: (0.185, 0.4), end: (0.0, 0.4), {law}),
                    (name: \"left\", start: (0.0, 0.4), end: (0.0, 0.0), {law}),
                    (name: \"right\", start: (0.185, 0.0), end: (0.185, 0.4), {law}),
                ],
                stages: [
                    Compact(name: \"compact\", wall: \"top\", base: \"bottom\",
                        target: Porosity(0.22), step: 0.01, agitation: 0.1, seed: 4),
                    Load(name: \"confine\", increments: 10, walls: {{
                        \"top\": {top}, \"left\": {side}, \"right\": {side} }}),
                    Load(name: \"rest\", increments: 60),
                ],
                measures: [(name: \"axial_stress\", of: Stress(Walls(walls: [\"top\"],
                    length: Between(\"left\", \"right\"))))],
            )",
            top = sides("left", "right"),
            side = sides("bottom", "top"),
        ));
        let (records, outcome) = run(&scene);
        let at = format!("{friction_law} k {k:e} dt {dt}");
        assert_eq!(outcome, Outcome::Completed, "{at}");
        // The last stage.
        for record in &records[records.len() - 60..] {
            assert_eq!(record.fraction, 1.0, "{at}: increment {}", record.increment);
        }
        assert_relative(records.last().unwrap().axial_stress.unwrap(), stress, 1e-6);
    }
}
