//! Rigid groups against closed forms: free flight, rest, sliding, tipping, floating halves, pivots.

use std::f64::consts::PI;

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::energy::EnergyLedger;
use clastic::components::observation::Observation;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::{FrictionLaw, Scene};
use glam::DVec2;

const G: f64 = 9.81;
const DENSITY: f64 = 1000.0;
const R: f64 = 0.01;

/// Mass of a disk of radius R.
fn mass() -> f64 {
    DENSITY * PI * R * R
}

/// A scene of disks at these places, with these walls and stages.
fn scene(places: &[(f64, f64)], head: &str, contact: &str, walls: &str, stages: &str) -> Scene {
    let disk = |(x, y): &(f64, f64)| format!("(position: ({x:?}, {y:?}), radius: {R:?})");
    let disks: Vec<_> = places.iter().map(disk).collect();
    let disks = disks.join(", ");
    parse(&format!(
        "(version: 1, title: \"group\", {head} output: (energy: true),
          materials: {{ \"m\": (density: {DENSITY:?}, contact: ({contact})) }},
          specimen: Particles([{disks}]), walls: [{walls}], stages: [{stages}])"
    ))
}

fn records(simulation: &mut Simulation) -> Vec<Observation> {
    std::iter::from_fn(|| next(simulation)).collect()
}

/// Error of the energy ledger over its throughput.
fn energy_error(simulation: &Simulation) -> f64 {
    let total = simulation.world().resource::<EnergyLedger>().total;
    total.error().abs() / total.throughput().max(f64::MIN_POSITIVE)
}

/// Linear momentum, and angular momentum about a point.
fn momenta(simulation: &mut Simulation, about: DVec2) -> (DVec2, f64) {
    let (mut linear, mut angular) = (DVec2::ZERO, 0.0);
    for s in states(simulation) {
        linear += s.mass * s.velocity;
        angular += s.mass * (s.position - about).perp_dot(s.velocity) + s.inertia * s.spin;
    }
    (linear, angular)
}

/// A dumbbell of unequal disks that touch nothing falls as its centre of mass does, turns at a
/// constant rate, and keeps its angular momentum and its shape.
#[test]
fn a_dumbbell_falls_and_turns_freely() {
    for (theta, head) in [(0.5, ""), (1.0, ""), (0.5, "friction_law: Coulomb(),")] {
        let mut rig = scene(
            &[(0.0, 0.0), (0.05, 0.0), (0.05, 0.02)],
            &format!(
                "gravity: (0.0, -9.81), analysis: Dynamic(dt: 2.0e-3, theta: {theta:?}), {head}"
            ),
            "friction: 0.5",
            "",
            "Load(name: \"fall\", increments: 500,
                rigid: { \"body\": (select: Index([0, 1, 2])) })",
        );
        let clastic::scene::format::Specimen::Particles(list) = &mut rig.specimen else { panic!() };
        list[0].velocity = (0.3, 1.0);
        list[1].angular_velocity = 40.0;
        let mut simulation = Simulation::new(&rig, None);
        let before = states(&mut simulation);
        let total = 3.0 * mass();
        let middle = before.iter().map(|s| s.position).sum::<DVec2>() / 3.0;
        let (linear, angular) = momenta(&mut simulation, middle);
        let inertia: f64 = before
            .iter()
            .map(|s| s.inertia + s.mass * (s.position - middle).length_squared())
            .sum();
        let (v, spin) = (linear / total, angular / inertia);
        let steps = records(&mut simulation).len();
        assert_eq!(steps, 500);
        let after = states(&mut simulation);
        let t = 1.0;
        // The theta-method falls theta - 1/2 increments ahead of the parabola.
        let fall = 0.5 * G * t * t + (theta - 0.5) * 2e-3 * G * t;
        let expected = middle + v * t - DVec2::new(0.0, fall);
        let place = after.iter().map(|s| s.position).sum::<DVec2>() / 3.0;
        assert!(place.distance(expected) < 1e-12, "{place} {expected}");
        let (_, now) = momenta(&mut simulation, place);
        assert_relative(now, angular, 1e-12);
        for (a, b) in before.iter().zip(&after) {
            assert_relative(b.spin, spin, 1e-12);
            assert_within(b.rotation, spin * t, 1e-11);
            let turned = DVec2::from_angle(spin * t).rotate(a.position - middle);
            assert!((b.position - place).distance(turned) < 1e-12);
        }
        assert!(energy_error(&simulation) < 1e-10, "{theta}: {:e}", energy_error(&simulation));
    }
}

const FLOOR: &str =
    "(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0), contact: (CONTACT), probe: \"floor\")";

/// A clump of two disks on the floor and one above them, pushed at its centre of mass by a force
/// that grows from 0 to `most` times its weight. Returns the records and the outcome.
fn pushed(contact: &str, law: FrictionLaw, most: f64) -> (Vec<Observation>, Outcome) {
    let height = 3.0_f64.sqrt() * R;
    let weight = 3.0 * mass() * G;
    let mut rig = scene(
        &[(-R, R), (R, R), (0.0, R + height)],
        "gravity: (0.0, -9.81),",
        contact,
        &FLOOR.replace("CONTACT", contact),
        &format!(
            "Load(name: \"rest\", increments: 1, rigid: {{ \"clump\": (select: All) }}),
             Load(name: \"push\", increments: 200,
                rigid: {{ \"clump\": (force: ({:?}, 0.0)) }})",
            most * weight
        ),
    );
    rig.friction_law = law;
    run(&rig)
}

/// The last force, over the weight, under which the clump was at rest.
fn carried(records: &[Observation], most: f64) -> f64 {
    let solved = records.iter().filter(|r| r.status == IncrementStatus::Solved).count();
    most * (solved as f64 - 1.0) / 200.0
}

const RIGID: &str = "friction: FRICTION";
const SOFT: &str = "normal_stiffness: 1.0e7, tangential_stiffness: 1.0e7, friction: FRICTION";
const LAWS: [FrictionLaw; 2] = [FrictionLaw::Associated, FrictionLaw::COULOMB];

/// The clump tips about the outer disk where the push has the moment of the weight about it: at the
/// base over the height of the centre of mass.
#[test]
fn a_clump_tips_at_the_geometric_angle() {
    let base = R;
    let height = R + 3.0_f64.sqrt() * R / 3.0;
    let geometric = base / height;
    for contact in [RIGID, SOFT] {
        for law in LAWS {
            let (records, outcome) = pushed(&contact.replace("FRICTION", "0.9"), law, 1.0);
            assert!(matches!(outcome, Outcome::Collapsed(_)), "{outcome:?}");
            let last = carried(&records, 1.0);
            assert!((0.0..=0.005).contains(&(geometric - last)), "{last} {geometric}");
        }
    }
}

/// With less friction it slides at mu.
#[test]
fn a_clump_slides_at_its_coefficient_of_friction() {
    for contact in [RIGID, SOFT] {
        for law in LAWS {
            let (records, outcome) = pushed(&contact.replace("FRICTION", "0.317"), law, 0.5);
            assert!(matches!(outcome, Outcome::Collapsed(_)), "{outcome:?}");
            let last = carried(&records, 0.5);
            assert!((0.0..=0.0025).contains(&(0.317 - last)), "{last}");
            // The history has the sum of the contact forces on the group, and their moment about
            // its centre: they balance weight and push.
            let solved = records.iter().rev().find(|r| r.status == IncrementStatus::Solved);
            let reading = probe(solved.unwrap(), "clump");
            let weight = 3.0 * mass() * G;
            assert_relative(reading.force[0], -last * weight, 1e-6);
            assert_relative(reading.force[1], weight, 1e-6);
            assert_within(reading.force[2], 0.0, 1e-7 * weight * R);
        }
    }
}

/// The floating upper half of a shear box on a planar interface: a row of disks that is driven
/// along the floor under a normal stress. tau/sigma is tan phi, whatever the stress; the half
/// neither sinks nor turns under Coulomb's law.
#[test]
fn a_floating_half_of_a_shear_box_slides_at_the_angle_of_friction() {
    let places: Vec<(f64, f64)> = (0..10).map(|i| (2.0 * R * f64::from(i), R)).collect();
    for contact in [RIGID, SOFT] {
        let contact = contact.replace("FRICTION", "0.45");
        for (law, rotation) in [
            (FrictionLaw::Associated, "Held"),
            (FrictionLaw::COULOMB, "Held"),
            (FrictionLaw::COULOMB, "Free"),
        ] {
            for stress in [1e4, 1e5] {
                let mut rig = scene(
                    &places,
                    "",
                    &contact,
                    &FLOOR.replace("CONTACT", &contact),
                    &format!(
                        "Load(name: \"press\", increments: 4, rigid: {{ \"half\": (select: All,
                            x: Held, rotation: {rotation},
                            stress: (value: (0.0, {:?}), length: 0.2)) }}),
                         Load(name: \"shear\", increments: 10, rigid: {{ \"half\": (
                            x: Displacement(1.0e-3), rotation: {rotation}) }})",
                        -stress
                    ),
                );
                rig.friction_law = law;
                let mut simulation = Simulation::new(&rig, None);
                let records = records(&mut simulation);
                assert_eq!(records.len(), 14);
                let last = records.last().unwrap();
                let half = probe(last, "half");
                assert_relative(half.force[1], stress * 0.2, 1e-6);
                assert_relative(-half.force[0] / half.force[1], 0.45, 1e-6);
                assert_relative(half.motion[0], 10e-3, 1e-9);
                assert!(energy_error(&simulation) < 1e-6, "{:e}", energy_error(&simulation));
                if law == FrictionLaw::COULOMB && contact == RIGID {
                    assert_within(half.motion[1], 0.0, 1e-8);
                }
            }
        }
    }
}

