//! Rigid bodies that are held or driven: what their overlaps mean to the program.

use crate::common::*;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::Scene;

/// Two rigid disks of radius 1 m that overlap by 0.1 m, with imposed motion, and a third one that
/// is pressed on a floor.
fn overlapping(analysis: &str, contact: &str, first: &str, second: &str) -> Scene {
    parse(&format!(
        r#"(
            version: 1, title: "overlapping", analysis: {analysis},
            materials: {{ "steel": (contact: ({contact})) }},
            specimen: Particles([
                (position: (0.0, 1.0), radius: 1.0), (position: (1.9, 1.0), radius: 1.0),
                (position: (9.0, 1.0), radius: 1.0, probe: "pressed"),
            ]),
            walls: [(name: "floor", start: (-5.0, 0.0), end: (15.0, 0.0), probe: "floor",
                contact: (normal_stiffness: 1.0e6))],
            stages: [Load(name: "hold", increments: 3, particles: [
                (select: Index([0]), {first}),
                (select: Index([1]), {second}),
                (select: Index([2]), x: Held, rotation: Held, force: (0.0, -3.0)),
            ])],
        )"#
    ))
}

#[test]
fn two_held_disks_that_overlap_do_not_lock_the_rest() {
    let held = "x: Held, y: Held, rotation: Held";
    // With friction a rotation that is free takes part in the contact.
    let turning = "x: Held, y: Held";
    let driven = "x: Displacement(1.0e-3), y: Held, rotation: Held";
    let apart = "x: Displacement(-1.0e-3), y: Held, rotation: Held";
    for analysis in ["Static", "Dynamic(dt: 0.1)"] {
        for contact in ["", "friction: 0.5, rolling_friction: 0.1"] {
            for (first, second) in
                [(held, held), (turning, turning), (driven, driven), (apart, held)]
            {
                let (records, outcome) = run(&overlapping(analysis, contact, first, second));
                assert_eq!(outcome, Outcome::Completed, "{analysis}, {contact}, {first}, {second}");
                assert_eq!(records.len(), 3);
                if analysis == "Static" {
                    // The contact of the two carries nothing; that of the third one carries its
                    // load.
                    assert_eq!(records[2].contacts, 1, "{contact}, {first}, {second}");
                    assert_relative(probe(&records[2], "floor").force[1], 3.0, 1e-8);
                }
            }
        }
    }
}

#[test]
fn rigid_bodies_that_are_moved_into_each_other_are_named() {
    let held = "x: Held, y: Held, rotation: Held";
    let closing = "x: Displacement(1.0e-3), y: Held, rotation: Held";
    let mut simulation = Simulation::new(&overlapping("Static", "", closing, held), None);
    let Outcome::Undecided { increment, message } = simulation.run() else {
        panic!("it did not lock")
    };
    assert_eq!(increment, 1);
    for what in ["locked", "particle 0 and particle 1", "1.010e-1 m", "keep the two apart"] {
        assert!(message.contains(what), "no `{what}` in: {message}");
    }
}

/// A disk with a held x, 3 radii above the floor, was a collapse by proof: a body with any imposed
/// translation counted as one that does not move, and the motion of its fall as at rest.
#[test]
fn a_disk_with_one_free_translation_lands() {
    for held in ["x: Held", "x: Held, rotation: Held"] {
        for gap in [0.5, 3.0] {
            let scene = parse(&format!(
                "(version: 1, title: \"falls\", gravity: (0.0, -9.81),
                  materials: {{ \"m\": (density: 2000.0, contact: (normal_stiffness: 1.0e6)) }},
                  specimen: Particles([(position: (0.0, {y:?}), radius: 0.02)]),
                  walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0), probe: \"floor\",
                    contact: (normal_stiffness: 1.0e6))],
                  stages: [Load(name: \"fall\", increments: 1, particles: [(select: All, {held})])])",
                y = 0.02 * (1.0 + gap),
            ));
            let (records, outcome) = run(&scene);
            assert_eq!(outcome, Outcome::Completed, "{held}, {gap} radii");
            let weight = 2000.0 * std::f64::consts::PI * 0.02 * 0.02 * 9.81;
            assert_relative(probe(&records[0], "floor").force[1], weight, 1e-8);
        }
    }
}
