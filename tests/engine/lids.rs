//! Lids that slide under a load, and walls that follow a table.

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;
use clastic::scene::format::{FrictionLaw, Scene};

/// Three disks side by side between a floor and a lid, held apart. `law` is the contact with lid
/// and floor.
fn sheared(analysis: &str, law: &str, stages: &str) -> Scene {
    parse(&format!(
        "(version: 1, title: \"lid\", analysis: {analysis},
          materials: {{ \"m\": (density: 2000.0) }},
          specimen: Particles([
            (position: (0.1, 0.05), radius: 0.05), (position: (0.25, 0.05), radius: 0.05),
            (position: (0.4, 0.05), radius: 0.05),
          ]),
          walls: [
            (name: \"floor\", start: (0.0, 0.0), end: (0.5, 0.0), probe: \"floor\", contact: ({law})),
            (name: \"lid\", start: (0.5, 0.1), end: (0.0, 0.1), probe: \"lid\", contact: ({law})),
            (name: \"left\", start: (0.0, 0.2), end: (0.0, 0.0)),
            (name: \"right\", start: (0.5, 0.0), end: (0.5, 0.2)),
          ],
          stages: [{stages}])"
    ))
}

const ELASTIC: &str = "normal_stiffness: 1.0e8, tangential_stiffness: 5.0e7, friction: 0.4";
const HELD: &str = "particles: [(select: All, x: Held, rotation: Held)]";

fn both_laws(scene: &Scene, check: impl Fn(&[Observation])) {
    for law in [FrictionLaw::Associated, FrictionLaw::COULOMB] {
        let mut scene = scene.clone();
        scene.friction_law = law;
        let (records, _) = run(&scene);
        assert!(records.iter().all(|o| o.status == IncrementStatus::Solved));
        check(&records);
    }
}

/// The normal force on a lid is its stress times its length, and held disks slide under it with mu
/// times that. The lid runs from right to left: it is moved to the left.
#[test]
fn a_lid_carries_its_stress_and_drags_with_mu_times_it() {
    let force = 20e3 * 0.5;
    for contact in [ELASTIC, "friction: 0.4"] {
        for (load, name) in [
            ("Stress(stress: 20.0e3)", "drawn length"),
            ("Stress(stress: 20.0e3, between: (\"left\", \"right\"))", "distance"),
            ("Force(10.0e3)", "force"),
        ] {
            let stages = format!(
                "Load(name: \"press\", increments: 2, {HELD},
                    walls: {{ \"lid\": Lid(load: {load}, slide: Displacement(0.0)) }}),
                 Load(name: \"shear\", increments: 20, {HELD},
                    walls: {{ \"lid\": Lid(load: {load}, slide: Displacement(1.0e-5)) }}),
                 Load(name: \"stay\", increments: 2, {HELD})"
            );
            both_laws(&sheared("Static", contact, &stages), |records| {
                for o in records.iter().filter(|o| o.stage != "press") {
                    assert_relative(probe(o, "lid").force[1], -force, 1e-7);
                    assert_relative(probe(o, "floor").force[1], force, 1e-7);
                }
                let sheared = &records[21];
                assert_eq!(sheared.stage, "shear", "{name}");
                assert_within(probe(sheared, "lid").motion[0], -20e-5, 1e-15);
                assert_relative(probe(sheared, "lid").force[0], -0.4 * force, 1e-7);
                // It stops with its stage, and keeps its load.
                assert_within(probe(&records[23], "lid").motion[0], -20e-5, 1e-15);
            });
        }
    }
}

/// In dynamics a lid slides with a velocity, and its load stands as exactly as in statics.
#[test]
fn a_lid_slides_with_a_velocity_in_dynamics() {
    let stages = format!(
        "Load(name: \"shear\", increments: 50, {HELD}, walls: {{
            \"lid\": Lid(load: Force(10.0e3), slide: Velocity(-0.5)) }})"
    );
    for theta in [0.5, 1.0] {
        let analysis = format!("Dynamic(dt: 1e-4, theta: {theta:?})");
        let scene = sheared(&analysis, "friction: 0.4", &stages);
        both_laws(&scene, |records| {
            let last = records.last().unwrap();
            assert_within(probe(last, "lid").motion[0], 0.5 * 50e-4, 1e-12);
            assert_relative(probe(last, "lid").force[1], -10e3, 1e-7);
            assert_relative(probe(last, "lid").force[0], 4e3, 1e-7);
        });
    }
}

/// Displacement and force at the points of their tables, linear between them.
#[test]
fn a_wall_follows_its_table() {
    let stages = format!(
        "Load(name: \"follow\", increments: 8, {HELD}, walls: {{
            \"lid\": Follow(Force([(0.0, 0.0), (0.25, 8.0e3), (1.0, 2.0e3)])),
            \"right\": Follow(Displacement([(0.0, 0.0, 0.0), (0.5, 0.02, 0.0), (1.0, -0.01, 0.03)])),
        }}),
        Load(name: \"keep\", increments: 1, {HELD})"
    );
    let mut scene = sheared("Static", ELASTIC, &stages);
    scene.walls[3].probe = Some("right".into());
    let force = [4e3, 8e3, 7e3, 6e3, 5e3, 4e3, 3e3, 2e3, 2e3];
    let place = [0.005, 0.01, 0.015, 0.02, 0.0125, 0.005, -0.0025, -0.01, -0.01];
    let check = |records: &[Observation]| {
        assert_eq!(records.len(), 9);
        for (k, o) in records.iter().enumerate() {
            assert_relative(probe(o, "lid").force[1], -force[k], 1e-7);
            assert_within(probe(o, "right").motion[0], place[k], 1e-15);
        }
        assert_within(probe(&records[8], "right").motion[1], 0.03, 1e-15);
    };
    both_laws(&scene, check);
    // The same over time, 8 increments of 1 ms.
    let stages = stages.replace("0.25,", "2.0e-3,").replace("(0.5,", "(4.0e-3,");
    let stages = stages.replace("(1.0,", "(8.0e-3,");
    let mut scene = sheared("Dynamic(dt: 1e-3)", "friction: 0.4", &stages);
    scene.walls[3].probe = Some("right".into());
    both_laws(&scene, check);
}