/// A drum of grains that spins about a pivot: the grains stay on circles, the moment at the pivot
/// is that of the friction of a shoe on it.
#[test]
fn a_group_turns_about_its_pivot_by_finite_angles() {
    let pivot = DVec2::new(0.3, -0.1);
    let places: Vec<(f64, f64)> = (0..12)
        .map(|k| {
            let x = pivot + 0.08 * DVec2::from_angle(PI / 6.0 * f64::from(k));
            (x.x, x.y)
        })
        .collect();
    for (analysis, drive) in
        [("Static", "Displacement(0.35)"), ("Dynamic(dt: 0.1, theta: 1.0)", "Velocity(3.5)")]
    {
        let rig = scene(
            &places,
            &format!("analysis: {analysis}, gravity: (0.0, -9.81),"),
            "friction: 0.5",
            "",
            &format!(
                "Load(name: \"spin\", increments: 40, rigid: {{ \"drum\": (select: All,
                    about: (0.3, -0.1), x: Held, y: Held, rotation: {drive}) }})"
            ),
        );
        let mut simulation = Simulation::new(&rig, None);
        let before = states(&mut simulation);
        let records = records(&mut simulation);
        let angle = 14.0;
        assert_relative(probe(records.last().unwrap(), "drum").motion[2], angle, 1e-12);
        for (a, b) in before.iter().zip(states(&mut simulation)) {
            let turned = pivot + DVec2::from_angle(angle).rotate(a.position - pivot);
            assert!(b.position.distance(turned) < 1e-12, "{}", b.position.distance(turned));
            assert_relative(b.rotation, angle, 1e-12);
        }
        assert!(energy_error(&simulation) < 1e-9, "{analysis} {:e}", energy_error(&simulation));
    }
}

