//! Grains that hang on taut bonds: the program's normals are those of the start of the increment,
//! and only the geometric stiffness T/L of the bonds holds such grains across the chain.

use crate::common::*;
use clastic::run::{Outcome, Simulation};

const RADIUS: f64 = 5e-3;
const STIFFNESS: f64 = 1e8;

/// Five disks in a row along x without rolling resistance, bonded; the first is held, the last is
/// pulled by `stretch` (m) and held, then the middle one is loaded across the chain with `force`
/// (N).
fn chain(stretch: f64, force: f64) -> String {
    let disks: Vec<String> = (0..5)
        .map(|i| format!("(position: ({}, 0.0), radius: {RADIUS})", 2.0 * RADIUS * f64::from(i)))
        .collect();
    format!(
        r#"(
    version: 1,
    title: "chain",
    materials: {{ "steel": (
        contact: (normal_stiffness: {STIFFNESS:e}, tangential_stiffness: {STIFFNESS:e}, friction: 0.5),
        bond: (normal_stiffness: {STIFFNESS:e}, tangential_stiffness: {STIFFNESS:e}, friction: 0.5,
            cohesion: 1.0e9, tensile_strength: 1.0e9),
    ) }},
    specimen: Particles([{}]),
    stages: [
        Cement(name: "glue", length: 1.0e-6),
        Load(name: "pull", increments: 1, particles: [
            (select: Index([0]), x: Held, y: Held, rotation: Held),
            (select: Index([4]), x: Displacement({stretch:e}), y: Held, rotation: Held),
        ]),
        Load(name: "load", increments: 4, particles: [
            (select: Index([0, 4]), x: Held, y: Held, rotation: Held),
            (select: Index([2]), force: (0.0, {force:e})),
        ]),
    ],
)"#,
        disks.join(", ")
    )
}

#[test]
fn a_taut_chain_carries_a_load_across_it_like_a_string() {
    // Four bonds share the stretch; the middle disk sinks by w = F L/T, its neighbours by half of
    // it (disks roll on each other: y_2 = y_1 + y_3).
    let stretch = 4e-6;
    let tension = STIFFNESS * stretch / 4.0;
    let length = 2.0 * RADIUS + 0.25 * stretch;
    for ratio in [1e-4, 1e-3] {
        let force = -ratio * tension;
        let mut simulation = Simulation::new(&parse(&chain(stretch, force)), None);
        while next(&mut simulation).is_some() {}
        assert_eq!(simulation.run(), Outcome::Completed, "F/T = {ratio}");
        let places = states(&mut simulation);
        let expected = force * length / tension;
        // Each bond turns by w/(2 L) and is stretched by half the square of it: tension grows.
        let growth = STIFFNESS * 0.5 * length * (0.5 * ratio).powi(2) / tension;
        let tolerance = 1e-6 + 2.0 * growth;
        assert_relative(places[2].position.y, expected, tolerance);
        assert_relative(places[1].position.y, 0.5 * expected, tolerance);
        assert_relative(places[3].position.y, 0.5 * expected, tolerance);
    }
}
