//! Measures against values by hand on ten disks: fabric, strain and stress tensors, fragments and
//! cracks. `tests/program/measures.rs` has a run against an independent calculation.

use std::f64::consts::{FRAC_PI_2, PI};

use clastic::run::measures::reading;
use clastic::run::{Simulation, Step};
use glam::DVec2;

use crate::common::{assert_relative, assert_within, next, parse, states};

/// Normal stiffness, shear stiffness, N/m; strain of an increment.
const K: [f64; 2] = [1.0e6, 0.4e6];
const E: f64 = 1.0e-5;

/// Rows of 3, 4 and 3 touching disks of 1 m.
fn ten() -> Vec<DVec2> {
    let row = |n: usize, x: f64, y: f64| (0..n).map(move |i| DVec2::new(x + 2.0 * i as f64, y));
    let h = 3.0_f64.sqrt();
    row(3, 0.0, 0.0).chain(row(4, -1.0, h)).chain(row(3, 0.0, 2.0 * h)).collect()
}

/// All of them bonded but the last one, and moved by an affine field with a rotation.
fn deformed() -> Simulation {
    let list: Vec<_> =
        ten().iter().map(|x| format!("(position: ({:?}, {:?}), radius: 1.0)", x.x, x.y)).collect();
    let law = format!("normal_stiffness: {:?}, tangential_stiffness: {:?}", K[0], K[1]);
    let scene = parse(&format!(
        r#"(
        version: 1, title: "ten disks", thickness: 0.5,
        materials: {{ "m": (contact: ({law}, friction: 10.0),
            bond: ({law}, cohesion: 1.0e9, tensile_strength: 1.0e9)) }},
        specimen: Particles([{}]),
        stages: [
            Cement(name: "cement", length: 0.1, select: Except(All, Index([9]))),
            Load(name: "press", increments: 1, particles: [(select: All, rotation: Held,
                affine: (({:?}, {:?}), (0.0, {:?})))]),
        ],
        measures: [
            (name: "axial_strain", of: Strain(Region(component: Yy, min: (-2.0, -1.0), max: (6.0, 4.0)))),
            (name: "lateral_strain", of: Strain(Region(component: Xx, min: (-2.0, -1.0), max: (6.0, 4.0)))),
            (name: "e_xy", of: Strain(Region(component: Xy, min: (-2.0, -1.0), max: (6.0, 4.0)))),
            (name: "e_1", of: Strain(Region(component: Major, min: (-2.0, -1.0), max: (6.0, 4.0)))),
            (name: "e_3", of: Strain(Region(component: Minor, min: (-2.0, -1.0), max: (6.0, 4.0)))),
            (name: "e_v", of: Strain(Region(component: Volumetric, min: (-2.0, -1.0), max: (6.0, 4.0)))),
            (name: "turn", of: Strain(Region(component: Rotation, min: (-2.0, -1.0), max: (6.0, 4.0)))),
            (name: "upper", of: Strain(Region(component: Yy, min: (-2.0, 1.0), max: (6.0, 4.0)))),
            (name: "in a row", of: Strain(Region(component: Yy, min: (-2.0, 3.0), max: (6.0, 4.0)))),
            (name: "f_xx", of: Fabric(component: Xx)), (name: "f_yy", of: Fabric(component: Yy)),
            (name: "f_xy", of: Fabric(component: Xy)), (name: "a", of: Fabric(component: Anisotropy)),
            (name: "at", of: Fabric(component: Direction)),
            (name: "strong f_xx", of: Fabric(component: Xx, network: Strong)),
            (name: "strong f_yy", of: Fabric(component: Yy, network: Strong)),
            (name: "strong a", of: Fabric(component: Anisotropy, network: Strong)),
            (name: "strong at", of: Fabric(component: Direction, network: Strong)),
            (name: "fragments", of: Fragments(Number)), (name: "largest", of: Fragments(Largest)),
            (name: "share", of: Fragments(LargestShare)), (name: "single", of: Fragments(Single)),
            (name: "s_xx", of: Stress(Average(component: Xx, area: Fixed(30.0)))),
            (name: "s_yy", of: Stress(Average(component: Yy, area: Fixed(30.0)))),
            (name: "s_xy", of: Stress(Average(component: Xy, area: Fixed(30.0)))),
            (name: "s", of: Stress(Average(component: Mean, area: Fixed(30.0)))),
            (name: "s_1", of: Stress(Average(component: Major, area: Fixed(30.0)))),
            (name: "s_3", of: Stress(Average(component: Minor, area: Fixed(30.0)))),
            (name: "z", of: Coordination()), (name: "volume", of: VolumetricStrain),
            (name: "psi", of: DilationAngle()), (name: "length", of: Cracks(part: Length)),
            (name: "along", of: Cracks(part: Direction)),
        ],
    )"#,
        list.join(", "),
        -E,
        0.5 * E,
        -2.0 * E
    ));
    let mut simulation = Simulation::new(&scene, None);
    assert_eq!(simulation.step(), Step::Increment);
    simulation
}