/// A compound pendulum on a pivot: its period at small angles is 2 pi sqrt(J/(m g l)).
#[test]
fn a_group_on_a_pivot_swings_as_a_compound_pendulum() {
    let angle: f64 = 0.02;
    let at = |l: f64| (l * angle.sin(), -l * angle.cos());
    let rig = scene(
        &[at(0.1), at(0.2)],
        "gravity: (0.0, -9.81), analysis: Dynamic(dt: 1.0e-3, theta: 0.5),",
        "friction: 0.5",
        "",
        "Load(name: \"swing\", increments: 2000, rigid: { \"rod\": (select: All,
            about: (0.0, 0.0), x: Held, y: Held) })",
    );
    let mut simulation = Simulation::new(&rig, None);
    let records = records(&mut simulation);
    let inertia: f64 = [0.1, 0.2].iter().map(|l| mass() * (l * l + 0.5 * R * R)).sum();
    let period = 2.0 * PI * (inertia / (mass() * G * 0.3)).sqrt() * (1.0 + angle * angle / 16.0);
    // The rotation is cosine-shaped: times at which it passes its middle.
    let turn = |r: &Observation| probe(r, "rod").motion[2] + angle;
    let zeros: Vec<f64> = records
        .windows(2)
        .filter(|w| turn(&w[0]) * turn(&w[1]) < 0.0)
        .map(|w| w[0].time + 1e-3 * turn(&w[0]) / (turn(&w[0]) - turn(&w[1])))
        .collect();
    let measured = 2.0 * (zeros.last().unwrap() - zeros[0]) / (zeros.len() as f64 - 1.0);
    assert_relative(measured, period, 1e-4);
    let error = simulation.world().resource::<EnergyLedger>().total;
    assert!(error.error().abs() < 1e-3 * error.throughput(), "{error:?}");
}

