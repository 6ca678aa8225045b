//! Gradual release of the forces of broken bonds (`avalanche: Gradual`) on assemblies of a few
//! disks with exact answers.

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::energy::EnergyLedger;
use clastic::components::release::Release;
use clastic::run::Simulation;

/// Stiffness of every bond, N/m: so high that no normal turns by more than 1e-5.
const STIFFNESS: f64 = 1.0e9;
/// Radius of all disks, m.
const RADIUS: f64 = 3.0e-3;
/// Tensile strength of all bonds, N.
const STRENGTH: f64 = 12.0;
/// Tolerance of the search for an event.
const TOLERANCE: f64 = 1e-7;

fn scene(settings: &str, law: &str, disks: &str, bonds: &str, stages: &str) -> Simulation {
    let text = format!(
        "(
            version: 1,
            title: \"few disks\",
            {settings}
            output: (energy: true),
            materials: {{ \"glue\": (
                contact: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?}, friction: 0.3),
                bond: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?}, {law}),
            ) }},
            specimen: Particles([{disks}]),
            bonds: [{bonds}],
            stages: [{stages}],
        )",
    );
    Simulation::new(&parse(&text), None)
}

/// Unit of the forces in [`fork`], N: A breaks at 0.19 of it.
const UNIT: f64 = STRENGTH / 0.19;

/// Disk 1 is pulled along x by disk 0. X (bond 1) holds it at the ground, and A (bond 2) at disk 2,
/// which B (bond 3) holds at the ground and which a constant load pulls along x. Bonds have the
/// same stiffness k in all directions, and disks move along x alone, so that the angle of a bond
/// decides at which force along x it breaks. With the imposed displacement u at which X breaks and
/// a load of 0.1 k u, these forces along x are, over k u:
///
/// | | before X breaks | strength | after it |
/// |---|---|---|---|
/// | X | 0.42 | 0.42 | |
/// | A | 0.16 | 0.19 | 0.30: R = 1.58 |
/// | B | 0.26 | 0.27 | 0.40: R = 1.48 |
///
/// A is the most overloaded, but B reaches its limit at 1/14 of the way, and A only at 3/14.
fn fork(avalanche: &str, increments: u32) -> Simulation {
    let at = |[x, y]: [f64; 2], cos: f64, sign: [f64; 2]| {
        let sin = (1.0 - cos * cos).sqrt();
        [x + 2.0 * RADIUS * sign[0] * cos, y + 2.0 * RADIUS * sign[1] * sin]
    };
    let (first, second) = ([0.0, 0.0], [-2.0 * RADIUS, 0.0]);
    let places = [
        at(first, 0.25, [1.0, -1.0]),
        first,
        second,
        at(first, 0.19 / 0.42, [-1.0, 1.0]),
        at(second, 0.19 / 0.27, [-1.0, -1.0]),
    ];
    let disk = |(k, [x, y]): (usize, &[f64; 2])| {
        let probe = if k == 0 { ", probe: \"pulled\"" } else { "" };
        format!("(position: ({x:?}, {y:?}), radius: {RADIUS:?}{probe}),")
    };
    let disks: String = places.iter().enumerate().map(disk).collect();
    let load = 0.1 * UNIT;
    let step = 1.2 * UNIT / STIFFNESS / f64::from(increments);
    let stage = |name: &str, increments: u32, x: &str| {
        format!(
            "Load(name: \"{name}\", increments: {increments}, particles: [
                (select: All, y: Held, rotation: Held),
                (select: Index([3, 4]), x: Held),
                (select: Index([2]), force: ({load:?}, 0.0)),
                (select: Index([0]), x: {x}),
            ]),"
        )
    };
    scene(
        &format!(
            "rupture: (order: Events, tolerance: {TOLERANCE:?}, brittleness: 0.0, avalanche: {avalanche}),"
        ),
        "cohesion: 1.0e9, tensile_strength: 2.0e3",
        &disks,
        "(a: 0, b: 1), (a: 1, b: 3), (a: 1, b: 2), (a: 2, b: 4)",
        &(stage("load", 1, "Held")
            + &stage("pull", increments, &format!("Displacement({step:?})"))),
    )
}

