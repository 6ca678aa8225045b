//! Selections of particles: what is held, loaded and cemented.

use std::collections::BTreeSet;

use crate::common::*;
use clastic::components::bond::Bond;
use clastic::components::measure::Readings;
use clastic::run::Simulation;
use clastic::scene::format::Scene;

/// Rows of four disks of radius 0.01 m, two materials, on a floor.
fn rows(groups: &str, stages: &str) -> Scene {
    let disk = |k: usize| {
        let (x, y) = (0.02 * (k % 4) as f64 + 0.01, 0.02 * (k / 4) as f64 + 0.01);
        let material = if k.is_multiple_of(2) { "even" } else { "odd" };
        format!(
            "(position: ({x:?}, {y:?}), radius: 0.01, material: \"{material}\", probe: \"{k}\")"
        )
    };
    let disks: Vec<_> = (0..12).map(disk).collect();
    let laws = "contact: (normal_stiffness: 1e8), bond: (normal_stiffness: 1e8, tangential_stiffness: 5e7, cohesion: 1e6, tensile_strength: 1e6)";
    parse(&format!(
        "(version: 1, title: \"groups\", materials: {{
            \"even\": (density: 2000.0, {laws}), \"odd\": (density: 2000.0, {laws}) }},
          specimen: Particles([{}]), groups: {{ {groups} }},
          walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0))],
          stages: [{stages}])",
        disks.join(", ")
    ))
}

/// The particles that a selection moves by 1 mm along x.
fn moved_by(groups: &str, select: &str) -> Vec<usize> {
    let stages = format!(
        "Load(name: \"go\", increments: 1, particles: [
            (select: All, x: Held, y: Held, rotation: Held),
            (select: {select}, x: Displacement(1.0e-3))])"
    );
    let (records, _) = run(&rows(groups, &stages));
    let moved = |k: &usize| probe(&records[0], &k.to_string()).motion[0] > 0.5e-3;
    (0..12).filter(moved).collect()
}

#[test]
fn regions_and_sets_select_what_they_say() {
    let groups = "\"low\": Layer(normal: (0.0, 1.0), from: 0.0, to: 0.02),
        \"ell\": Union([Group(\"low\"), Polygon([(0.0, 0.0), (0.02, 0.0), (0.02, 0.06), (0.0, 0.06)])]),
        \"rest\": Except(All, Group(\"ell\"))";
    for (select, expected) in [
        ("Group(\"low\")", vec![0, 1, 2, 3]),
        ("Group(\"ell\")", vec![0, 1, 2, 3, 4, 8]),
        ("Group(\"rest\")", vec![5, 6, 7, 9, 10, 11]),
        ("Intersection([Group(\"rest\"), Material(\"odd\")])", vec![5, 7, 9, 11]),
        ("Index([9, 10, 11])", vec![9, 10, 11]),
        ("Circle(centre: (0.03, 0.03), radius: 0.021)", vec![1, 4, 5, 6, 9]),
        ("Layer(normal: (1.0, 1.0), from: 0.08, to: 1.0)", vec![11]),
    ] {
        assert_eq!(moved_by(groups, select), expected, "{select}");
    }
}

