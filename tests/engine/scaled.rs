//! Factors on gravity and strength over a stage, and grains that are counted where they are.

use clastic::components::increment::ClasticProgress;
use clastic::components::observation::Observation;
use clastic::run::measures::reading;
use clastic::run::{Outcome, Simulation, Step};

use crate::common::parse;

/// A disk that cannot turn on a floor, or bonded to it, and one stage.
fn disk(cement: &str, gravity: &str, stage: &str) -> Simulation {
    let scene = parse(&format!(
        r#"(version: 1, title: "disk", gravity: {gravity},
        materials: {{ "rock": (density: 2500.0, contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8),
            bond: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, cohesion: 1.0e6, tensile_strength: 1.0e3)) }},
        specimen: Particles([(position: (0.0, 0.1), radius: 0.1)]),
        walls: [(name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0),
            contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, friction: 0.8))],
        stages: [{cement} Load(name: "load", {stage}, particles: [(select: All, rotation: Held)])],
        measures: [(name: "floor", of: WallForce(wall: "floor", along: Normal))])"#
    ));
    Simulation::new(&scene, None)
}

/// Weight of the disk under 10 m/s^2, N.
const WEIGHT: f64 = 2500.0 * std::f64::consts::PI * 0.01 * 10.0;

#[test]
fn gravity_grows_over_a_stage() {
    let ramp = "increments: 10, scale: (gravity: [(0.0, 0.0), (0.5, 1.0), (1.0, 4.0)])";
    let mut simulation = disk("", "(0.0, -10.0)", ramp);
    let mut found = Vec::new();
    while simulation.step() == Step::Increment {
        found.push(reading(simulation.world(), "floor").unwrap() / WEIGHT);
    }
    let expected = [0.2, 0.4, 0.6, 0.8, 1.0, 1.6, 2.2, 2.8, 3.4, 4.0];
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");

    // A part of an increment has a part of the step.
    let ramp = format!("{ramp}, stop: [Until(\"floor\", {:?})]", 1.3 * WEIGHT);
    let mut simulation = disk("", "(0.0, -10.0)", &ramp);
    assert_eq!(simulation.run(), Outcome::Completed);
    let end = reading(simulation.world(), "floor").unwrap() / WEIGHT;
    assert!((end - 1.3).abs() < 1e-5, "{end}");
}

/// Of 90 increments each lowers the strength by 0.01.
const REDUCE: &str = "increments: 90, scale: (strength: [(0.0, 1.0), (1.0, 0.1)])";

#[test]
fn a_disk_slides_where_its_reduced_friction_is_below_the_slope() {
    // tan = 0.405 is 0.8 times 0.50625: 0.51 holds, 0.50 does not.
    let mut simulation = disk("", "(4.05, -10.0)", REDUCE);
    assert!(matches!(simulation.run(), Outcome::Collapsed(_)));
    assert_eq!(simulation.world().resource::<Observation>().increment, 50);
}

#[test]
fn a_bond_breaks_where_its_reduced_strength_is_the_weight() {
    // The strength is 2 r h sigma_t = 200 N.
    let weight = 2500.0 * std::f64::consts::PI * 0.01 * 1.578;
    let cement = r#"Cement(name: "glue", length: 1e-3, walls: true),"#;
    let mut simulation = disk(cement, "(0.0, 1.578)", REDUCE);
    while simulation.step() == Step::Increment {
        if simulation.world().resource::<Observation>().broken != [0; 3] {
            break;
        }
    }
    let factor = 1.0 - 0.01 * simulation.world().resource::<ClasticProgress>().done;
    assert!((factor / (weight / 200.0) - 1.0).abs() < 5e-4, "{factor}");
    assert!(matches!(simulation.run(), Outcome::Collapsed(_)));
}

#[test]
fn grains_are_counted_where_they_are_and_by_how_far_they_moved() {
    let scene = parse(
        r#"(version: 1, title: "three", thickness: 0.5, materials: { "rock": (density: 2000.0) },
        specimen: Particles([(position: (0.0, 0.0), radius: 0.1), (position: (1.0, 0.0), radius: 0.2),
            (position: (2.0, 0.0), radius: 0.1)]),
        stages: [Load(name: "move", increments: 9, stop: [Above("share", 0.5)], particles: [
            (select: All, x: Held, y: Held, rotation: Held),
            (select: Index([1]), x: Displacement(0.01)), (select: Index([2]), x: Displacement(0.05))])],
        measures: [(name: "left", of: Grains(amount: Number, max: (1.5, 9.0))),
            (name: "right_kg", of: Grains(amount: Mass, min: (1.005, -1.0))),
            (name: "share", of: Grains(amount: Share, moved: 0.035))])"#,
    );
    let mut simulation = Simulation::new(&scene, None);
    let mut rows = Vec::new();
    while simulation.step() == Step::Increment {
        let [a, b, c] =
            ["left", "right_kg", "share"].map(|name| reading(simulation.world(), name).unwrap());
        rows.push((a, b, c));
    }
    // Masses are as 1 : 4 : 1. After four increments the second has moved by 40 mm.
    let all = 2000.0 * 0.5 * std::f64::consts::PI * 0.05;
    assert_eq!(rows.len(), 4);
    assert!(rows.iter().all(|row| row.0 == 2.0 && (row.1 - all).abs() < 1e-9 * all), "{rows:?}");
    let shares: Vec<_> = rows.iter().map(|row| (6.0 * row.2).round()).collect();
    assert_eq!(shares, [1.0, 1.0, 1.0, 5.0]);
}