/// A pendulum with an amplitude of one radian keeps its energy over 10 s at 200 steps a period, and
/// gains none at 20.
#[test]
fn a_group_on_a_pivot_keeps_its_energy_with_theta_one_half() {
    let l: f64 = 0.5;
    let start = (l * 1.0_f64.sin(), -l * 1.0_f64.cos());
    let inertia = mass() * (l * l + 0.5 * R * R);
    let period = 2.0 * PI * (inertia / (mass() * G * l)).sqrt();
    for (steps, allowed) in [(200.0, 1e-6), (20.0, 1e-2)] {
        let dt = period / steps;
        let count = (10.0 / dt) as u32;
        let rig = scene(
            &[start],
            &format!("gravity: (0.0, -9.81), analysis: Dynamic(dt: {dt}, theta: 0.5),"),
            "friction: 0.5",
            "",
            &format!(
                "Load(name: \"swing\", increments: {count}, rigid: {{ \"bob\": (select: All,
                    about: (0.0, 0.0), x: Held, y: Held) }})"
            ),
        );
        let mut simulation = Simulation::new(&rig, None);
        let scale = mass() * G * l * (1.0 - 1.0_f64.cos());
        let (mut worst, mut gained) = (0.0_f64, 0.0_f64);
        while next(&mut simulation).is_some() {
            let bob = states(&mut simulation)[0];
            let kinetic = 0.5 * inertia * bob.spin * bob.spin;
            let energy = kinetic + mass() * G * (bob.position.y - start.1);
            worst = worst.max(energy.abs() / scale);
            gained = gained.max(energy / scale);
        }
        assert!(worst < allowed && gained < 1e-6, "{steps} steps a period: {worst:e}, {gained:e}");
        let ledger = simulation.world().resource::<EnergyLedger>().total;
        assert!(ledger.error().abs() < 1e-9 * ledger.throughput(), "{ledger:?}");
    }
}