#[test]
fn the_first_bond_on_the_way_breaks_and_not_the_most_overloaded() {
    let expected = [
        ("Gradual", vec![vec![1], vec![3], vec![]]),
        ("MostOverloaded", vec![vec![1], vec![2], vec![]]),
        ("Together", vec![vec![1], vec![2, 3], vec![]]),
    ];
    for (avalanche, expected) in expected {
        for increments in [1, 7, 40] {
            let mut simulation = fork(avalanche, increments);
            let mut records = Vec::new();
            let mut kept = Vec::new();
            while let Some(record) = step(&mut simulation) {
                assert_eq!(record.status, IncrementStatus::Solved);
                records.push(record);
                kept.push(simulation.world().resource::<Release>().kept);
            }
            let first = records.iter().position(|r| !r.ruptures.is_empty()).unwrap();
            let reached: f64 = records[1..=first].iter().map(|r| r.fraction).sum();
            assert_relative(1.2 * reached / f64::from(increments), 1.0, 1e-4);
            let avalanche_of = &records[first..first + expected.len()];
            let broken = avalanche_of.iter().map(|r| r.ruptures.iter().map(|r| r.bond.0));
            let broken: Vec<Vec<u32>> = broken.map(Iterator::collect).collect();
            assert_eq!(broken, expected, "{avalanche}, {increments} increments");
            assert!(avalanche_of[1..].iter().all(|r| r.fraction == 0.0));
            let within: Vec<bool> = avalanche_of.iter().map(|r| r.in_avalanche).collect();
            assert_eq!(within, [false, true, false], "{avalanche}");
            assert!(records[first + 3..].iter().all(|r| r.ruptures.is_empty()));
            if avalanche == "Gradual" {
                assert_relative(1.0 - kept[first + 1], 1.0 / 14.0, 2e-3);
                assert_eq!(kept[first + 2], 0.0);
                // Without B the load leans on disk 0.
                let force = probe(&avalanche_of[2], "pulled").force[0];
                assert_relative(force, -0.1 * UNIT, 1e-4);
            }
        }
    }
}

#[test]
fn the_energies_of_a_gradual_release_add_up() {
    let mut simulation = fork("Gradual", 7);
    let unit = UNIT * UNIT / STIFFNESS;
    let mut avalanche = [0.0; 2];
    while let Some(record) = step(&mut simulation) {
        let e = simulation.world().resource::<EnergyLedger>().increment;
        assert_within(e.error(), 0.0, 1e-9 * unit);
        if record.fraction == 0.0 {
            avalanche[0] += e.motion;
            avalanche[1] += e.external;
        }
    }
    let total = simulation.world().resource::<EnergyLedger>().total;
    // The bonds take what they had stored, f^2/2k.
    assert_relative(total.rupture, 0.5 * (0.42_f64.powi(2) + 0.27_f64.powi(2)) * unit, 1e-4);
    // In the first part 1/14 of 0.42 is released while disk 1 moves by 0.02 u. In the second part
    // 13/14 of 0.42 and 0.27 go to zero while the disks move by 0.66 u and 0.93 u.
    let motion = 0.5 * (0.42 + 0.39) * 0.02 + 0.5 * (0.39 * 0.66 + 0.27 * 0.93);
    assert_relative(avalanche[0], motion * unit, 1e-4);
    // The constant load goes from 0.26 u to 1.2 u.
    assert_relative(avalanche[1], 0.1 * 0.94 * unit, 1e-4);
    assert_within(total.turning.abs() + total.numerical.abs(), 0.0, 1e-4 * unit);
}