#[test]
fn tensors_of_ten_disks_agree_with_a_calculation_by_hand() {
    let simulation = deformed();
    let value = |name| reading(simulation.world(), name).unwrap_or(f64::NAN);
    // The strain is that of the field.
    for (name, strain) in [
        ("axial_strain", 2.0 * E),
        ("lateral_strain", E),
        ("e_xy", -0.25 * E),
        ("e_v", 3.0 * E),
        ("turn", -0.25 * E),
        ("upper", 2.0 * E),
        ("e_1", 1.5 * E + (0.5 * E).hypot(0.25 * E)),
        ("e_3", 1.5 * E - (0.5 * E).hypot(0.25 * E)),
        ("volume", 1.0 - (1.0 - 2.0 * E) * (1.0 - E)),
    ] {
        assert_relative(value(name), strain, 1e-9);
    }
    // Three disks in a row leave the strain across the row open. Both sides shorten by less than
    // they are sheared.
    assert!(value("in a row").is_nan() && value("psi").is_nan());
    // Seven pairs along x, six at 60 degrees and six at 120 degrees; those along x are the weak
    // ones. The normals turn by no more than the strain.
    for (name, expected) in [
        ("f_xx", (7.0 + 12.0 / 4.0) / 19.0),
        ("f_yy", 12.0 * 0.75 / 19.0),
        ("a", 2.0 / 19.0),
        ("strong f_xx", 0.25),
        ("strong f_yy", 0.75),
        ("strong a", 1.0),
        ("z", 38.0 / 10.0),
    ] {
        assert_within(value(name), expected, 4.0 * E);
    }
    assert!(value("f_xy").abs() < E && value("at").abs() < 20.0 * E);
    // An axis has two angles that differ by pi.
    assert_within(value("strong at").abs(), FRAC_PI_2, 4.0 * E);
    // Spring forces over branches of 2 m: Love and Weber's sum.
    let disks = ten();
    let mut sum = [[0.0; 2]; 2];
    for (i, a) in disks.iter().enumerate() {
        for b in &disks[i + 1..] {
            let l = *b - *a;
            if l.length() > 2.1 {
                continue;
            }
            let n = l.normalize();
            let moved = DVec2::new(-E * l.x + 0.5 * E * l.y, -2.0 * E * l.y);
            let f = -K[0] * moved.dot(n) * n - K[1] * moved.dot(n.perp()) * n.perp();
            for (row, f) in sum.iter_mut().zip(f.to_array()) {
                for (s, l) in row.iter_mut().zip(l.to_array()) {
                    *s += f * l / (30.0 * 0.5);
                }
            }
        }
    }
    let (xx, yy, xy) = (sum[0][0], sum[1][1], 0.5 * (sum[0][1] + sum[1][0]));
    let radius = (0.5 * (xx - yy)).hypot(xy);
    for (name, expected) in [
        ("s_xx", xx),
        ("s_yy", yy),
        ("s_xy", xy),
        ("s", 0.5 * (xx + yy)),
        ("s_1", 0.5 * (xx + yy) + radius),
        ("s_3", 0.5 * (xx + yy) - radius),
    ] {
        assert_relative(value(name), expected, 1e-4);
    }
    // The tenth disk is alone, and nothing is cracked.
    let counts = ["fragments", "largest", "single", "length"].map(value);
    assert_eq!(counts, [2.0, 9.0, 1.0, 0.0]);
    assert_relative(value("share"), 0.9, 1e-14);
    assert!(value("along").is_nan());
}

#[test]
fn a_crack_has_the_length_and_the_direction_of_the_bond_that_broke() {
    // Two pairs are pulled apart, the first with disks of 1 and 2 m along x, the second at 45
    // degrees. The second has twice the strength, and breaks by half the stiffness later.
    let scene = parse(
        r#"(
        version: 1, title: "two pairs",
        materials: { "m": (bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6,
            cohesion: 1.0e4, tensile_strength: 1.0e3)) },
        specimen: Particles([
            (position: (0.0, 0.0), radius: 1.0), (position: (3.0, 0.0), radius: 2.0),
            (position: (0.0, 9.0), radius: 1.0),
            (position: (1.4142135623730951, 10.414213562373096), radius: 1.0),
        ]),
        bonds: [(a: 0, b: 1), (a: 2, b: 3)],
        stages: [Load(name: "pull", increments: 9, particles: [
            (select: Index([0, 2]), x: Held, y: Held, rotation: Held),
            (select: Index([1]), x: Displacement(1.0e-3), y: Held, rotation: Held),
            (select: Index([3]), x: Displacement(0.3e-3), y: Displacement(0.3e-3), rotation: Held),
        ])],
        measures: [
            (name: "length", of: Cracks(part: Length)), (name: "sheared", of: Cracks(part: Length, mode: Shear)),
            (name: "along", of: Cracks(part: Direction)), (name: "alike", of: Cracks(part: Alignment, mode: Tension)),
            (name: "fragments", of: Fragments(Number)),
        ],
    )"#,
    );
    let mut simulation = Simulation::new(&scene, None);
    let read = |simulation: &Simulation| {
        ["length", "sheared", "along", "alike", "fragments"]
            .map(|name| reading(simulation.world(), name))
    };
    let mut seen = Vec::new();
    while simulation.step() == Step::Increment {
        let now = read(&simulation);
        if seen.last() != Some(&now) {
            seen.push(now);
        }
        // A resumed run goes on from the same sums.
        let state = simulation.state().unwrap();
        let resumed = Simulation::resume(&scene, &state).unwrap();
        assert_eq!(read(&resumed), now);
    }
    assert_eq!(seen.len(), 3, "{seen:?}");
    assert_eq!(seen[0], [Some(0.0), Some(0.0), None, None, Some(2.0)]);
    // A strength of 2 N/m^2 times 1 kPa each; the pair along x is pulled faster.
    let [length, sheared, along, alike, fragments] = seen[1].map(Option::unwrap);
    assert_eq!((length, sheared, fragments), (2.0, 0.0, 3.0));
    assert_within(along, FRAC_PI_2, 1e-12);
    assert_within(alike, 1.0, 1e-12);
    // Across 45 degrees is 135 degrees; the mean of equal lengths at 90 and 135 degrees is 112.5.
    let [length, sheared, along, alike, fragments] = seen[2].map(Option::unwrap);
    assert_eq!((length, sheared, fragments), (4.0, 0.0, 4.0));
    assert_within(along, PI * 112.5 / 180.0, 1e-9);
    assert_within(alike, 0.5_f64.sqrt(), 1e-9);
}