/// A gate on a hinge under a moment leans on a disk: the force is the moment over the arm.
#[test]
fn a_moment_on_a_hinged_group_presses_at_its_arm() {
    for contact in ["", "normal_stiffness: 1.0e7"] {
        let rig = scene(
            // The gate on its hinge at (0, 0), and a disk between its tip and a wall.
            &[(0.0, 0.1), (0.0, 0.2), (0.0, 0.3), (0.02, 0.3)],
            "",
            contact,
            &format!(
                "(name: \"stop\", start: (0.03, 1.0), end: (0.03, -1.0), contact: ({contact}),
                    probe: \"stop\")"
            )
            .replace(
                "start: (0.03, 1.0), end: (0.03, -1.0)",
                "start: (0.03, -1.0), end: (0.03, 1.0)",
            ),
            "Load(name: \"press\", increments: 5,
                rigid: { \"gate\": (select: Index([0, 1, 2]), about: (0.0, 0.0), x: Held, y: Held,
                    moment: -6.0) },
                particles: [(select: Index([3]), y: Held, rotation: Held)])",
        );
        let mut simulation = Simulation::new(&rig, None);
        let records = records(&mut simulation);
        let last = records.last().unwrap();
        // The contact turns with the gate, by little.
        assert_relative(probe(last, "stop").force[0].abs(), 20.0, 1e-3);
        assert_relative(probe(last, "gate").force[2], 6.0, 1e-6);
    }
}

/// Two clumps that collide keep momentum and angular momentum; with theta = 1 energy is lost, never
/// gained.
#[test]
fn clumps_that_collide_keep_their_momenta() {
    for contact in ["friction: 0.4", "restitution: 0.6, friction: 0.4"] {
        let mut rig = scene(
            &[(0.0, 0.0), (0.02, 0.0), (0.06, 0.005), (0.06, 0.025)],
            "analysis: Dynamic(dt: 1.0e-4, theta: 1.0),",
            contact,
            "",
            "Load(name: \"hit\", increments: 400, rigid: {
                \"a\": (select: Index([0, 1])), \"b\": (select: Index([2, 3])) })",
        );
        let clastic::scene::format::Specimen::Particles(list) = &mut rig.specimen else { panic!() };
        for i in [0, 1] {
            list[i].velocity = (1.0, 0.0);
        }
        let mut simulation = Simulation::new(&rig, None);
        let (linear, angular) = momenta(&mut simulation, DVec2::ZERO);
        let kinetic = |simulation: &mut Simulation| -> f64 {
            let energy =
                |s: &State| s.mass * s.velocity.length_squared() + s.inertia * s.spin * s.spin;
            0.5 * states(simulation).iter().map(energy).sum::<f64>()
        };
        let start = kinetic(&mut simulation);
        records(&mut simulation);
        let (p, l) = momenta(&mut simulation, DVec2::ZERO);
        assert!(p.distance(linear) < 1e-10 * linear.length(), "{p} {linear}");
        // The normal is that of the start of the increment.
        assert_within(l, angular, 1e-3 * linear.length() * 0.06);
        let end = kinetic(&mut simulation);
        assert!(end < start && states(&mut simulation)[2].velocity.x > 0.1, "{start} {end}");
        assert!(energy_error(&simulation) < 1e-9, "{:e}", energy_error(&simulation));
    }
}

/// The ledger closes when the imposed velocities of groups change under their weight, free along
/// other degrees of freedom, for any theta.
#[test]
fn the_ledger_closes_where_groups_are_driven() {
    for theta in [0.5, 0.6, 1.0] {
        let contact = "normal_stiffness: 1.0e5, tangential_stiffness: 1.0e5, friction: 0.3";
        let rig = scene(
            &[(-R, R), (R, R), (0.0, 2.9 * R), (0.07, R), (0.09, 1.2 * R)],
            &format!("gravity: (1.0, -9.81), analysis: Dynamic(dt: 1.0e-3, theta: {theta:?}),"),
            contact,
            &FLOOR.replace("CONTACT", contact),
            "Load(name: \"a\", increments: 20, rigid: {
                \"left\": (select: Index([0, 1, 2]), x: Displacement(1.0e-4), moment: 0.01),
                \"right\": (select: Index([3, 4]), rotation: Displacement(-2.0e-3),
                    force: (-2.0, 3.0)) },
                particles: [(select: Index([2, 3]), force: (1.0, -2.0), moment: 0.02)]),
             Load(name: \"b\", increments: 20, rigid: {
                \"left\": (y: Displacement(0.5e-4), rotation: Displacement(1.0e-3)) })",
        );
        let mut simulation = Simulation::new(&rig, None);
        assert_eq!(records(&mut simulation).len(), 40);
        assert!(energy_error(&simulation) < 1e-6, "{theta} {:e}", energy_error(&simulation));
    }
}

