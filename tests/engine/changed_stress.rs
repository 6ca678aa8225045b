//! A load that changes its target on its way goes on from what it has reached.

use clastic::prelude::*;
use clastic::run::{Simulation, Step};

use crate::common;

/// A wall that presses a disk against the floor with 1 Pa more in each of ten increments.
const PRESS: &str = r#"(
    version: 1,
    title: "press",
    materials: { "stone": (contact: (normal_stiffness: 1.0e7)) },
    specimen: Particles([(position: (0.0, 0.01), radius: 0.01, material: "stone")]),
    walls: [
        (name: "floor", start: (-0.5, 0.0), end: (0.5, 0.0), contact: (normal_stiffness: 1.0e7)),
        (name: "lid", start: (0.5, 0.02), end: (-0.5, 0.02), contact: (normal_stiffness: 1.0e7)),
    ],
    stages: [Load(name: "press", increments: 10, walls: { "lid": Stress(stress: 10.0) })],
    measures: [(name: "axial_stress", of: Stress(Walls(walls: ["lid"], length: Fixed(1.0))))],
)"#;

/// Stresses of all increments, with another target from the fifth one on.
fn stresses(target: f64) -> Vec<f64> {
    let mut simulation = Simulation::new(&common::parse(PRESS), None);
    let mut found = Vec::new();
    while let Step::Increment = simulation.step() {
        let world = simulation.world_mut();
        found.push(world.resource::<Observation>().axial_stress.expect("the lid carries"));
        if found.len() == 4 {
            let progress = world.resource::<ClasticProgress>().clone();
            let mut walls = world.query::<&mut WallControl>();
            for mut control in walls.iter_mut(world) {
                if let WallControl::Stress { from, to, .. } = &mut *control {
                    (*from, *to) = progress.retarget((*from, *to), target);
                }
            }
        }
    }
    found
}

#[test]
fn a_changed_stress_acts_in_the_next_increment_and_does_not_jump() {
    for (target, step) in [(40.0, 6.0), (4.0, 0.0), (10.0, 1.0)] {
        let found = stresses(target);
        let expected: Vec<f64> = (1..=10)
            .map(|n: u32| f64::from(n.min(4)) + step * f64::from(n.saturating_sub(4)))
            .collect();
        assert_eq!(found.len(), expected.len());
        for (n, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!(
                (found / expected - 1.0).abs() < 1e-8,
                "increment {}: {found} Pa, not {expected}",
                n + 1
            );
        }
    }
}

/// A column of elastic disks that is unloaded to nothing keeps its lid where it just opens. Any gap is a
/// solution, and the lid was thrown by 0.3 to 20 times the closure of the loaded column, depending on the
/// number of increments.
#[test]
fn a_column_that_is_unloaded_to_nothing_keeps_its_lid() {
    for increments in [1, 2, 4, 10, 40] {
        let disks: String = (0..5)
            .map(|i| format!("(position: (0.01, {:?}), radius: 0.01),", 0.01 + 0.02 * f64::from(i)))
            .collect();
        let scene = common::parse(&format!(
            "(version: 1, title: \"column\",
              materials: {{ \"m\": (contact: (normal_stiffness: 1e7, tangential_stiffness: 1e7, friction: 0.5)) }},
              specimen: Particles([{disks}]),
              walls: [
                (name: \"floor\", start: (0.0, 0.0), end: (0.02, 0.0), contact: (normal_stiffness: 1e7)),
                (name: \"lid\", start: (0.02, 0.1), end: (0.0, 0.1), probe: \"lid\", contact: (normal_stiffness: 1e7)),
                (name: \"left\", start: (0.0, 0.1), end: (0.0, 0.0)),
                (name: \"right\", start: (0.02, 0.0), end: (0.02, 0.1))],
              stages: [Load(name: \"load\", increments: {increments}, walls: {{ \"lid\": Force(1000.0) }}),
                Load(name: \"unload\", increments: {increments}, walls: {{ \"lid\": Force(0.0) }})])"
        ));
        let (records, _) = common::run(&scene);
        let lid = |record: &Observation| common::probe(record, "lid").motion[1];
        let loaded = records.iter().map(lid).fold(0.0, f64::min);
        // Two walls and four pairs in series, each with 1000 N over 1e7 N/m.
        common::assert_relative(loaded, -6.0e-4, 1e-6);
        common::assert_within(lid(records.last().unwrap()), 0.0, 1e-8);
    }
}
