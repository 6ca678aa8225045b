//! Rupture, walls and loads over many increments: which bonds break when, the forces that remain,
//! and the forces of walls.

use std::collections::BTreeSet;
use std::path::Path;

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::bond::RuptureMode;
use clastic::components::contact::BodyTable;
use clastic::components::increment::{Acceptance, RollingLimit, RuptureRules};
use clastic::components::observation::Observation;
use clastic::cone::program::{ConeProgram, ConeSolution};
use clastic::cone::residuals::force_scale;
use clastic::run::{Outcome, Simulation, Step};
use clastic::scene::format::{CompactTarget, Load, Motion, Stage, WallControl};
use clastic::systems::measures::stress::average_stress;
use clastic::systems::solved::Solved;

/// The small disks' normals turn by less than 1e-4 while the middle one moves: the error of an
/// answer for small displacements.
const TURNS: f64 = 1e-5;

fn fork(rules: &str) -> Simulation {
    Simulation::new(&fork_scene(rules, 11, "x: Displacement(0.5e-6)"), None)
}

/// Bonds (in order of creation) that broke in the increment.
fn broken(record: &Observation) -> Vec<u32> {
    record.ruptures.iter().map(|r| r.bond.0).collect()
}

fn pull(record: &Observation) -> f64 {
    probe(record, "pulled").force[0]
}

#[test]
fn one_round_of_ruptures_an_increment() {
    let mut simulation = fork("order: OneRound");
    let records: Vec<_> = std::iter::from_fn(|| next(&mut simulation)).collect();
    let rounds: Vec<_> = records.iter().map(broken).collect();
    for record in &records[..8] {
        // Two springs of the fork in parallel, in series with that to the pulled disk.
        assert_relative(pull(record), 2.0 / 3.0 * 5.0 * record.increment as f64, TURNS);
    }
    assert!(rounds[..8].iter().all(Vec::is_empty), "{rounds:?}");
    assert_eq!(rounds[8..], [vec![1], vec![2], vec![]]);
    assert!(records.iter().all(|r| r.solves == 1));
    // In its last increment a bond stays on its limit: 10 (4.5 - u) = 12 cos 30 + 10 u (1/4 + 1).
    let u = (45.0 - 12.0 * 0.75_f64.sqrt()) / 22.5;
    assert_relative(pull(&records[8]), 10.0 * (4.5 - u), TURNS);
    assert_within(pull(&records[10]), 0.0, 1e-7);
}

#[test]
fn at_the_rolling_limit_a_bond_breaks_or_yields() {
    // Pressed by 10 N, then turned: 0.1 r (P + f_t) of the bond, 0.1 r P of the contact.
    let turned = |rolling| {
        let mut scene = load("tension");
        let Some(Stage::Load(stage)) = scene.stages.pop() else { unreachable!() };
        let press = |name: &str, increments| {
            let mut load = Load { name: name.into(), increments, ..stage.clone() };
            load.particles[1].x = Motion::Free;
            load.particles[1].y = Motion::Free;
            load.particles[1].force = Some((-10.0, 0.0));
            load
        };
        let mut turn = press("turn", 5);
        turn.particles[1].rotation = Motion::Displacement(1e-8);
        scene.stages = vec![Stage::Load(press("press", 1)), Stage::Load(turn)];
        let mut simulation = Simulation::new(&scene, None);
        simulation.world_mut().resource_mut::<RuptureRules>().rolling = rolling;
        let records: Vec<_> = std::iter::from_fn(|| next(&mut simulation)).collect();
        assert_eq!(records.len(), 6);
        records
    };
    let (bond, contact) = (0.1 * 6e-3 * (10.0 + 24.0), 0.1 * 6e-3 * 10.0);
    let moment = |record: &Observation| probe(record, "pulled").force[2];

    let yields = turned(RollingLimit::Yields);
    for record in &yields[1..] {
        assert_relative(moment(record), bond, 1e-6);
        assert_eq!((record.bonds, record.broken), (1, [0, 0, 0]));
    }
    let breaks = turned(RollingLimit::Breaks);
    assert_relative(moment(&breaks[1]), bond, 1e-6);
    assert_eq!(breaks[1].ruptures[0].mode, RuptureMode::Rolling);
    for record in &breaks[2..] {
        assert_relative(moment(record), contact, 1e-6);
        assert_eq!((record.bonds, record.broken), (0, [0, 0, 1]));
    }
}

