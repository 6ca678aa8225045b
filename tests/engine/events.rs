//! Rupture from event to event, on assemblies with exact answers: which bonds break and at which
//! loads does not depend on the increment.

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::energy::EnergyLedger;
use clastic::components::increment::RuptureRules;
use clastic::components::observation::Observation;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::Scene;

/// Stiffness of every bond, N/m.
const STIFFNESS: f64 = 1.0e7;
/// Tensile strength, Pa.
const STRENGTH: f64 = 2.0e3;
/// Tolerance of the search for an event.
const TOLERANCE: f64 = 1e-7;

/// Columns of three touching disks. The lowest is held, the uppermost is pulled. The lower bond of
/// a column is the weaker one: its common radius is that of the lowest disk, `radii[i]`.
fn columns(radii: &[f64], pull: f64, increments: u32, avalanche: &str) -> Simulation {
    let mut disks = String::new();
    let mut bonds = String::new();
    let (mut low, mut high) = (Vec::new(), Vec::new());
    for (i, r) in radii.iter().enumerate() {
        let x = 0.1 * i as f64;
        let places = [(0.0, 1.0), (2.1, 1.1), (4.4, 1.2)];
        for (k, (y, times)) in places.into_iter().enumerate() {
            let probe = if k == 2 { format!(", probe: \"{i}\"") } else { String::new() };
            disks += &format!("(position: ({x:?}, {:?}), radius: {:?}{probe}),", y * r, times * r);
        }
        bonds += &format!("(a: {}, b: {}), (a: {1}, b: {}),", 3 * i, 3 * i + 1, 3 * i + 2);
        low.push((3 * i).to_string());
        high.push((3 * i + 2).to_string());
    }
    let step = pull / f64::from(increments);
    let drives = format!(
        "(select: All, x: Held, rotation: Held), (select: Index([{}]), y: Held),
         (select: Index([{}]), y: Displacement({step:?}))",
        low.join(", "),
        high.join(", "),
    );
    glued(&disks, &bonds, increments, &drives, avalanche)
}

/// Disks with bonds that break in tension, one by one, and the drives of their only stage.
fn glued(disks: &str, bonds: &str, increments: u32, drives: &str, avalanche: &str) -> Simulation {
    let text = format!(
        "(
            version: 1,
            title: \"glued disks\",
            rupture: (order: Events, avalanche: {avalanche}),
            output: (energy: true),
            materials: {{ \"glue\": (
                contact: (normal_stiffness: {STIFFNESS:?}),
                bond: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?}, cohesion: 1.0e9, tensile_strength: {STRENGTH:?}),
            ) }},
            specimen: Particles([{disks}]),
            bonds: [{bonds}],
            stages: [Load(name: \"pull\", increments: {increments}, particles: [{drives}])],
        )",
    );
    with_tolerance(&parse(&text))
}

/// A simulation whose search for an event has the tolerance of this test.
fn with_tolerance(scene: &Scene) -> Simulation {
    let mut simulation = Simulation::new(scene, None);
    simulation.world_mut().resource_mut::<RuptureRules>().tolerance = TOLERANCE;
    simulation
}

/// Runs to the end: the observations of all increments.
fn run(simulation: &mut Simulation) -> Vec<Observation> {
    let records: Vec<_> = std::iter::from_fn(|| step(simulation)).collect();
    assert!(records.iter().all(|r| r.status == IncrementStatus::Solved));
    records
}

/// Energy that the bonds that broke had stored, by the ledger, J.
fn taken(simulation: &Simulation) -> f64 {
    simulation.world().resource::<EnergyLedger>().total.rupture
}

/// Work that the pulled disks do, J: between two events forces grow linearly. `moved` is the motion
/// in an increment.
fn work(records: &[Observation], probes: &[&str], moved: impl Fn(&Observation) -> f64) -> f64 {
    let force = |r: &Observation| probes.iter().map(|name| probe(r, name).force[1]).sum::<f64>();
    let mut last = 0.0;
    let mut sum = 0.0;
    for record in records {
        sum += 0.5 * (last + force(record)) * moved(record);
        last = force(record);
    }
    sum
}

/// Lengthening at which the lower bond of a column breaks: two springs in series.
fn breaks_at(radius: f64) -> f64 {
    2.0 * STRENGTH * 2.0 * radius / STIFFNESS
}

/// All rules of an avalanche at all of these increments.
fn each_rule(increments: [u32; 3]) -> impl Iterator<Item = (u32, &'static str)> {
    let rules = ["MostOverloaded", "Dynamic"];
    increments.into_iter().flat_map(move |n| rules.map(|rule| (n, rule)))
}