/// Released members move on their own, and a group that is made again holds them where they are.
#[test]
fn groups_end_and_are_made_again() {
    let rig = scene(
        &[(-R, R), (R, R), (0.0, R + 3.0_f64.sqrt() * R)],
        "gravity: (0.0, -9.81), analysis: Dynamic(dt: 1.0e-3, theta: 1.0),",
        "",
        &FLOOR.replace("CONTACT", ""),
        "Load(name: \"together\", increments: 20, rigid: { \"clump\": (select: All) }),
         Load(name: \"apart\", increments: 50, release: [\"clump\"]),
         Load(name: \"again\", increments: 5, rigid: { \"clump\": (select: All, x: Held, y: Held,
            rotation: Held) })",
    );
    let mut simulation = Simulation::new(&rig, None);
    let mut heights = Vec::new();
    while let Some(record) = next(&mut simulation) {
        heights.push((record.stage, states(&mut simulation)[2].position.y));
    }
    let at = |k: usize| heights[k].1;
    assert_within(at(19), R + 3.0_f64.sqrt() * R, 1e-9);
    // Without friction the upper disk pushes the others apart.
    assert!(at(69) < at(19) - 0.1 * R, "{} {}", at(19), at(69));
    assert_within(at(74), at(69), 1e-12);
}

/// A group presses at the place to which it turns: the overlap with a held disk is that of the finite
/// rotation.
#[test]
fn a_group_presses_at_the_place_it_turns_to() {
    let rig = scene(
        &[(0.1, 0.0), (0.1, 0.021)],
        "",
        "normal_stiffness: 1.0e6",
        "",
        "Load(name: \"turn\", increments: 1,
            rigid: { \"arm\": (select: Index([0]), about: (0.0, 0.0), x: Held, y: Held,
                rotation: Displacement(0.012)) },
            particles: [(select: Index([1]), x: Held, y: Held, rotation: Held)])",
    );
    let (records, _) = run(&rig);
    let exact = probe(&records[0], "arm").force;
    let tip = 0.1 * DVec2::from_angle(0.012);
    let overlap = 2.0 * R - tip.distance(DVec2::new(0.1, 0.021));
    assert_relative(exact[0].hypot(exact[1]), 1e6 * overlap, 1e-6);
    // Forces act along the line of centres, whose moment about the pivot has the arm of that line.
    let normal = (DVec2::new(0.1, 0.021) - tip).normalize();
    assert_relative(exact[2], 1e6 * overlap * -(DVec2::new(0.1, 0.0)).perp_dot(normal), 1e-4);
}

