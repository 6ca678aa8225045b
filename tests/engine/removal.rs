//! `Remove` stages: what is left stands, falls and keeps its bonds.

use std::f64::consts::PI;

use crate::common::*;
use clastic::components::body::BodyId;
use clastic::components::bond::{Bond, BondState};
use clastic::components::contact::BodyTable;
use clastic::components::contact_history::{ContactHistory, ContactMemory};
use clastic::components::energy::EnergyLedger;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::{FrictionLaw, Load, Remove, Scene, Select, Stage};

const MASS: f64 = 2000.0 * PI * 0.01 * 0.01;

/// Disks stay on the line of their column.
const UPRIGHT: &str = "particles: [(select: All, x: Held, rotation: Held)]";

/// A column of four disks on a floor, each bonded to the next where `cement` is a stage.
fn column(analysis: &str, stages: &str) -> Scene {
    let disks = (0..4).map(|k| {
        let y = 0.02 * f64::from(k) + 0.01;
        format!("(position: (0.0, {y:?}), radius: 0.01, probe: \"{k}\")")
    });
    parse(&format!(
        "(version: 1, title: \"column\", analysis: {analysis}, gravity: (0.0, -9.81),
          materials: {{ \"m\": (density: 2000.0,
            contact: (normal_stiffness: 1e6, tangential_stiffness: 1e6, friction: 0.5),
            bond: (normal_stiffness: 1e6, tangential_stiffness: 1e6, cohesion: 1e6, tensile_strength: 1e6)) }},
          specimen: Particles([{}]),
          walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0), probe: \"floor\",
            contact: (normal_stiffness: 1e6))],
          stages: [{stages}])",
        disks.collect::<Vec<_>>().join(", ")
    ))
}