const NAMES: [&str; 7] = ["0", "1", "2", "3", "4", "5", "6"];
const RADII: [f64; 7] = [3.0e-3, 3.7e-3, 2.9e-3, 4.4e-3, 5.0e-3, 3.1e-3, 4.1e-3];

#[test]
fn parallel_bonds_of_graded_strength_break_one_by_one_at_any_increment() {
    let mut graded = RADII;
    graded.sort_by(f64::total_cmp);
    for (increments, avalanche) in each_rule([1, 7, 64]) {
        let mut simulation = columns(&RADII, 6.0e-6, increments, avalanche);
        let mut lengthening = 0.0;
        let mut broken = 0;
        let records = run(&mut simulation);
        for record in &records {
            let step = 6.0e-6 / f64::from(increments);
            lengthening += record.fraction * step;
            for _ in &record.ruptures {
                let expected = breaks_at(graded[broken]);
                assert_relative(lengthening, expected, 1.1 * TOLERANCE);
                broken += 1;
            }
            assert!(record.ruptures.len() <= 1, "{:?}", record.ruptures);
        }
        assert_eq!(broken, graded.len(), "{increments} increments");
        // f^2 / (2 k) of every lower bond is taken; the upper bond of a column has as much and
        // loses it.
        let stored = |r: &f64| (STRENGTH * 2.0 * r).powi(2) / (2.0 * STIFFNESS);
        let stored: f64 = graded.iter().map(stored).sum();
        assert_relative(taken(&simulation), stored, 1e-6);
        let moved = |r: &Observation| r.fraction * 6.0e-6 / f64::from(increments);
        assert_relative(work(&records, &NAMES, moved), 2.0 * stored, 1e-6);
    }
}

#[test]
fn a_chain_breaks_at_its_weakest_bond_and_loses_its_energy_at_any_increment() {
    // Six disks in a row: bonds have the strength of the smaller disk. The third bond is the
    // weakest.
    let radii = [4.0e-3, 4.4e-3, 3.0e-3, 3.3e-3, 5.0e-3, 4.2e-3];
    let bonds = radii.len() - 1;
    let force = STRENGTH * 2.0 * 3.0e-3;
    let lengthening = force * bonds as f64 / STIFFNESS;
    for (increments, avalanche) in each_rule([1, 5, 32]) {
        let mut simulation = chain(&radii, 2.0 * lengthening, increments, avalanche);
        let records = run(&mut simulation);
        let way = |r: &Observation| r.fraction * 2.0 * lengthening / f64::from(increments);
        let first = records.iter().position(|r| !r.ruptures.is_empty()).unwrap();
        let reached: f64 = records[..=first].iter().map(way).sum();
        assert_relative(reached, lengthening, 1.1 * TOLERANCE);
        assert_relative(probe(&records[first], "pulled").force[1], force, 1.1 * TOLERANCE);
        let broken: Vec<_> = records.iter().flat_map(|r| &r.ruptures).map(|r| r.bond.0).collect();
        // Two bonds have the radius of the smallest disk; the chain has only one of them to lose.
        assert!(broken == [1] || broken == [2], "{broken:?}");
        assert_within(probe(records.last().unwrap(), "pulled").force[1], 0.0, 1e-6 * force);
        assert_relative(taken(&simulation), force.powi(2) / (2.0 * STIFFNESS), 1e-6);
        let work = work(&records, &["pulled"], way);
        assert_relative(work, 0.5 * force * lengthening, 1e-6);
    }
}

fn chain(radii: &[f64], pull: f64, increments: u32, avalanche: &str) -> Simulation {
    let (mut disks, mut bonds) = (String::new(), String::new());
    let mut y = 0.0;
    for (i, r) in radii.iter().enumerate() {
        if i > 0 {
            y += radii[i - 1] + r;
            bonds += &format!("(a: {}, b: {i}),", i - 1);
        }
        let probe = if i + 1 == radii.len() { ", probe: \"pulled\"" } else { "" };
        disks += &format!("(position: (0.0, {y:?}), radius: {r:?}{probe}),");
    }
    let last = radii.len() - 1;
    let step = pull / f64::from(increments);
    let drives = format!(
        "(select: All, x: Held, rotation: Held), (select: Index([0]), y: Held),
         (select: Index([{last}]), y: Displacement({step:?}))"
    );
    glued(&disks, &bonds, increments, &drives, avalanche)
}

