//! `Pour` stages: rate, room, materials and groups of what comes in.

use std::f64::consts::PI;

use crate::common::*;
use bevy_ecs::prelude::With;
use clastic::components::body::{BodyId, BodyPosition, BodyVelocity, Group};
use clastic::components::energy::EnergyLedger;
use clastic::components::increment::ClasticProgress;
use clastic::components::measure::Readings;
use clastic::components::particle::{MaterialIndex, Particle};
use clastic::components::poured::Poured;
use clastic::prelude::*;
use clastic::run::Outcome;
use clastic::scene::format::{FrictionLaw, Scene};
use glam::DVec2;

const LAWS: [FrictionLaw; 2] = [FrictionLaw::Associated, FrictionLaw::COULOMB];
const DT: f64 = 1e-3;

/// A box of 0.2 m with a floor at 0. `pour` are the fields of the stage after its name, `then` the
/// stages that follow.
fn bin(pour: &str, then: &str) -> Scene {
    parse(&format!(
        "(version: 1, title: \"bin\", analysis: Dynamic(dt: {DT:?}), gravity: (0.0, -9.81),
          materials: {{
            \"a\": (density: 1000.0, contact: (friction: 0.4)),
            \"b\": (density: 2000.0, contact: (friction: 0.4)) }},
          specimen: Particles([]),
          walls: [
            (name: \"floor\", start: (-0.1, 0.0), end: (0.1, 0.0), probe: \"floor\", contact: (friction: 0.4)),
            (name: \"left\", start: (-0.1, 1.0), end: (-0.1, 0.0), probe: \"left\"),
            (name: \"right\", start: (0.1, 0.0), end: (0.1, 1.0), probe: \"right\")],
          stages: [Pour(name: \"pour\", {pour}), {then}],
          measures: [(name: \"kg\", of: Poured(Mass)), (name: \"grains\", of: Poured(Number)),
            (name: \"share\", of: Grains(amount: Share))],
          output: (energy: true))"
    ))
}

const SIZES: &str = "sizes: Uniform(radius: (0.006, 0.01)), seed: 7, material: \"a\"";
const ABOVE: &str =
    "through: Segment(start: (-0.09, 0.4), end: (0.09, 0.4)), velocity: (0.0, -1.0)";

/// Places, radii and masses by identity.
fn disks(simulation: &mut Simulation) -> Vec<(u32, DVec2, Particle)> {
    let world = simulation.world_mut();
    let mut query = world.query::<(&BodyId, &BodyPosition, &Particle)>();
    let mut list: Vec<_> = query.iter(world).map(|(id, x, p)| (id.0, x.0, *p)).collect();
    list.sort_unstable_by_key(|(id, ..)| *id);
    list
}

fn mass(disks: &[(u32, DVec2, Particle)]) -> f64 {
    disks.iter().map(|(.., disk)| disk.mass).sum()
}

/// The poured mass is rate times time to within half a grain, by number and by mass, per second and
/// over the stage; no two disks overlap; the floor carries the weight at rest.
#[test]
fn what_comes_is_rate_times_time_and_the_floor_carries_it() {
    let half_grain = 0.5 * 1000.0 * PI * 0.01 * 0.01;
    let rates = [
        ("Number(200.0)", 60.0, None),
        ("NumberOverStage(60)", 60.0, None),
        ("Mass(40.0)", 0.0, Some(12.0)),
        ("MassOverStage(12.0)", 0.0, Some(12.0)),
    ];
    for (law, (rate, number, kilograms)) in
        LAWS.into_iter().flat_map(|law| rates.map(|rate| (law, rate)))
    {
        let pour = format!("increments: 300, {ABOVE}, {SIZES}, rate: {rate}");
        let mut scene = bin(&pour, "Load(name: \"rest\", increments: 700)");
        scene.friction_law = law;
        let mut simulation = Simulation::new(&scene, None);
        for n in 1..=300 {
            let record = next(&mut simulation).unwrap();
            let there = disks(&mut simulation);
            let share = f64::from(n) / 300.0;
            match kilograms {
                None => assert!((there.len() as f64 - number * share).abs() <= 0.5 + 1e-9),
                Some(kg) => assert!((mass(&there) - kg * share).abs() <= half_grain, "{rate}"),
            }
            for (k, (a, x, disk)) in there.iter().enumerate() {
                for (b, y, other) in &there[k + 1..] {
                    let gap = x.distance(*y) - disk.radius - other.radius;
                    assert!(gap > -1e-6, "{rate}: {a} and {b} overlap by {gap:e}");
                }
            }
            let readings = simulation.world().resource::<Readings>();
            assert_relative(readings.0[0].unwrap(), mass(&there), 1e-12);
            assert_eq!(readings.0[1], Some(there.len() as f64));
            assert_eq!(record.time, simulation.world().resource::<ClasticProgress>().time);
        }
        let last = std::iter::from_fn(|| next(&mut simulation)).last().unwrap();
        let there = disks(&mut simulation);
        let weight = 9.81 * mass(&there);
        let carried = probe(&last, "floor").force[1];
        assert_relative(carried, weight, 0.02);
        let pushed: f64 = ["left", "right", "floor"].map(|w| probe(&last, w).force[0]).iter().sum();
        assert_within(pushed, 0.0, 0.02 * weight);
        assert!(there.iter().all(|(_, x, disk)| x.y > 0.99 * disk.radius));
        // The energy that grains bring with them is no error of the ledger.
        let total = simulation.world().resource::<EnergyLedger>().total;
        assert!(total.error().abs() < 1e-6 * total.throughput(), "{rate}: {total:?}");
    }
}

/// A grain that comes alone falls freely with the velocity that it was given: with theta = 1 by
/// g dt^2 n(n + 1)/2 in n increments.
#[test]
fn a_grain_comes_with_its_velocity() {
    let scene = bin(
        "increments: 100, through: Box(min: (-0.02, 0.7), max: (0.02, 0.74)), rate: NumberOverStage(1),
         sizes: Equal(radius: 0.01), seed: 3, material: \"b\", velocity: (0.1, 0.5)",
        "",
    );
    let mut simulation = Simulation::new(&scene, None);
    let mut start = None;
    for n in 1..=100 {
        next(&mut simulation).unwrap();
        let there = disks(&mut simulation);
        // Half of it is due after 50 increments: it comes in the 50th.
        assert_eq!(there.len(), usize::from(n >= 50));
        let Some((id, x, disk)) = there.first() else { continue };
        assert_eq!((*id, disk.mass), (3, Particle::disk(0.01, 2000.0, 1.0).mass));
        let k = f64::from(n - 49);
        let travelled =
            DVec2::new(0.1 * k * DT, 0.5 * k * DT - 0.5 * 9.81 * DT * DT * k * (k + 1.0));
        let from = *start.get_or_insert(*x - travelled);
        assert!((*x - travelled).distance(from) < 1e-12);
        assert!(from.x.abs() <= 0.01 && (0.71..=0.73).contains(&from.y), "{from}");
    }
    let world = simulation.world_mut();
    let velocity = world.query_filtered::<&BodyVelocity, With<Particle>>().single(world).unwrap().0;
    assert_within(velocity.x, 0.1, 1e-12);
    assert_within(velocity.y, 0.5 - 51.0 * 9.81 * DT, 1e-12);
    // It brings m v^2/2, and the work of gravity adds to that. With theta = 1 the scheme takes
    // m (g dt)^2/2 in every increment.
    let (m, vy) = (Particle::disk(0.01, 2000.0, 1.0).mass, 0.5 - 9.81 * DT * 51.0);
    let total = simulation.world().resource::<EnergyLedger>().total;
    assert_relative(total.exchange, 0.5 * m * (0.1 * 0.1 + 0.5 * 0.5), 1e-12);
    assert_relative(total.kinetic, 0.5 * m * (0.1 * 0.1 + vy * vy), 1e-9);
    assert!(total.error().abs() < 1e-9 * total.throughput(), "{total:?}");
}

/// The share was NaN before the first grain came.
#[test]
fn without_grains_a_share_of_them_has_no_value() {
    let pour = "increments: 4, through: Box(min: (-0.02, 0.7), max: (0.02, 0.74)), rate: NumberOverStage(1),
                sizes: Equal(radius: 0.01), seed: 3, material: \"b\"";
    let mut simulation = Simulation::new(&bin(pour, ""), None);
    let shares: Vec<_> = (0..4)
        .map(|_| {
            next(&mut simulation).unwrap();
            simulation.world().resource::<Readings>().0[2]
        })
        .collect();
    assert_eq!((shares[0], shares[3]), (None, Some(1.0)));
}

/// A full bin takes no more, and the stage ends after the time without room.
#[test]
fn a_pour_ends_where_there_is_no_room_left() {
    let scene = bin(
        "increments: 3000, through: Segment(start: (-0.03, 0.12), end: (0.03, 0.12)), rate: Number(2000.0),
         sizes: Equal(radius: 0.02), seed: 3, material: \"a\", stop: [Full(0.3)]",
        "",
    );
    let mut simulation = Simulation::new(&scene, None);
    let mut came = Vec::new();
    while let Some(record) = next(&mut simulation) {
        came.push((record.time, disks(&mut simulation).len()));
    }
    assert_eq!(simulation.run(), Outcome::Completed);
    let (end, number) = *came.last().unwrap();
    let first = came.iter().find(|(_, n)| *n == number).unwrap().0;
    assert!(number > 3 && end < 2.9, "{number} in {end} s");
    // The last one came in the increment that ended at `first`; those after it found no room.
    assert_within(end - first, 0.3, 1.001e-3);
    // The one on top is in the way of the next.
    let there = disks(&mut simulation);
    assert!(there.iter().any(|(_, x, _)| (x.y - 0.12).abs() < 0.04 && x.x.abs() < 0.05));
}

/// Minerals have their shares, and sizes by a sieve curve follow it in every hundred grains.
#[test]
fn grains_have_the_minerals_and_sizes_of_the_stage() {
    let scene = bin(
        "increments: 200, through: Box(min: (-0.1, 0.0), max: (0.1, 1.0)), rate: NumberOverStage(400),
         sizes: Sieve(passing: [(0.002, 0.0), (0.004, 60.0), (0.006, 100.0)]), seed: 5, material: \"a\",
         minerals: { \"b\": 0.3 }, gravity: (0.0, 0.0), group: \"new\"",
        "Remove(name: \"out\", select: Except(Group(\"new\"), Material(\"b\"))),
         Load(name: \"last\", increments: 1)",
    );
    let mut simulation = Simulation::new(&scene, None);
    for _ in 0..200 {
        next(&mut simulation).unwrap();
    }
    let there = disks(&mut simulation);
    assert_eq!(there.len(), 400);
    for hundred in there.chunks(100) {
        let area = |of: &mut dyn Iterator<Item = f64>| of.map(|r| r * r).sum::<f64>();
        let all = area(&mut hundred.iter().map(|(.., d)| d.radius));
        let below = area(&mut hundred.iter().map(|(.., d)| d.radius).filter(|r| *r < 0.002));
        assert_within(below / all, 0.6, 0.01);
    }
    let world = simulation.world_mut();
    let mut query = world.query::<(&MaterialIndex, &Group)>();
    let (dark, all): (Vec<bool>, Vec<bool>) =
        query.iter(world).map(|(m, group)| (m.0 == 1, group.0 == "new")).unzip();
    assert!(all.iter().all(|of| *of));
    // Within three standard deviations of a share of 400 draws.
    let dark = dark.iter().filter(|dark| **dark).count() as f64;
    assert_within(dark / 400.0, 0.3, 3.0 * (0.3 * 0.7 / 400.0_f64).sqrt());
    next(&mut simulation).unwrap();
    assert_eq!(disks(&mut simulation).len() as f64, dark);
    let poured = simulation.world().resource::<Poured>();
    assert_eq!(poured.number, 400);
}

/// The seed decides, and each of several stages of one seed pours its own grains.
#[test]
fn the_seed_decides_what_comes_and_where() {
    let pour = |seed: u32| {
        let text = format!(
            "increments: 100, {ABOVE}, rate: NumberOverStage(20), sizes: Uniform(radius: (0.006, 0.01)),
             seed: {seed}, material: \"a\""
        );
        let then = format!("Pour(name: \"again\", {text})");
        let mut simulation = Simulation::new(&bin(&text, &then), None);
        while next(&mut simulation).is_some() {}
        let there = disks(&mut simulation);
        there.into_iter().map(|(_, x, disk)| (x, disk.radius)).collect::<Vec<_>>()
    };
    let (one, same, other) = (pour(1), pour(1), pour(2));
    assert_eq!(one.len(), 40);
    assert_eq!(one, same);
    assert_ne!(one, other);
    let radii = |of: &[(DVec2, f64)]| of.iter().map(|(_, r)| *r).collect::<Vec<_>>();
    assert_ne!(radii(&one[..20]), radii(&one[20..]));
}

/// No grain comes into a thin wall or beyond a line that lies across the opening.
#[test]
fn grains_keep_clear_of_walls_in_the_opening() {
    let mut scene = bin(
        "increments: 200, through: Segment(start: (-0.1, 0.3), end: (0.1, 0.3)), rate: NumberOverStage(60),
         sizes: Equal(radius: 0.008), seed: 9, material: \"a\"",
        "",
    );
    let mut plate = scene.walls[0].clone();
    plate.name = "plate".to_owned();
    plate.probe = None;
    (plate.start, plate.end) = ((0.0, 0.5), (0.0, 0.1));
    plate.shape = clastic::scene::format::WallShape::Segment;
    scene.walls.push(plate);
    let mut simulation = Simulation::new(&scene, None);
    let mut known = 0;
    while next(&mut simulation).is_some() {
        let there = disks(&mut simulation);
        for (_, x, disk) in &there[known..] {
            assert!(x.x.abs() > disk.radius * (1.0 - 1e-6), "{x}");
        }
        known = there.len();
    }
    assert!(known > 30, "{known}");
}

/// The scene `poured_bin`: rate times time, and the weight on floor and sides at rest.
#[test]
fn the_bin_that_ships_carries_what_was_poured() {
    let mut simulation = Simulation::new(&load("poured_bin"), None);
    let records: Vec<_> = std::iter::from_fn(|| next(&mut simulation)).collect();
    assert_eq!(simulation.run(), Outcome::Completed);
    let last = records.last().unwrap();
    let carried: f64 = ["floor", "left", "right"].map(|w| probe(last, w).force[1]).iter().sum();
    assert_relative(carried, 1.2 * 9.81, 0.01);
    // Stored: the grains that this seed pours.
    let there = disks(&mut simulation);
    assert_eq!(there.len(), 136);
    assert_relative(mass(&there), 1.2010501966374072, 1e-12);
}

/// A stage that ends while grains wait for room says so: 696 of 1000 grains had come, without a word.
#[test]
fn a_pour_that_comes_short_says_so() {
    let scene = bin(
        "increments: 50, through: Segment(start: (-0.03, 0.12), end: (0.03, 0.12)), rate: NumberOverStage(100),
         sizes: Equal(radius: 0.02), seed: 3, material: \"a\"",
        "",
    );
    let mut simulation = Simulation::new(&scene, None);
    assert_eq!(simulation.run(), Outcome::Completed);
    let came = disks(&mut simulation).len();
    let warning =
        simulation.world().resource::<clastic::run::stages::Script>().ends[0].warning().unwrap();
    let expected = format!(
        "stage pour ended while grains waited for room: {came}.0 % of what was due had come"
    );
    assert!(came < 10 && warning.contains(&expected), "{came}: {warning}");
}