/// A lattice under a rigid cap that is pressed and then let go: increments are halved, or the
/// motion is followed, with a group in the specimen, and it comes to rest in balance.
#[test]
fn motions_are_followed_with_a_group_in_the_specimen() {
    let elastic = "normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.3";
    for law in LAWS {
        let mut rig = parse(&format!(
            "(version: 1, title: \"cap\", gravity: (0.0, -9.81), output: (energy: true),
              acceptance: (turn: 0.01),
              materials: {{ \"m\": (density: 2000.0, contact: ({elastic})) }},
              specimen: Packing(count: 60, columns: 6, spacing: 10.0e-3, origin: (1.0e-3, 0.0),
                sizes: Uniform(radius: (3.0e-3, 5.0e-3)), seed: 3),
              walls: [
                (name: \"bottom\", start: (0.0, 0.0), end: (0.062, 0.0), contact: ({elastic})),
                (name: \"top\", start: (0.062, 0.1), end: (0.0, 0.1)),
                (name: \"left\", start: (0.0, 0.1), end: (0.0, 0.0), contact: ({elastic})),
                (name: \"right\", start: (0.062, 0.0), end: (0.062, 0.1), contact: ({elastic})),
              ],
              stages: [
                Compact(name: \"compact\", wall: \"top\", base: \"bottom\", target: Porosity(0.25),
                    step: 4.0e-3, agitation: 0.1, seed: 1),
                Load(name: \"press\", increments: 4, remove_walls: [\"top\"], rigid: {{ \"cap\": (
                    select: Box(min: (0.0, 0.05), max: (0.062, 0.2)),
                    stress: (value: (0.0, -2.0e3), length: 0.062)) }}),
                Load(name: \"shear\", increments: 12, rigid: {{ \"cap\": (
                    x: Displacement(0.1e-3), rotation: Displacement(1.0e-3),
                    stress: (value: (0.0, -2.0e3), length: 0.062)) }}),
              ])"
        ));
        rig.friction_law = law;
        if law == FrictionLaw::COULOMB {
            // While all of it slides a static specimen has no solution of this law near by.
            rig.stages.pop();
        }
        let mut simulation = Simulation::new(&rig, None);
        let mut records = Vec::new();
        while let Some(record) = step(&mut simulation) {
            let done = matches!(record.status, IncrementStatus::Solved | IncrementStatus::Capped);
            assert!(done, "{:?} {} {:?}", law, record.increment, record.status);
            records.push(record);
        }
        assert!(records.iter().any(|r| r.motion_steps > 0), "no motion was followed");
        let is_halved = records.iter().any(|r| r.fraction < 1.0);
        assert!(is_halved || law == FrictionLaw::COULOMB, "nothing was halved");
        // The contacts carry the cap: its own weight and the stress.
        let last = records.last().unwrap();
        let cap = probe(last, "cap");
        let members = states(&mut simulation);
        let weight: f64 = {
            let world = simulation.world_mut();
            let mut query = world.query::<&clastic::components::rigid_group::RigidGroup>();
            let group = query.iter(world).next().unwrap();
            group.members.iter().map(|id| members[id.0 as usize].mass * G).sum()
        };
        assert_relative(cap.force[1], weight + 2e3 * 0.062, 1e-5);
        assert!(energy_error(&simulation) < 1e-5, "{law:?} {:e}", energy_error(&simulation));
    }
}