/// A disk is pulled from another one that two smaller ones hold under 30 degrees. The bond of the
/// smaller one (12 N) breaks first. At the same place of the pulled disk the other one (14.4 N)
/// then carries more than it can, and breaks in the same avalanche: no row of the record lies
/// between the two.
#[test]
fn an_avalanche_runs_at_constant_load_and_leaves_no_row_of_its_own() {
    for increments in [1, 11, 40] {
        let step = 5.5e-6 / f64::from(increments);
        let scene = fork_scene("order: Events", increments, &format!("x: Displacement({step:?})"));
        let mut simulation = with_tolerance(&scene);
        let records = run(&mut simulation);
        let broken: Vec<_> = records.iter().filter(|r| !r.ruptures.is_empty()).collect();
        assert_eq!(broken.len(), 2, "{increments}");
        // 12 N = k u cos 30, and the middle disk has gone a third of the way.
        let expected = 2.0 / 3.0 * 3.0 * 12.0 / 0.75_f64.sqrt();
        assert_relative(probe(broken[0], "pulled").force[0], expected, 1e-4);
        assert!(!broken[0].in_avalanche && broken[1].in_avalanche);
        assert_eq!((broken[1].fraction, broken[1].increment), (0.0, broken[0].increment + 1));
        let after = &records[broken[1].increment as usize];
        assert!(!after.in_avalanche && after.fraction == 0.0);
        assert_within(probe(after, "pulled").force[0], 0.0, 1e-6);
    }
}

#[test]
fn many_bonds_that_break_together_leave_what_one_by_one_they_would() {
    // Strengths from 1 to 1.25 times the lowest: more than ten bonds reach their limits while the
    // forces change by 5 %.
    let count = 100;
    let radii: Vec<f64> = (0..count).map(|i| 3.0e-3 * (1.0 + 0.25 * i as f64 / 99.0)).collect();
    let (increments, pull) = (40, 1.1 * breaks_at(radii[count - 1]));
    let mut simulation = columns(&radii, pull, increments, "MostOverloaded");
    let records = run(&mut simulation);
    let mut lengthening = 0.0;
    let mut together = 0;
    for record in &records {
        lengthening += record.fraction * pull / f64::from(increments);
        let force: f64 = (0..count).map(|i| probe(record, &i.to_string()).force[1]).sum();
        // A bond breaks within the tolerance below its limit. The increment of fraction 0 is after it.
        let reached = lengthening * if record.fraction == 0.0 { 1.0 + TOLERANCE } else { 1.0 };
        let intact = radii.iter().filter(|r| breaks_at(**r) > reached).count();
        let exact = intact as f64 * STIFFNESS * lengthening / 2.0;
        // Bonds on a limit in the first increment with many ruptures were not expected. As many
        // break early in its next.
        let unexpected = if together < 2 { 20.0 * STRENGTH * 2.0 * 3.75e-3 } else { 0.0 };
        assert_within(force, exact, unexpected + 1e-6 * exact.max(1.0));
        together += usize::from(record.ruptures.len() > 1 || together > 0);
    }
    assert_eq!(records.iter().map(|r| r.ruptures.len()).sum::<usize>(), count);
    let solves: u32 = records.iter().map(|r| r.solves).sum();
    assert!(together > 5 && solves < 80, "{together} increments, {solves} solves");
}

/// Disks of several sizes that a load presses onto held ones and that are moved sideways. Their
/// bonds shear. A rupture releases the cohesion alone, 12 to 52 N where a contact carries 100 N, and
/// at most eight bonds reach their limits while the forces change by 5 %.
fn sheared(brittleness: f64, increments: u32) -> (Vec<f64>, Simulation) {
    let (mut disks, mut bonds, mut low, mut high) = (String::new(), String::new(), vec![], vec![]);
    let radii: Vec<f64> = (0..60).map(|i| 3.0e-3 * (1.0 + f64::from(i) / 18.0)).collect();
    for (i, r) in radii.iter().enumerate() {
        let x = 0.1 * i as f64;
        disks += &format!("(position: ({x:?}, 0.0), radius: {r:?}),");
        disks += &format!("(position: ({x:?}, {:?}), radius: {:?}, probe: \"{i}\"),", 2.0 * r, r);
        bonds += &format!("(a: {}, b: {}),", 2 * i, 2 * i + 1);
        low.push((2 * i).to_string());
        high.push((2 * i + 1).to_string());
    }
    let (low, high) = (low.join(", "), high.join(", "));
    let pressed = format!(
        "(select: All, rotation: Held), (select: Index([{low}]), x: Held, y: Held),
         (select: Index([{high}]), force: (0.0, {:?})",
        -PRESSED
    );
    let step = 5.0e-6 / f64::from(increments);
    let text = format!(
        "(
            version: 1,
            title: \"pressed and sheared\",
            rupture: (order: Events, brittleness: {brittleness:?}),
            materials: {{ \"glue\": (
                contact: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?}, friction: 0.3),
                bond: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?}, friction: 0.3, cohesion: {STRENGTH:?}, tensile_strength: {STRENGTH:?}),
            ) }},
            specimen: Particles([{disks}]),
            bonds: [{bonds}],
            stages: [
                Load(name: \"press\", increments: 1, particles: [{pressed}, x: Held)]),
                Load(name: \"shear\", increments: {increments}, particles: [{pressed}, x: Displacement({step:?}))]),
            ],
        )",
    );
    (radii, Simulation::new(&parse(&text), None))
}