/// A group is asked when its stage begins: what has left it by then is free, and what leaves it in
/// the stage is not.
#[test]
fn a_group_is_of_the_start_of_its_stage() {
    let push = |name: &str| {
        format!(
            "Load(name: \"{name}\", increments: 4, particles: [
                (select: All, x: Held, y: Held, rotation: Held),
                (select: Group(\"left\"), x: Displacement(3.0e-3))])"
        )
    };
    let groups = "\"left\": Layer(normal: (1.0, 0.0), from: 0.0, to: 0.02)";
    let mut scene = rows(groups, &format!("{}, {}", push("first"), push("second")));
    let clastic::scene::format::Specimen::Particles(list) = &mut scene.specimen else {
        panic!("explicit particles")
    };
    list.truncate(1);
    let mut simulation = Simulation::new(&scene, None);
    let mut places = Vec::new();
    let outcome = loop {
        match simulation.step() {
            clastic::run::Step::Increment => places.push(states(&mut simulation)[0].position.x),
            clastic::run::Step::Finished(outcome) => break outcome,
        }
    };
    assert_within(*places.last().unwrap(), 0.022, 1e-15);
    assert_eq!(places.len(), 4, "{outcome:?}");
    let refused =
        matches!(&outcome, clastic::run::Outcome::Refused { stage, .. } if stage == "second");
    assert!(refused, "{outcome:?}");
}

/// Bonds of a cement by the particles of a selection, by walls only, and with a law of its own.
#[test]
fn cement_takes_a_selection_and_a_law() {
    let bonds = |fields: &str| {
        let stages = format!(
            "Cement(name: \"cement\", length: 1.0e-4{fields}), Load(name: \"rest\", increments: 1)"
        );
        let mut simulation = Simulation::new(&rows("\"low\": Index([0, 1, 2, 3])", &stages), None);
        next(&mut simulation).unwrap();
        let world = simulation.world_mut();
        let mut query = world.query::<&Bond>();
        query.iter(world).copied().collect::<Vec<_>>()
    };
    // Nine along the rows, eight across them.
    assert_eq!(bonds("").len(), 17);
    assert_eq!(bonds(", select: Group(\"low\")").len(), 3);
    assert_eq!(bonds(", walls: true, select: Group(\"low\")").len(), 7);
    let feet = bonds(", walls: true, particles: false");
    let of: BTreeSet<_> = feet.iter().map(|bond| (bond.a.0, bond.b.0)).collect();
    assert_eq!(of, (0..4).map(|k| (k, 12)).collect());
    let strong = bonds(", bond: (cohesion: 3.0e6, tensile_strength: 2.0e6)");
    assert_eq!(strong.len(), 17);
    assert!(
        strong.iter().all(|bond| bond.law.cohesion == 3e6 && bond.law.normal_compliance == 1e-8)
    );
}

/// Values of the named measures after every increment.
fn readings(scene: &Scene) -> Vec<(Vec<Option<f64>>, Vec<[f64; 3]>)> {
    let mut simulation = Simulation::new(scene, None);
    let mut rows = Vec::new();
    while let Some(record) = next(&mut simulation) {
        let probes = record.probes.iter().map(|probe| probe.force).collect();
        rows.push((simulation.world().resource::<Readings>().0.clone(), probes));
    }
    rows
}

/// The boundary of a group carries its weight, and force and moment on a rigid group are those of
/// its members, in statics and in dynamics.
#[test]
fn the_force_on_a_group_is_that_on_its_boundary() {
    for analysis in ["Static", "Dynamic(dt: 1e-3)"] {
        let scene = parse(&format!(
            "(version: 1, title: \"groups\", analysis: {analysis}, gravity: (0.0, -9.81),
              materials: {{ \"m\": (density: 2000.0,
                contact: (normal_stiffness: 1e7, tangential_stiffness: 1e7, friction: 0.5)) }},
              specimen: Lattice(columns: 5, rows: 4, radius: 0.01),
              walls: [(name: \"floor\", start: (-1.0, -0.01), end: (1.0, -0.01),
                contact: (normal_stiffness: 1e7, tangential_stiffness: 1e7, friction: 0.5))],
              stages: [Load(name: \"push\", increments: 4, rigid: {{
                \"clump\": (select: Index([9, 10, 14]), force: (2.0, -3.0), moment: 0.01) }})],
              measures: [
                (name: \"x\", of: GroupForce(select: Index([9, 10, 14]))),
                (name: \"y\", of: GroupForce(select: Index([9, 10, 14]), along: Y)),
                (name: \"m\", of: GroupForce(select: Index([9, 10, 14]), along: Moment, live: true)),
                (name: \"all\", of: GroupForce(select: All, along: Y)),
                (name: \"none\", of: GroupForce(select: Circle(centre: (9.0, 9.0), radius: 0.1), live: true)),
              ])"
        ));
        let mass = 2000.0 * std::f64::consts::PI * 1e-4;
        for (values, probes) in readings(&scene) {
            for k in 0..3 {
                assert_within(values[k].unwrap(), probes[0][k], 1e-9);
            }
            if analysis == "Static" {
                // The floor carries 18 disks and what the load of the clump has reached.
                let weight = 18.0 * mass * 9.81;
                let load = values[3].unwrap() - weight;
                assert!((0.7..3.1).contains(&load), "{load}");
                assert_within(values[1].unwrap(), 3.0 * mass * 9.81 + load, 1e-6 * weight);
            }
            assert_eq!(values[4], None);
        }
    }
}

/// A fixed group keeps its particles, a live one has those that are in its region.
#[test]
fn a_live_group_has_the_particles_that_are_there() {
    let scene = parse(
        "(version: 1, title: \"fall\", analysis: Dynamic(dt: 1e-2), gravity: (0.0, -9.81),
          materials: { \"m\": (density: 2000.0) },
          specimen: Particles([(position: (0.0, 0.01), radius: 0.01), (position: (0.5, 0.5), radius: 0.01)]),
          walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0))],
          stages: [Load(name: \"fall\", increments: 60)],
          measures: [
            (name: \"fixed\", of: GroupForce(select: Box(min: (-1.0, 0.0), max: (1.0, 0.1)), along: Y)),
            (name: \"live\", of: GroupForce(select: Box(min: (-1.0, 0.0), max: (1.0, 0.1)), along: Y, live: true)),
          ])",
    );
    let weight = 2000.0 * std::f64::consts::PI * 1e-4 * 9.81;
    let rows = readings(&scene);
    assert_relative(rows[2].0[1].unwrap(), weight, 1e-6);
    let last = &rows.last().unwrap().0;
    assert_relative(last[0].unwrap(), weight, 1e-6);
    assert_relative(last[1].unwrap(), 2.0 * weight, 1e-6);
}

/// A specimen file names groups; a misspelt one is refused.
#[test]
fn a_specimen_file_gives_its_particles_groups() {
    let folder = tempfile::tempdir().unwrap();
    let csv = "x_m,y_m,group,radius_m\n0.0,0.01,,0.01\n0.1,0.01,jaw,0.01\n0.2,0.01,jaw,0.01\n";
    std::fs::write(folder.path().join("p.csv"), csv).unwrap();
    let read = |group: &str| {
        let text = format!(
            "(version: 1, title: \"file\", materials: {{ \"m\": (density: 2000.0) }},
              specimen: File(path: \"p.csv\"), probes: {{ \"a\": 0, \"b\": 1, \"c\": 2 }},
              stages: [Load(name: \"go\", increments: 1, particles: [
                (select: All, x: Held, y: Held), (select: Group(\"{group}\"), x: Displacement(1.0e-3))])])"
        );
        clastic::scene::from_str(&text, "s.ron".as_ref(), folder.path(), &[])
    };
    let loaded = read("jaw").unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let record = next(&mut simulation).unwrap();
    let moved = ["a", "b", "c"].map(|name| probe(&record, name).motion[0] > 0.5e-3);
    assert_eq!(moved, [false, true, true]);
    let error = read("jav").unwrap_err().to_string();
    assert!(error.contains("unknown group (`jav`)") && error.contains("`jaw`"), "{error}");
}
