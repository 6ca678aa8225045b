//! Cement is made of the state as it is: the forces of contacts stay, in statics and dynamics.

use crate::common::*;
use clastic::components::increment::ClasticProgress;
use clastic::run::measures::reading;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::Analysis::{Dynamic, Static};
use clastic::scene::format::Scene;

/// Readings of a measure after every increment of a stage.
fn read(scene: &Scene, measure: &str, stage: &str) -> Vec<f64> {
    let mut simulation = Simulation::new(scene, None);
    let mut values = Vec::new();
    while next(&mut simulation).is_some() {
        if simulation.world().resource::<ClasticProgress>().stage_name == stage {
            values.push(reading(simulation.world(), measure).unwrap());
        }
    }
    assert!(matches!(simulation.run(), Outcome::Completed));
    values
}

const BOND: &str = "friction: 0.5, cohesion: 1.0e6, tensile_strength: 1.0e6";

/// Two disks between walls, pressed by 1000 N and cemented, also to the walls. Then the walls stay.
fn pressed(grains: &str, bonds: &str, cement: &str) -> Scene {
    parse(&format!(
        r#"(version: 1, title: "cement under a force",
        materials: {{ "sand": (density: 2000.0, contact: ({grains} friction: 0.5),
            bond: ({bonds} {BOND})) }},
        specimen: Particles([(position: (0.005, 0.005), radius: 0.005), (position: (0.005, 0.015), radius: 0.005)]),
        walls: [
            (name: "bottom", start: (0.0, 0.0), end: (0.01, 0.0), contact: (normal_stiffness: 1.0e7)),
            (name: "top", start: (0.01, 0.02), end: (0.0, 0.02), contact: (normal_stiffness: 1.0e7)),
        ],
        stages: [
            Load(name: "press", increments: 2, analysis: Static, walls: {{ "top": Force(1000.0) }}),
            {cement}
            Load(name: "hold", increments: 3, walls: {{ "top": Fixed }}),
        ],
        measures: [(name: "f", of: WallForce(wall: "top", along: Normal))])"#
    ))
}

#[test]
fn cement_leaves_the_force_of_a_contact_as_it_is() {
    let soft = "normal_stiffness: 1.0e7, tangential_stiffness: 1.0e7,";
    let stiff = "normal_stiffness: 3.0e7, tangential_stiffness: 1.0e7,";
    let analyses = [Static, Dynamic { dt: 1e-5, theta: 0.5 }, Dynamic { dt: 1e-5, theta: 1.0 }];
    for analysis in analyses {
        for (grains, bonds, walls) in
            [(soft, soft, true), (soft, stiff, true), ("", soft, true), (soft, "", true)]
        {
            let cement = format!("Cement(name: \"cement\", length: 0.1e-3, walls: {walls}),");
            let mut scene = pressed(grains, bonds, &cement);
            scene.analysis = analysis;
            for force in read(&scene, "f", "hold") {
                assert_within(force, 1000.0, 2e-6);
            }
        }
    }
}

/// Disks that fly apart from an overlap, cemented by a bond as stiff as their contact while it is
/// closed: the motion goes on as without cement.
#[test]
fn cement_leaves_a_motion_as_it_is() {
    let motion = |cement: &str| {
        let mut scene = pressed(
            "normal_stiffness: 1.0e7, tangential_stiffness: 1.0e7,",
            "normal_stiffness: 1.0e7, tangential_stiffness: 1.0e7,",
            cement,
        );
        scene.analysis = Dynamic { dt: 1e-6, theta: 0.5 };
        let swing = stage(&mut scene, "press");
        swing.analysis = None;
        swing.increments = 40;
        stage(&mut scene, "hold").increments = 40;
        let mut simulation = Simulation::new(&scene, None);
        while next(&mut simulation).is_some() {}
        states(&mut simulation)
    };
    let cement = r#"Cement(name: "cement", length: 0.1e-3),"#;
    for (with, without) in motion(cement).iter().zip(&motion("")) {
        assert!(without.velocity.length() > 1e-3, "it is a motion: {without:?}");
        assert_within(with.velocity.distance(without.velocity), 0.0, 1e-9);
    }
}

/// In a random packing, with other stiffnesses, and with those of the contacts where the bond names none:
/// bonds that were rigid lost the forces of elastic contacts under them. The stress changes by the turn
/// of the normals in the increment before, as it does without cement.
#[test]
fn cement_leaves_the_stress_of_a_cell_as_it_is() {
    for bonds in ["normal_stiffness: 6.0e7, tangential_stiffness: 2.0e7,", ""] {
        for stress in read(&cemented_cell(bonds), "s", "hold") {
            assert_within(stress, 100e3, 1e-3 * 100e3);
        }
    }
}

fn cemented_cell(bonds: &str) -> Scene {
    parse(&format!(
        r#"(version: 1, title: "cement in a cell",
        materials: {{ "sand": (contact: (normal_stiffness: 3.0e7, tangential_stiffness: 1.0e7, friction: 0.4),
            bond: ({bonds} {BOND})) }},
        specimen: Packing(count: 100, columns: 10, spacing: 10.1e-3,
            sizes: Uniform(radius: (3.0e-3, 5.0e-3)), seed: 5),
        cell: (size: (0.101, 0.101)),
        stages: [
            Compact(name: "compact", target: Porosity(0.2), step: 2.0e-3, agitation: 0.1, seed: 5),
            Load(name: "press", increments: 10, cell: (xx: Stress(100.0e3), yy: Stress(100.0e3), shear: Fixed)),
            Cement(name: "cement", length: 0.1e-3),
            Load(name: "hold", increments: 2, cell: (xx: Fixed, yy: Fixed, shear: Fixed)),
        ],
        measures: [(name: "s", of: Stress(Average(component: Yy, area: Cell)))])"#
    ))
}

/// Stiffness (N/m) of the bond between a disk of a and one of b, which a law of each material names or
/// not: twice the stiffness of the one was the mean of a stiffness and none.
#[test]
fn a_stiffness_that_one_of_two_materials_names_is_not_that_of_both() {
    let stiffness = |a: &str, b: &str| {
        let law = |contact: &str, bond: &str| {
            format!("(contact: (normal_stiffness: {contact}), bond: ({bond} {BOND}))")
        };
        let scene = parse(&format!(
            r#"(version: 1, title: "two materials",
            materials: {{ "a": {}, "b": {} }},
            specimen: Particles([(position: (0.0, 0.0), radius: 0.005, material: "a"),
                (position: (0.01, 0.0), radius: 0.005, material: "b")]),
            stages: [Cement(name: "cement", length: 1.0e-6), Load(name: "load", increments: 1, particles: [
                (select: Index([0]), x: Held, y: Held, rotation: Held),
                (select: Index([1]), x: Displacement(-1.0e-7), y: Held, rotation: Held)])],
            measures: [(name: "f", of: GroupForce(select: Index([0]), along: X))])"#,
            law("5.0e7", a),
            law("6.0e6", b),
        ));
        -read(&scene, "f", "load")[0] / 1e-7
    };
    let mean = |a: f64, b: f64| 2.0 * a * b / (a + b);
    assert_relative(stiffness("normal_stiffness: 3.0e7,", ""), mean(3e7, 6e6), 1e-6);
    assert_relative(stiffness("", "normal_stiffness: 8.0e6,"), mean(5e7, 8e6), 1e-6);
    assert_relative(stiffness("", ""), mean(5e7, 6e6), 1e-6);
}