/// In a drum that turns the moment on the axis is on average that of the weight of the grains, and
/// the drum carries their weight, to within the change of their momenta.
#[test]
fn a_drum_carries_the_moment_of_its_grains() {
    let mut simulation = Simulation::new(&load("rotating_drum_small"), None);
    let (mut on_drum, mut of_weight, mut force, mut weight, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
    while let Some(record) = step(&mut simulation) {
        assert_eq!(record.status, IncrementStatus::Solved, "{}", record.increment);
        if record.increment <= 800 {
            continue;
        }
        let reading = probe(&record, "drum");
        on_drum += reading.force[2];
        force += reading.force[1];
        let states = states(&mut simulation);
        for grain in &states[80..] {
            of_weight -= grain.mass * G * grain.position.x;
            weight += grain.mass * G;
        }
        count += 1.0;
    }
    let [on_drum, of_weight, force, weight] =
        [on_drum, of_weight, force, weight].map(|sum| sum / count);
    println!("moment {on_drum} N m of {of_weight} N m, force {force} N of {weight} N");
    assert!(count > 500.0 && of_weight < -1.0);
    assert_relative(on_drum, of_weight, 0.02);
    assert_relative(force, -weight, 0.01);
}

/// Two disks that move past each other become one body. It keeps the momentum and the angular
/// momentum 2 m a v; with the inertia I = 2 (m a^2 + m r^2/2) it has L^2/2I of the 2 m v^2/2 that
/// they had. The rest is lost as in a plastic impact, and stands in the ledger.
#[test]
fn disks_that_become_rigid_lose_the_energy_of_their_relative_motion() {
    let (a, u, v) = (0.025, 0.4, 0.3);
    for law in ["", "friction_law: Coulomb(),"] {
        let mut rig = scene(
            &[(0.0, 0.0), (2.0 * a, 0.0)],
            &format!("analysis: Dynamic(dt: 1.0e-4), {law}"),
            "friction: 0.5",
            "",
            "Load(name: \"free\", increments: 2),
             Load(name: \"joined\", increments: 1, rigid: { \"body\": (select: Index([0, 1])) })",
        );
        let clastic::scene::format::Specimen::Particles(list) = &mut rig.specimen else { panic!() };
        (list[0].velocity, list[1].velocity) = ((u, -v), (u, v));
        let mut simulation = Simulation::new(&rig, None);
        assert_eq!(records(&mut simulation).len(), 3);
        let total = simulation.world().resource::<EnergyLedger>().total;
        let inertia = 2.0 * mass() * (a * a + 0.5 * R * R);
        let momentum = 2.0 * mass() * a * v;
        let lost = mass() * v * v - 0.5 * momentum * momentum / inertia;
        // The disks have moved by 2 v dt each before they are joined: of second order in dt.
        assert_relative(total.exchange, -lost, 1e-4);
        assert_relative(total.kinetic, -lost, 1e-4);
        assert!(total.error().abs() < 1e-12 * total.throughput(), "{total:?}");
    }
}

/// A column of two disks between floor and lid, three springs in a row under the force F. While the
/// disks are one body, the spring between them keeps its F^2/2k to itself; released they have it
/// again.
#[test]
fn the_contacts_within_a_group_keep_their_elastic_energy_until_it_is_released() {
    let k = 1.0e6;
    let wall = |name: &str, y: f64, x: f64| {
        format!(
            "(name: \"{name}\", start: ({:?}, {y:?}), end: ({x:?}, {y:?}), \
              contact: (normal_stiffness: {k:?}))",
            -x
        )
    };
    let walls = format!("{}, {}", wall("floor", 0.0, 1.0), wall("lid", 4.0 * R, -1.0));
    let upright = "particles: [(select: All, x: Held, rotation: Held)]";
    let rig = scene(
        &[(0.0, R), (0.0, 3.0 * R)],
        "",
        &format!("normal_stiffness: {k:?}"),
        &walls,
        &format!(
            "Load(name: \"press\", increments: 2, {upright}, walls: {{ \"lid\": Displacement(0.0, -1.0e-5) }}),
             Load(name: \"one\", increments: 1, rigid: {{ \"body\": (select: Index([0, 1]), x: Held, rotation: Held) }}),
             Load(name: \"two\", increments: 1, {upright}, release: [\"body\"])"
        ),
    );
    let mut simulation = Simulation::new(&rig, None);
    let force = 2.0e-5 * k / 3.0;
    let spring = 0.5 * force * force / k;
    let mut stored = Vec::new();
    while next(&mut simulation).is_some() {
        let ledger = simulation.world().resource::<EnergyLedger>();
        stored.push((ledger.stored.unwrap(), ledger.total.exchange));
        assert!(ledger.total.error().abs() < 1e-8 * ledger.total.throughput());
    }
    for (found, (elastic, exchange)) in
        stored[1..].iter().zip([(3.0, 0.0), (2.0, -1.0), (3.0, 0.0)])
    {
        assert_within(found.0, elastic * spring, 1e-7 * spring);
        assert_within(found.1, exchange * spring, 1e-7 * spring);
    }
    let total = simulation.world().resource::<EnergyLedger>().total;
    let rest = [total.motion, total.turning, total.numerical, total.friction];
    assert!(rest.iter().all(|x| x.abs() < 1e-7 * spring), "{total:?}");
}