#[test]
fn a_broken_bond_never_heals() {
    let mut scene = load("tension");
    let Stage::Load(first) = scene.stages[0].clone() else { unreachable!() };
    // To 3.5 um, back to -1.7 um, where the contact is closed, and to 3.5 um again.
    for (name, step) in [("push", -4e-7), ("pull again", 4e-7)] {
        let mut next = Load { name: name.into(), increments: 13, ..first.clone() };
        next.particles[1].x = Motion::Displacement(step);
        scene.stages.push(Stage::Load(next));
    }
    let (records, _) = run(&scene);
    assert_eq!(records.iter().map(|r| r.ruptures.len()).sum::<usize>(), 1);
    let after = records.iter().position(|r| !r.ruptures.is_empty()).unwrap() + 1;
    assert!(records[after..].len() > 20);
    for record in &records[after..] {
        let pulled = probe(record, "pulled");
        assert_within(pulled.force[0], 8e6 * pulled.motion[0].min(0.0), 1e-7);
        assert_eq!((record.bonds, record.broken), (0, [1, 0, 0]));
    }
    assert!(records[after..].iter().any(|r| pull(r) < -13.5), "the contact was never closed");
}

#[test]
fn friction_keeps_what_it_can_hold_of_a_broken_bonds_shear() {
    // 10 N press, the bond shears at 48 N + 0.6 x 10 N = 54 N, in the increment from 13 to 14 um;
    // of these the contact can hold 6 N.
    let scene = parse(
        "(
            version: 1,
            title: \"shear of a bond\",
            rupture: (order: OneRound),
            materials: { \"cemented\": (
                contact: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6, friction: 0.6),
                bond: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6, friction: 0.6,
                    cohesion: 4.0e3, tensile_strength: 2.0e3),
            ) },
            specimen: Particles([
                (position: (0.0, 0.0), radius: 6.0e-3),
                (position: (0.0, 12.0e-3), radius: 6.0e-3, probe: \"upper\"),
            ]),
            bonds: [(a: 0, b: 1)],
            stages: [
                Load(name: \"press\", increments: 1, particles: [
                    (select: All, x: Held, y: Held, rotation: Held),
                    (select: Index([1]), y: Displacement(-1.25e-6))]),
                Load(name: \"shear\", increments: 14, particles: [
                    (select: All, x: Held, y: Held, rotation: Held),
                    (select: Index([1]), x: Displacement(1.0e-6))]),
                Load(name: \"rest\", increments: 1, particles: [(select: All, x: Held, y: Held, rotation: Held)]),
            ],
        )",
    );
    let (records, _) = run(&scene);
    let [.., before, at, rest] = records.as_slice() else { unreachable!() };
    let force = |record: &Observation| probe(record, "upper").force;
    assert_relative(force(before)[0], 4e6 * 13e-6, 1e-3);
    assert_eq!(at.ruptures.len(), 1);
    assert_eq!(at.ruptures[0].mode, RuptureMode::Shear);
    // 14 um of sliding change gap and normal by a percent.
    assert_relative(force(rest)[0], 6.0, 0.01);
    assert_relative(force(rest)[1], -10.0, 0.02);
    assert!(force(rest)[0] <= 0.6 * -force(rest)[1] * (1.0 + 2e-3), "{:?}", force(rest));
}