/// Force on every pressed disk, N.
const PRESSED: f64 = 100.0;

#[test]
fn bonds_that_keep_most_of_their_force_break_together() {
    let increments = 40;
    let [together, one_by_one] = [0.5, 0.0].map(|brittleness| {
        let (radii, mut simulation) = sheared(brittleness, increments);
        let records = run(&mut simulation);
        // Cohesion and friction: bonds below 50 N have broken, and some of the next increment.
        let is_broken = |r: &&f64| STRENGTH * 2.0 * **r + 0.3 * PRESSED < 50.0;
        let exact = radii.iter().filter(is_broken).count();
        let broken = records.iter().map(|r| r.ruptures.len()).sum::<usize>();
        assert!((exact..exact + 5).contains(&broken), "{broken} instead of {exact}");
        // Friction remains, the same for all disks; normals have turned by 1e-3.
        let last = records.last().unwrap();
        for i in 0..exact {
            assert_relative(probe(last, &i.to_string()).force[0], 0.3 * PRESSED, 1e-2);
        }
        records.iter().map(|r| r.solves).sum::<u32>()
    });
    let [few, many] = [together, one_by_one].map(|solves| solves - increments);
    assert!(4 * few < many, "{few} and {many} solves more than increments");
}

/// The row of the last increment has the forces of the bonds that hold, and friction alone where
/// one has broken.
#[test]
fn a_stage_that_ends_where_many_bonds_break_goes_on_until_all_hold() {
    let increments = 12;
    let (radii, mut simulation) = sheared(0.5, increments);
    let mut last = None;
    let mut broken = 0;
    let mut together = 0;
    while let Some(record) = step(&mut simulation) {
        assert_eq!(record.status, IncrementStatus::Solved);
        broken += record.ruptures.len();
        together = together.max(record.ruptures.len());
        last = Some(record);
    }
    let last = last.unwrap();
    assert!(together > 1 && last.fraction == 0.0 && last.ruptures.is_empty());
    let mut held = 0;
    for (i, r) in radii.iter().enumerate() {
        let force = probe(&last, &i.to_string()).force[0];
        let strength = STRENGTH * 2.0 * r + 0.3 * PRESSED;
        if i < broken {
            assert_relative(force, 0.3 * PRESSED, 1e-2);
        } else {
            assert!(force < strength, "bond {i} carries {force} N, its strength is {strength} N");
            assert!(force > 0.9 * 50.0, "{force}");
            held += 1;
        }
    }
    assert!(held > 5, "{held}");
}

/// Twenty glued disks under 20 kN that a force shears carry 20 (c A + mu N) = 14 kN. Where their bonds
/// broke together, an increment beyond that was a collapse at once, at 0 to 14 kN.
#[test]
fn the_limit_load_of_bonds_that_break_together_does_not_depend_on_the_increments() {
    for increments in [1, 2, 5, 20] {
        let disks: String = (0..20)
            .map(|i| format!("(position: ({:?}, 0.01), radius: 0.01),", 0.03 * f64::from(i)))
            .collect();
        let stiffness = "normal_stiffness: 1e8, tangential_stiffness: 1e8, friction: 0.5";
        let scene = parse(&format!(
            "(version: 1, title: \"direct shear\",
              materials: {{ \"m\": (contact: ({stiffness}),
                bond: (friction: 0.5, cohesion: 1e4, tensile_strength: 1e4)) }},
              specimen: Particles([{disks}]),
              walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0), contact: ({stiffness}))],
              stages: [Cement(name: \"glue\", length: 1e-4, walls: true, particles: false),
                Load(name: \"press\", increments: 2,
                  rigid: {{ \"box\": (select: All, rotation: Held, force: (0.0, -20000.0)) }}),
                Load(name: \"shear\", increments: {increments},
                  rigid: {{ \"box\": (rotation: Held, force: (28000.0, -20000.0)) }})])"
        ));
        let (records, outcome) = crate::common::run(&scene);
        assert!(matches!(outcome, Outcome::Collapsed(_)), "{outcome:?}");
        let loads =
            records.iter().filter(|r| r.stage == "shear" && r.status == IncrementStatus::Solved);
        let carried = 28_000.0 / f64::from(increments) * loads.map(|r| r.fraction).sum::<f64>();
        // Increments are halved six times.
        let finest = 28_000.0 / f64::from(increments) / 64.0;
        assert!(
            carried <= 14_000.1 && carried >= 14_000.0 - finest - 0.1,
            "{increments}: {carried} N"
        );
    }
}