/// The floor carries what is left, under both laws, and the record of what went is empty.
#[test]
fn the_floor_carries_what_is_left() {
    let stages = format!(
        "Load(name: \"before\", increments: 2, {UPRIGHT}),
         Remove(name: \"top\", select: Probe(\"3\")),
         Load(name: \"after\", increments: 2, {UPRIGHT}),
         Remove(name: \"more\", select: Layer(normal: (0.0, 1.0), from: 0.04, to: 1.0)),
         Load(name: \"last\", increments: 2, {UPRIGHT})"
    );
    for law in [FrictionLaw::Associated, FrictionLaw::COULOMB] {
        let mut scene = column("Static", &stages);
        scene.friction_law = law;
        let (records, outcome) = run(&scene);
        assert_eq!(outcome, Outcome::Completed);
        for (record, count) in records.iter().zip([4.0, 4.0, 3.0, 3.0, 2.0, 2.0]) {
            assert_relative(probe(record, "floor").force[1], count * MASS * 9.81, 1e-7);
            let there = record.probes.iter().filter(|p| p.name != "floor").count();
            assert_eq!(there as f64, count);
        }
    }
}

/// What was supported falls freely. With theta = 1 it falls by g dt^2 n(n + 1)/2 in n increments.
#[test]
fn what_loses_its_support_falls() {
    let stages = format!(
        "Load(name: \"rest\", increments: 40, {UPRIGHT}),
         Remove(name: \"base\", select: Index([0, 1, 2])),
         Load(name: \"fall\", increments: 20, {UPRIGHT})"
    );
    let (records, _) = run(&column("Dynamic(dt: 1e-3)", &stages));
    let at = |k: usize| probe(&records[k], "3").motion[1];
    let (rest, last_step) = (at(39), at(39) - at(38));
    for n in 1..=20_u32 {
        let n_f = f64::from(n);
        // What is left of the settling goes on.
        let expected = rest + n_f * last_step - 9.81e-6 * n_f * (n_f + 1.0) / 2.0;
        assert_within(at(39 + n as usize), expected, 1e-12);
    }
}

/// Bonds go with their particles. They count neither as intact nor as broken.
#[test]
fn bonds_end_with_their_particles() {
    let stages = "Cement(name: \"cement\", length: 1e-6),
        Load(name: \"before\", increments: 1),
        Remove(name: \"middle\", select: Index([1])),
        Load(name: \"after\", increments: 1, particles: [(select: Index([2, 3]), y: Held)])";
    let mut simulation = Simulation::new(&column("Static", stages), None);
    let bonds: Vec<_> = std::iter::from_fn(|| next(&mut simulation)).map(|o| o.bonds).collect();
    assert_eq!(bonds, [3, 1]);
    let world = simulation.world_mut();
    let mut query = world.query::<(&Bond, &BondState)>();
    let left: Vec<_> = query.iter(world).map(|(b, state)| (b.a.0, b.b.0, *state)).collect();
    assert_eq!(left, [(2, 3, BondState::Intact)]);
}

#[test]
fn what_cannot_be_removed_is_refused_when_the_stage_begins() {
    let refused = |stages: &str| {
        let mut simulation = Simulation::new(&column("Static", stages), None);
        while next(&mut simulation).is_some() {}
        match simulation.run() {
            Outcome::Refused { message, .. } => message,
            other => panic!("{other:?}"),
        }
    };
    let rest = "Load(name: \"rest\", increments: 1, rigid: { \"clump\": (select: Index([0, 1])) })";
    let say = |select: &str| refused(&format!("{rest}, Remove(name: \"out\", select: {select})"));
    let empty = say("Circle(centre: (5.0, 0.0), radius: 0.1)");
    assert!(empty.contains("stage `out` cannot begin: select selects no particle"), "{empty}");
    let all = say("All");
    assert!(all.contains("selects every particle"), "{all}");
    let member = say("Index([1, 2])");
    assert!(member.contains("particle 1") && member.contains("rigid group `clump`"), "{member}");
}

/// A disk of weight W on a floor, pressed down with F by another disk or by a wall, which is taken
/// away. The contact that goes takes F^2/2k with it, which is `exchange`. The floor loses
/// ((F + W)^2 - W^2)/2k, of which the lifted weight takes W F/k and the jump to equilibrium F^2/2k.
#[test]
fn energy_that_a_removal_frees_is_motion_and_neither_turning_nor_numerical() {
    let (k, weight) = (1e6, MASS * 9.81);
    let disk = |y: f64| format!("(position: (0.0, {y:?}), radius: 0.01)");
    let push = "walls: { \"lid\": Displacement(0.0, -1e-4) }";
    let by_disk = format!(
        "Load(name: \"press\", increments: 2, particles: [(select: All, x: Held, rotation: Held),
            (select: Index([1]), x: Held, y: Displacement(-1e-4), rotation: Held)]),
         Remove(name: \"out\", select: Index([1])),
         Load(name: \"after\", increments: 1, {UPRIGHT})"
    );
    let by_wall = format!(
        "Load(name: \"press\", increments: 2, {UPRIGHT}, {push}),
         Load(name: \"after\", increments: 1, {UPRIGHT}, remove_walls: [\"lid\"])"
    );
    for (disks, lid, stages) in
        [(vec![disk(0.01), disk(0.03)], 0.05, by_disk), (vec![disk(0.01)], 0.02, by_wall)]
    {
        let scene = parse(&format!(
            "(version: 1, title: \"pair\", gravity: (0.0, -9.81),
              materials: {{ \"m\": (density: 2000.0, contact: (normal_stiffness: {k:?})) }},
              specimen: Particles([{}]),
              walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0), probe: \"floor\",
                  contact: (normal_stiffness: {k:?})),
                (name: \"lid\", start: (1.0, {lid:?}), end: (-1.0, {lid:?}),
                  contact: (normal_stiffness: {k:?}))],
              stages: [{stages}], output: (energy: true))",
            disks.join(", ")
        ));
        let mut simulation = Simulation::new(&scene, None);
        let floor =
            |simulation: &mut Simulation| probe(&next(simulation).unwrap(), "floor").force[1];
        floor(&mut simulation);
        let force = floor(&mut simulation) - weight;
        assert!(force > 50.0, "{force}");
        let pressed = simulation.world().resource::<EnergyLedger>().stored.unwrap();
        let on_floor = (force + weight).powi(2) / (2.0 * k);
        assert_relative(pressed, on_floor + force * force / (2.0 * k), 1e-7);
        assert_relative(floor(&mut simulation), weight, 1e-7);
        let ledger = simulation.world().resource::<EnergyLedger>();
        let (e, left) = (ledger.increment, weight * weight / (2.0 * k));
        assert_relative(ledger.stored.unwrap(), left, 1e-7);
        assert_relative(e.elastic, left - pressed, 1e-7);
        assert_relative(e.exchange, -force * force / (2.0 * k), 1e-7);
        assert_relative(e.gravity, -weight * force / k, 1e-7);
        assert_relative(e.motion, force * force / (2.0 * k), 1e-7);
        let rest = [e.external, e.turning, e.numerical, e.friction, e.dilation, e.error()];
        assert!(rest.iter().all(|x| x.abs() < 1e-7 * e.motion), "{e:?}");
    }
}

/// What particles take with them out of a loaded packing is the elastic energy of their contacts,
/// k o^2/2 of their overlaps o and q^2/2k of their shear forces, and the books balance.
#[test]
fn particles_take_the_energy_of_their_contacts_out_of_a_packing() {
    for law in [FrictionLaw::Associated, FrictionLaw::COULOMB] {
        let mut scene = load("isotropic_compression");
        scene.friction_law = law;
        scene.output.energy = true;
        scene.reference_stage = None;
        scene.stages.truncate(2);
        let Some(Stage::Load(confine)) = scene.stages.last().cloned() else { panic!("a load") };
        let increments = confine.increments;
        let hole = Select::Circle { centre: (0.05, 0.035), radius: 0.014 };
        scene.stages.push(Stage::Remove(Remove {
            name: "hole".into(),
            select: hole,
            open_cell: false,
            keep_tractions: false,
        }));
        let hold =
            Load { name: "hold".into(), increments: 1, walls: Default::default(), ..confine };
        scene.stages.push(Stage::Load(hold));
        let mut simulation = Simulation::new(&scene, None);
        while next(&mut simulation).unwrap().stage != "confine" {}
        for _ in 1..increments {
            next(&mut simulation).unwrap();
        }
        let world = simulation.world();
        let (bodies, rows) =
            (world.resource::<BodyTable>(), world.resource::<BodyTable>().ids.clone());
        let k = 2.0e7;
        let energy = |c: &ContactMemory| {
            let (a, b) = (c.a as usize, c.b as usize);
            let other = bodies.radii.get(b)?;
            let apart = bodies.positions[a].distance(bodies.positions[b]);
            let overlap = (bodies.radii[a] + other - apart).max(0.0);
            Some(0.5 * k * overlap * overlap + 0.5 * c.q * c.q / k)
        };
        let contacts = &world.resource::<ContactHistory>().0;
        let contacts: Vec<_> = contacts.iter().map(|c| (c.a, c.b, energy(c))).collect();
        let before = world.resource::<EnergyLedger>().stored.unwrap();
        next(&mut simulation).unwrap();
        let world = simulation.world_mut();
        let left: Vec<BodyId> = world.query::<&BodyId>().iter(world).copied().collect();
        let gone = |row: u32| !left.contains(&rows[row as usize]);
        let taken = contacts.iter().filter(|(a, b, _)| gone(*a) || gone(*b));
        // The hole touches no wall.
        let taken: f64 = taken.map(|(.., energy)| energy.unwrap()).sum();
        let ledger = world.resource::<EnergyLedger>();
        let e = ledger.increment;
        println!("{law:?}: {e:?}");
        assert!(rows.len() > left.len() && taken > 0.01 * before, "{taken} of {before}");
        assert_relative(e.exchange, -taken, 1e-6);
        assert!(e.error().abs() < 1e-7 * ledger.total.throughput(), "{e:?}");
        // What is free now is motion.
        assert!(e.turning.abs() < 0.1 * e.motion, "{e:?}");
    }
}
