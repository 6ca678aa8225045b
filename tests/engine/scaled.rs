//! Factors on gravity, strength and loads over a stage, and grains that are counted where they are.

use clastic::components::increment::ClasticProgress;
use clastic::components::observation::Observation;
use clastic::run::measures::reading;
use clastic::run::{Outcome, Simulation, Step};

use crate::common::{parse, probe};

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

/// Share of the way of the loads after each of eight increments.
const COURSE: &str =
    "increments: 8, scale: (loads: [(0.0, 0.0), (0.25, 1.0), (0.5, 0.25), (1.0, 0.75)])";
const SHARES: [f64; 8] = [0.5, 1.0, 0.625, 0.25, 0.375, 0.5, 0.625, 0.75];

/// Runs a stage with COURSE, an increment that keeps the load (`None`), and two in which a load twice as
/// large comes linearly. `read` divides what the specimen does by what it does under the whole load.
fn follows_its_course(
    head: &str,
    load: impl Fn(Option<f64>) -> String,
    read: impl Fn(&Simulation) -> f64,
) {
    let [load, keep, twice] = [Some(1.0), None, Some(2.0)].map(load);
    let scene = parse(&format!(
        "(version: 1, title: \"a course\",
        materials: {{ \"rock\": (density: 2500.0, contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8),
            bond: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, cohesion: 1.0e9, tensile_strength: 1.0e9)) }},
        {head}
        stages: [Load(name: \"course\", {COURSE}, {load}), Load(name: \"keep\", increments: 1, {keep}),
            Load(name: \"linear\", increments: 2, {twice})])"
    ));
    let mut simulation = Simulation::new(&scene, None);
    let mut found = Vec::new();
    while simulation.step() == Step::Increment {
        found.push(read(&simulation));
    }
    let expected = SHARES.into_iter().chain([0.75, 0.5 * (0.75 + 2.0), 2.0]);
    assert_eq!(found.len(), 11, "{load}");
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{load}: {found:?}");
}

/// A square of four disks in a box with a lid: two columns of three springs of 1e8 N/m.
const COLUMNS: &str = r#"specimen: Particles([(position: (0.1, 0.1), radius: 0.1), (position: (0.3, 0.1), radius: 0.1),
        (position: (0.1, 0.3), radius: 0.1, probe: "disk"), (position: (0.3, 0.3), radius: 0.1)]),
    walls: [(name: "floor", start: (0.0, 0.0), end: (0.4, 0.0), contact: (normal_stiffness: 1.0e8)),
        (name: "lid", start: (0.4, 0.4), end: (0.0, 0.4), contact: (normal_stiffness: 1.0e8), probe: "lid"),
        (name: "left", start: (0.0, 0.4), end: (0.0, 0.0)), (name: "right", start: (0.4, 0.0), end: (0.4, 0.4))],
    measures: [(name: "mean", of: Stress(Average(component: Yy, area: Fixed(0.16))))],"#;

/// How far a probe moved down, over what 1 kN does on each of two springs in a row, or on three.
fn sunk(simulation: &Simulation, name: &str, springs: f64) -> f64 {
    let record = simulation.world().resource::<Observation>();
    -probe(record, name).motion[1] / (springs * 1.0e3 / 1.0e8)
}

/// An entry for a load, and nothing for one that is kept.
fn loaded(entry: impl Fn(f64) -> String) -> impl Fn(Option<f64>) -> String {
    move |f| f.map(&entry).unwrap_or_default()
}

#[test]
fn forces_and_stresses_of_walls_follow_the_course() {
    let controls = [
        |f| format!("Force({:?})", 2.0e3 * f),
        |f| format!("Stress(stress: {:?})", 5.0e3 * f),
        |f| format!("Lid(load: Force({:?}), slide: Displacement(0.0))", 2.0e3 * f),
    ];
    for control in controls {
        let load = loaded(|f| format!("walls: {{ \"lid\": {} }}", control(f)));
        follows_its_course(COLUMNS, load, |run| sunk(run, "lid", 3.0));
    }
}

#[test]
fn forces_and_moments_of_particles_follow_the_course() {
    let load =
        loaded(|f| format!("particles: [(select: Index([2]), force: (0.0, {:?}))]", -1.0e3 * f));
    follows_its_course(COLUMNS, load, |run| sunk(run, "disk", 2.0));
    // A bond to a disk that is held resists by its shear alone: k_T r^2 = 1e6 N m/rad.
    let pair = r#"specimen: Particles([(position: (0.0, 0.0), radius: 0.1), (position: (0.2, 0.0), radius: 0.1, probe: "disk")]),
        bonds: [(a: 0, b: 1)],"#;
    let load = |f: Option<f64>| {
        let moment = f.map(|f| format!(", moment: {f:?}")).unwrap_or_default();
        format!(
            "particles: [(select: Index([0]), x: Held, y: Held, rotation: Held),
                (select: Index([1]), x: Held, y: Held{moment})]"
        )
    };
    let turned = |run: &Simulation| probe(run.world().resource(), "disk").motion[2] / 1.0e-6;
    follows_its_course(pair, load, turned);
}