/// A bond that breaks leaves the table of bonds, in which the measure looked for it.
#[test]
fn the_elastic_energy_where_a_bond_breaks_is_that_of_the_bonds_that_hold() {
    let scene = parse(
        r#"(version: 1, title: "breaks", analysis: Dynamic(dt: 1e-6, theta: 0.5),
        materials: {"m": (density: 2500.0, contact: (normal_stiffness: 1e8),
            bond: (normal_stiffness: 1e8, tangential_stiffness: 4e7, cohesion: 1e6, tensile_strength: 1e5))},
        specimen: Particles([
            (position: (0.0, 0.0), radius: 5e-3, velocity: (-1.0, 0.0)),
            (position: (0.01, 0.0), radius: 5e-3, velocity: (1.0, 0.0)),
            (position: (0.0, 0.1), radius: 5e-3, velocity: (-1e-3, 0.0)),
            (position: (0.01, 0.1), radius: 5e-3, velocity: (1e-3, 0.0))]),
        bonds: [(a: 0, b: 1), (a: 2, b: 3)],
        stages: [Load(name: "l", increments: 40)],
        measures: [(name: "ee", of: ElasticEnergy)])"#,
    );
    let mut simulation = Simulation::new(&scene, None);
    let mut bonds: Vec<usize> = Vec::new();
    while let Some(record) = next(&mut simulation) {
        let has_broken = bonds.last() == Some(&1);
        bonds.push(record.bonds);
        if has_broken {
            let stored = reading(simulation.world(), "ee").unwrap();
            let states = states(&mut simulation);
            let stretch = states[3].position.distance(states[2].position) - 0.01;
            assert_relative(stored, 0.5e8 * stretch * stretch, 1e-6);
        }
    }
    assert_eq!((bonds[0], bonds[bonds.len() - 1]), (2, 1), "one bond breaks");
}

/// Two bonded disks fly apart and back: their energy stays, whatever the phase, with theta = 1/2.
#[test]
fn the_elastic_energy_of_an_oscillator_is_that_at_the_end_of_the_increment() {
    let scene = parse(
        r#"(version: 1, title: "oscillator", analysis: Dynamic(dt: 1e-6, theta: 0.5),
        materials: {"m": (density: 2500.0, contact: (normal_stiffness: 1e8, tangential_stiffness: 4e7),
            bond: (normal_stiffness: 1e8, tangential_stiffness: 4e7, rolling_stiffness: 1e3, friction: 0.5,
                rolling_friction: 1.0, cohesion: 1e9, tensile_strength: 1e9))},
        specimen: Particles([
            (position: (0.0, 0.0), radius: 5e-3, velocity: (-1e-3, 2e-3)),
            (position: (0.01, 0.0), radius: 5e-3, velocity: (1e-3, -2e-3), angular_velocity: 0.1)]),
        bonds: [(a: 0, b: 1)],
        stages: [Load(name: "l", increments: 300)],
        measures: [(name: "ke", of: KineticEnergy), (name: "ee", of: ElasticEnergy)])"#,
    );
    let mut simulation = Simulation::new(&scene, None);
    let (mut start, mut most) = (None, 0.0_f64);
    while next(&mut simulation).is_some() {
        let [kinetic, elastic] =
            ["ke", "ee"].map(|name| reading(simulation.world(), name).unwrap());
        let start = *start.get_or_insert(kinetic + elastic);
        assert_within(kinetic + elastic, start, 1e-6 * start);
        most = most.max(elastic / start);
    }
    assert!(most > 0.5, "{most}");
}
