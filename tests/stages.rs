//! From stage to stage: what a stage leaves to the next one, and what ends it.

mod common;

use clastic::components::observation::Observation;
use clastic::run::EndedBy;
use clastic::run::stages::Script;
use clastic::run::{Simulation, StageEnd};
use common::*;

/// A disk between a floor and a lid; the rest is the stages and, if any, measures.
fn pressed(rest: &str) -> String {
    format!(
        r#"(
            version: 1, title: "pressed",
            materials: {{ "stone": (contact: (normal_stiffness: 1.0e6)) }},
            specimen: Particles([(position: (0.0, 0.5), radius: 0.5, probe: "disk")]),
            walls: [
                (name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), probe: "floor",
                    contact: (normal_stiffness: 1.0e6)),
                (name: "lid", start: (1.0, 1.0), end: (-1.0, 1.0), probe: "lid",
                    contact: (normal_stiffness: 1.0e6)),
            ],
            {rest}
        )"#
    )
}

fn records(text: &str) -> Vec<Observation> {
    run(&parse(text)).0
}

#[test]
fn loads_of_a_stage_that_ends_early_go_on_from_where_they_were() {
    let records = records(&pressed(
        r#"
        stages: [
            // One newton more on lid and disk in every increment; the floor yields by F/k.
            Load(name: "ramp", increments: 10, walls: { "lid": Force(10.0) },
                particles: [(select: Probe("disk"), x: Held, rotation: Held, force: (0.0, -10.0))],
                stop: [AxialStrain(8.5e-6)]),
            Load(name: "hold", increments: 2,
                particles: [(select: Probe("disk"), x: Held, rotation: Held)]),
            Load(name: "more", increments: 3, walls: { "lid": Force(6.0) },
                particles: [(select: Probe("disk"), x: Held, rotation: Held, force: (0.0, -9.0))]),
        ],
        measures: (reference_stage: "ramp", axial_strain: Walls("floor", "lid")),
        "#,
    ));
    let forces = |name: &str| -> Vec<f64> {
        let readings = records.iter().map(|o| probe(o, name).force[1]);
        readings.collect()
    };
    // After three increments the lid has come down by 3 N/k and the 6 N/k of the floor.
    let lid = [-1.0, -2.0, -3.0, -3.0, -3.0, -4.0, -5.0, -6.0];
    let floor = [2.0, 4.0, 6.0, 6.0, 6.0, 9.0, 12.0, 15.0];
    for (found, expected) in [(forces("lid"), lid), (forces("floor"), floor)] {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert_relative(*found, expected, 1e-8);
        }
    }
}

/// Walls that follow loads, and those that are taken away, are in nobody's way.
#[test]
fn a_wall_may_move_far_where_the_opposite_one_gives_way_or_is_gone() {
    let stage = |rest: &str| {
        let lid = r#""lid": Displacement(0.0, -0.2)"#;
        pressed(&format!(r#"stages: [Load(name: "move", increments: 10, {rest})],"#))
            .replace("LID", lid)
    };
    parse(&stage(r#"walls: { LID, "floor": Force(1.0) }"#));
    parse(&stage(r#"walls: { LID }, remove_walls: ["floor"]"#));
    parse(&stage(r#"walls: { LID, "floor": Displacement(0.0, -0.2) }"#));
    let refused = std::panic::catch_unwind(|| parse(&stage("walls: { LID }")));
    assert!(refused.is_err(), "the lid passes through the floor");
}

#[test]
fn particles_of_a_packing_can_be_probes() {
    let text = r#"(
        version: 1, title: "marked",
        materials: { "stone": () },
        specimen: Lattice(columns: 3, rows: 3, radius: 0.5, origin: (0.0, 0.0)),
        probes: { "seventh": 7, "first": 0 },
        stages: [Load(name: "move", increments: 1, particles: [
            (select: All, x: Held, y: Held, rotation: Held),
            (select: Probe("seventh"), x: Displacement(1.0e-3), y: Held, rotation: Held),
        ])],
    )"#;
    let records = records(text);
    let names: Vec<_> = records[0].probes.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["first", "seventh"]);
    for (probe, expected) in records[0].probes.iter().zip([0.0, 1e-3]) {
        assert_within(probe.motion[0], expected, 1e-12);
    }
}

#[test]
fn stress_drop_ends_a_tension_test() {
    let text = r#"(
        version: 1, title: "pulled",
        materials: { "cemented": (
            contact: (normal_stiffness: 1.0e6),
            bond: (normal_stiffness: 1.0e6, tensile_strength: 10.0, cohesion: 100.0),
        ) },
        specimen: Particles([
            (position: (0.0, 0.0), radius: 0.5), (position: (1.0, 0.0), radius: 0.5),
        ]),
        bonds: [(a: 0, b: 1)],
        stages: [Load(name: "pull", increments: 30, stop: [StressDrop(0.5)], particles: [
            (select: Index([0]), x: Held, y: Held, rotation: Held),
            (select: Index([1]), x: Displacement(1.0e-6), y: Held, rotation: Held),
        ])],
        measures: (
            axial_strain: Particles(0, 1),
            axial_stress: Average(component: Xx, area: Fixed(1.0)),
        ),
    )"#;
    let mut simulation = Simulation::new(&parse(text), None);
    let mut last = None;
    let mut greatest = 0.0_f64;
    while let Some(record) = next(&mut simulation) {
        greatest = greatest.min(record.axial_stress.unwrap());
        last = Some(record);
    }
    let script = simulation.world().resource::<Script>();
    let [StageEnd { ended_by, .. }] = script.ends.as_slice() else { panic!("{:?}", script.ends) };
    assert_eq!(*ended_by, Some(EndedBy::Stop));
    // It stopped in the increment after the break, long before the last.
    assert!(greatest < 0.0 && last.unwrap().increment < 30, "{greatest}");
}