/// A disk is pressed onto a held one and pulled sideways by a third. The bond to the held disk
/// shears, and its contact keeps the normal force and friction: the cohesion alone is released.
#[test]
fn a_contact_that_stays_keeps_its_part_of_the_force() {
    let (pressed, cohesion, friction) = (100.0, 15.0, 0.3);
    for law in ["Associated", "Coulomb()"] {
        for increments in [1, 6, 25] {
            let pull = 2.0 * (cohesion + friction * pressed) / STIFFNESS;
            let (low, side) = (2.0 * RADIUS, 2.0 * RADIUS);
            let disks = format!(
                "(position: (0.0, 0.0), radius: {RADIUS:?}),
                 (position: (0.0, {low:?}), radius: {RADIUS:?}),
                 (position: ({side:?}, {low:?}), radius: {RADIUS:?}, probe: \"pulled\"),"
            );
            // The bond to the driven disk does not shear: both disks rise alike.
            let stage = |name: &str, increments: u32, x: &str| {
                format!(
                    "Load(name: \"{name}\", increments: {increments}, particles: [
                        (select: All, rotation: Held),
                        (select: Index([0]), x: Held, y: Held),
                        (select: Index([1]), force: (0.0, {:?})),
                        (select: Index([2]), x: {x}),
                    ]),",
                    -pressed
                )
            };
            // The pull shears the lower bond, and the other has the same strength in tension.
            let sheared = 2.5 * pull / f64::from(increments);
            let mut simulation = scene(
                &format!(
                    "friction_law: {law},
                     rupture: (order: Events, tolerance: {TOLERANCE:?}, brittleness: 0.0, avalanche: Gradual),"
                ),
                &format!(
                    "friction: {friction:?}, cohesion: {:?}, tensile_strength: 1.0e9",
                    cohesion / (2.0 * RADIUS)
                ),
                &disks,
                "(a: 0, b: 1), (a: 1, b: 2)",
                &(stage("press", 1, "Held")
                    + &stage("pull", increments, &format!("Displacement({sheared:?})"))),
            );
            let mut motion = [0.0; 2];
            let mut after = None;
            let mut broken = Vec::new();
            while let Some(record) = step(&mut simulation) {
                assert_eq!(record.status, IncrementStatus::Solved);
                broken.extend(record.ruptures.iter().map(|r| r.bond.0));
                let e = simulation.world().resource::<EnergyLedger>().increment;
                assert_within(e.error(), 0.0, 1e-7 * e.throughput());
                if record.fraction == 0.0 {
                    motion = [motion[0] + e.motion, motion[1] + e.friction];
                    after = Some(record);
                }
            }
            assert_eq!(broken, [0], "{law}, {increments}");
            let after = after.unwrap();
            assert_relative(probe(&after, "pulled").force[0], friction * pressed, 1e-4);
            // The disk slides by c A/k.
            let slip = cohesion / STIFFNESS;
            assert_relative(motion[0], 0.5 * cohesion * slip, 1e-3);
            assert_relative(motion[1], friction * pressed * slip, 1e-3);
        }
    }
}

/// Nothing carries the load of a disk whose only bond has broken, whatever part of its force is
/// released.
#[test]
fn a_load_without_support_is_a_collapse() {
    let disks = format!(
        "(position: (0.0, 0.0), radius: {RADIUS:?}),
         (position: (0.0, {:?}), radius: {RADIUS:?}),",
        -2.0 * RADIUS
    );
    let mut simulation = scene(
        &format!("rupture: (order: Events, tolerance: {TOLERANCE:?}, avalanche: Gradual),"),
        "cohesion: 1.0e9, tensile_strength: 2.0e3",
        &disks,
        "(a: 0, b: 1)",
        &format!(
            "Load(name: \"pull\", increments: 3, particles: [
                (select: All, x: Held, rotation: Held),
                (select: Index([0]), y: Held),
                (select: Index([1]), force: (0.0, {:?})),
            ])",
            -2.0 * STRENGTH
        ),
    );
    let records: Vec<_> = std::iter::from_fn(|| step(&mut simulation)).collect();
    let last = records.last().unwrap();
    assert_eq!(last.status, IncrementStatus::Collapsed);
    assert_eq!(records.iter().map(|r| r.ruptures.len()).sum::<usize>(), 1);
    assert!(!simulation.world().resource::<Release>().goes_on());
}