#[test]
fn a_wall_goes_and_comes() {
    let scene = parse(
        "(
            version: 1,
            title: \"a disk between two plates that are 2 um too close\",
            materials: { \"stone\": (contact: ()) },
            specimen: Particles([(position: (0.0, 4.999e-3), radius: 5.0e-3, probe: \"disk\")]),
            walls: [
                (name: \"bottom\", start: (-0.01, 0.0), end: (0.01, 0.0), probe: \"bottom\",
                    contact: (normal_stiffness: 1.0e7)),
                (name: \"top\", start: (0.01, 9.998e-3), end: (-0.01, 9.998e-3), probe: \"top\",
                    contact: (normal_stiffness: 1.0e7)),
                (name: \"side\", start: (-0.004, 0.01), end: (-0.004, 0.0), probe: \"side\", present: false,
                    contact: (normal_stiffness: 1.0e7)),
            ],
            stages: [
                Load(name: \"both\", increments: 2),
                Load(name: \"one\", increments: 2, remove_walls: [\"top\"]),
                Load(name: \"both again\", increments: 2, add_walls: [\"top\"]),
                Load(name: \"from the side\", increments: 1, add_walls: [\"side\"]),
            ],
        )",
    );
    let (records, _) = run(&scene);
    let there = |record: &Observation, name| record.probes.iter().any(|p| p.name == name);
    for record in &records {
        let (one, side) = (record.stage == "one", record.stage == "from the side");
        assert_eq!((there(record, "top"), there(record, "side")), (!one, side), "{}", record.stage);
        let expected = if one { 0.0 } else { 10.0 };
        assert_within(probe(record, "bottom").force[1], expected, 1e-7);
        if !one {
            assert_within(probe(record, "top").force[1], -expected, 1e-7);
        }
    }
    // The disk rose until the lower plate let go of it, and was pressed down again; the side wall,
    // 1 mm into it, pushes it away until nothing is left of the overlap.
    let disk = |k: usize| probe(&records[k], "disk").motion;
    assert_within(disk(2)[1], 1e-6, 1e-12);
    assert_within(disk(4)[1], 0.0, 1e-12);
    assert_within(disk(6)[0], 1e-3, 1e-9);
    assert_within(probe(&records[6], "side").force[0], 0.0, 1e-6);
}

#[test]
fn walls_carry_their_stress_exactly_and_the_specimen_carries_that_of_the_walls() {
    // Past the peak, with ruptures.
    let mut loaded = load_with_specimen("biaxial_small");
    stage(&mut loaded.scene, "load").increments = 50;
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let (mut size, mut ruptures, mut confined, mut checked) = ([0.121, 0.2147896], 0, 0, 0);
    while let Some(record) = next(&mut simulation) {
        ruptures += record.ruptures.len();
        let n = record.increment;
        if record.stage == "confine" || record.stage == "load" {
            assert_eq!(
                record.motion_steps, 0,
                "increment {n}: moved beyond what this test follows"
            );
            let [axial, lateral] = [record.axial_stress.unwrap(), record.lateral_stress.unwrap()];
            if record.stage == "confine" {
                // Five equal steps from zero: forces of the compaction are gone.
                confined += 1;
                assert_relative(axial, 40e3 * f64::from(confined), 1e-8);
                assert_relative(lateral, 40e3 * f64::from(confined), 1e-8);
            } else {
                assert_relative(lateral, 200e3, 1e-8);
                checked += 1;
            }
            let world = simulation.world();
            let average = average_stress(Solved::of(world), size[0] * size[1], 1.0);
            // The average stress of bodies with out-of-balance forces r is off by the sum of r x
            // over the area. Round-off alone is some 1e-14 of the maximum force.
            let forces = &world.resource::<ConeSolution>().forces;
            let maximum = force_scale(world.resource::<ConeProgram>(), forces);
            let balance = record.residuals.balance.max(1e-14) * maximum;
            let bodies = world.resource::<BodyTable>().ids.len() as f64;
            let accepted = bodies * balance * size[0].max(size[1]) / (size[0] * size[1]);
            assert_within(average[1][1], axial, accepted);
            assert_within(average[0][0], lateral, accepted);
        }
        let at = |name, k: usize| probe(&record, name).motion[k];
        size = [0.121 + at("right", 0) - at("left", 0), 0.2147896 + at("top", 1) - at("bottom", 1)];
    }
    assert_eq!(confined, 5);
    assert!(checked >= 50 && ruptures > 50, "{checked} increments, {ruptures} ruptures");
}

#[test]
fn a_bond_with_little_cohesion_parts_at_the_apex_of_its_shear_limit() {
    // |q| <= 6 N + 0.6 p ends at p = -10 N, before the tensile strength of 24 N.
    for stiffness in [Some(8e6), None] {
        let mut scene = load("tension");
        let material = scene.materials.get_mut("cemented").unwrap();
        (material.contact.normal_stiffness, material.contact.tangential_stiffness) =
            (stiffness, stiffness);
        let bond = material.bond.as_mut().unwrap();
        bond.cohesion = 500.0;
        bond.rolling_friction = 0.0;
        (bond.normal_stiffness, bond.tangential_stiffness) = (stiffness, stiffness);
        let (records, _) = run(&scene);
        let broken: Vec<_> = records.iter().flat_map(|r| &r.ruptures).collect();
        assert_eq!(broken.len(), 1);
        assert_eq!(broken[0].mode, RuptureMode::Shear);
        assert_relative(broken[0].p, -10.0, 1e-6);
        assert_eq!(broken[0].increment, if stiffness.is_some() { 13 } else { 1 });
        assert_within(pull(records.last().unwrap()), 0.0, 1e-7);
    }
}

#[test]
fn a_packing_that_jams_is_not_driven_on_in_ever_smaller_steps() {
    let mut scene = load("uniaxial_small");
    let Stage::Compact(compact) = &mut scene.stages[0] else { unreachable!() };
    compact.target = CompactTarget::Porosity(0.1);
    let mut simulation = Simulation::new(&scene, None);
    let records: Vec<_> = std::iter::from_fn(|| step(&mut simulation)).collect();
    let Outcome::Undecided { message, .. } = simulation.run() else { panic!("it did not jam") };
    assert!(message.contains("jammed"), "{message}");
    assert!(message.contains("at a height of"), "{message}");
    let (last, before) = records.split_last().unwrap();
    assert_eq!(last.status, IncrementStatus::Undecided);
    // Six halvings of a whole increment at most.
    assert!(before.iter().all(|r| r.fraction >= 1.0 / 64.0));
}

#[test]
fn results_do_not_depend_on_the_regularisation() {
    let stresses = |weight: f64| {
        let mut scene = load("uniaxial_small");
        let load = stage(&mut scene, "load");
        load.increments = 68;
        // First no wall moves: the free specimen must carry no force.
        let mut still = load.clone();
        still.name = "still".into();
        still.increments = 1;
        still.walls.insert("top".into(), WallControl::Fixed);
        load.remove_walls.clear();
        scene.stages.insert(2, Stage::Load(still));
        let mut simulation = Simulation::new(&scene, None);
        simulation.world_mut().resource_mut::<Acceptance>().regularisation = weight;
        let (mut stresses, mut maximum, mut bias) = (Vec::new(), 0.0_f64, 0.0_f64);
        while let Some(record) = next(&mut simulation) {
            if record.stage == "still" || record.stage == "load" {
                stresses.push(record.axial_stress.unwrap());
                let [bottom, top] = ["bottom", "top"]
                    .map(|name| record.probes.iter().find(|p| p.name == name).unwrap().force[1]);
                maximum = maximum.max(top.abs());
                bias = bias.max((bottom + top).abs());
            }
        }
        (stresses, bias / maximum)
    };
    // The last list is empty.
    let [usual, weak, strong, none] = [1e-9, 1e-11, 1e-8, 0.0].map(stresses);
    let peak = usual.0.iter().copied().fold(0.0, f64::max);
    assert!(peak > 1e8 && *usual.0.last().unwrap() < peak, "{peak:e} Pa is not the peak");
    assert_within(usual.0[0], 0.0, 1e-8 * peak);
    for (name, (other, bias)) in [("weak", weak), ("strong", strong), ("none", none)] {
        assert_within(other[0], 0.0, 1e-8 * peak);
        let apart = usual.0.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!(
            "{name}: at zero load {:e} Pa (usual {:e}), maximum difference {apart:e} Pa, platens apart by \
             {bias:e} of the maximum force (usual {:e})",
            other[0], usual.0[0], usual.1
        );
        assert!(apart <= 1e-7 * peak, "{name}: {apart:e} Pa");
        assert!(bias.max(usual.1) <= 1e-8, "{name}: {bias:e} and {:e}", usual.1);
    }
}

/// The forces of a rigid specimen at its limit load are not unique. Two solvers find different ones
/// and must break the same bonds, after which no contact carries a load (4.4.2 of the paper).
#[test]
fn rigid_specimen_breaks_the_same_bonds_with_every_solver_and_carries_nothing_then() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/uniaxial_rigid_small.ron");
    let broken = |solver: &str| {
        let loaded = clastic::scene::load(&path, &[format!("solver={solver}")]).unwrap();
        let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
        let mut step = || {
            assert_eq!(simulation.step(), Step::Increment);
            simulation.world().resource::<Observation>().clone()
        };
        let (first, second) = (step(), step());
        let left = second.axial_stress.unwrap() / first.axial_stress.unwrap();
        assert!(left.abs() < 1e-6, "{solver}: {left} of the limit load is left");
        first.ruptures.iter().map(|r| r.bond.0).collect::<BTreeSet<_>>()
    };
    let (own, other) = (broken("Condensed"), broken("Clarabel()"));
    let common = own.intersection(&other).count();
    println!("{} and {} bonds, {common} of them the same", own.len(), other.len());
    assert!(
        20 * common >= 19 * own.len().max(other.len()),
        "{common} of {} and {}",
        own.len(),
        other.len()
    );
}