#[test]
fn loads_of_rigid_groups_follow_the_course() {
    let pair = r#"specimen: Particles([(position: (0.1, 0.1), radius: 0.1), (position: (0.3, 0.1), radius: 0.1)]),
        walls: [(name: "floor", start: (0.0, 0.0), end: (0.4, 0.0), contact: (normal_stiffness: 1.0e8))],"#;
    for kind in ["force: (0.0, -#)", "stress: (value: (0.0, -#), length: 1.0)"] {
        let load = loaded(|f| {
            let load = kind.replace('#', &format!("{:?}", 2.0e3 * f));
            let select = if f == 1.0 { "select: All," } else { "" };
            format!("rigid: {{ \"pair\": ({select} x: Held, rotation: Held, {load}) }}")
        });
        follows_its_course(pair, load, |run| sunk(run, "pair", 1.0));
    }
}

/// A triangular lattice of eight columns and rows.
fn lattice() -> String {
    let place = |k: i32| {
        let (row, column) = (k / 8, k % 8);
        let x = 0.2 * f64::from(column) + 0.1 * f64::from(row % 2);
        format!("(position: ({x:?}, {:?}), radius: 0.1)", 0.1 * 3.0_f64.sqrt() * f64::from(row))
    };
    (0..64).map(place).collect::<Vec<_>>().join(", ")
}

/// The mean stress of the lattice over an area follows loads in kPa.
fn mean_stress_follows(head: &str, area: &str, load: impl Fn(f64) -> String) {
    let head = format!(
        "specimen: Particles([{}]), {head}
        measures: [(name: \"mean\", of: Stress(Average(component: Mean, area: {area})))],",
        lattice()
    );
    follows_its_course(&head, loaded(load), |run| reading(run.world(), "mean").unwrap() / 1.0e3);
}

#[test]
fn stresses_of_a_cell_follow_the_course() {
    let cell = format!("cell: (size: (1.6, {:?})),", 0.8 * 3.0_f64.sqrt());
    mean_stress_follows(&cell, "Cell", |f| {
        format!("cell: (xx: Stress({0:?}), yy: Stress({0:?}))", 1.0e3 * f)
    });
}

#[test]
fn pressures_of_membranes_follow_the_course() {
    mean_stress_follows("", "Membrane(\"skin\")", |f| {
        format!("membranes: {{ \"skin\": (pressure: {:?}) }}", 1.0e3 * f)
    });
}

/// In a dynamic stage s is the time. A free disk of mass m under F f(t) has the speed of the sum of F
/// f dt / m over the ends of the time steps.
#[test]
fn in_a_dynamic_stage_the_course_is_one_of_time() {
    let scene = parse(
        r#"(version: 1, title: "a free disk", analysis: Dynamic(dt: 0.1), materials: { "rock": (density: 2500.0) },
        specimen: Particles([(position: (0.0, 0.0), radius: 0.1, probe: "disk")]),
        stages: [Load(name: "push", increments: 4, scale: (loads: [(0.0, 0.0), (0.2, 2.0), (0.4, -1.0)]),
            particles: [(select: All, force: (10.0, 0.0))])],
        measures: [(name: "energy", of: KineticEnergy)])"#,
    );
    let mut simulation = Simulation::new(&scene, None);
    let mass = 2500.0 * std::f64::consts::PI * 0.01;
    let mut impulse = 0.0;
    for share in [1.0, 2.0, 0.5, -1.0] {
        assert_eq!(simulation.step(), Step::Increment);
        impulse += 10.0 * share * 0.1;
        let energy = reading(simulation.world(), "energy").unwrap();
        assert!((energy / (0.5 * impulse * impulse / mass) - 1.0).abs() < 1e-6, "{energy}");
    }
}

/// A part of an increment has a part of its step, and the stage after it starts from there.
#[test]
fn a_course_that_ends_early_keeps_the_load_that_it_has_reached() {
    let load = "walls: { \"lid\": Force(2.0e3) }, stop: [Until(\"mean\", 2.0e3)]";
    let scene = parse(&format!(
        "(version: 1, title: \"a course\", materials: {{ \"rock\": (density: 2500.0, contact: (normal_stiffness: 1.0e8)) }},
        {COLUMNS} stages: [Load(name: \"course\", {COURSE}, {load}), Load(name: \"keep\", increments: 1)])"
    ));
    let mut simulation = Simulation::new(&scene, None);
    assert_eq!(simulation.run(), Outcome::Completed);
    // 0.4 m under 800 N.
    assert_eq!(simulation.world().resource::<Observation>().stage, "keep");
    assert!((sunk(&simulation, "lid", 3.0) - 0.4).abs() < 1e-6);
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
