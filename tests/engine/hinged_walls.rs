//! Walls as members of rigid groups: gates about a pivot under a moment, whose angle is an unknown.

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::energy::EnergyLedger;
use clastic::components::observation::Observation;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::{FrictionLaw, Scene};

const LAWS: [FrictionLaw; 2] = [FrictionLaw::Associated, FrictionLaw::COULOMB];

fn records(simulation: &mut Simulation) -> Vec<Observation> {
    std::iter::from_fn(|| next(simulation)).collect()
}

/// Rows of four elastic disks between a fixed wall and a gate with its hinge at (0.04, 0).
fn rows(head: &str, shape: &str, stages: &str) -> Scene {
    let mut disks = String::new();
    for y in HEIGHTS {
        for x in [5e-3, 15e-3, 25e-3, 35e-3] {
            disks += &format!("(position: ({x:?}, {y:?}), radius: 5.0e-3), ");
        }
    }
    parse(&format!(
        "(version: 1, title: \"gate\", {head} output: (energy: true),
          materials: {{ \"steel\": (density: 7800.0, contact: (normal_stiffness: {K:?})) }},
          specimen: Particles([{disks}]),
          walls: [
            (name: \"back\", start: (0.0, 0.072), end: (0.0, 0.0), contact: (normal_stiffness: {K:?})),
            (name: \"gate\", start: (0.04, 0.0), end: (0.04, 0.072), contact: (normal_stiffness: {K:?}),
                shape: {shape}, probe: \"plate\"),
          ],
          stages: [{stages}])"
    ))
}

const K: f64 = 1.0e7;
const R: f64 = 5.0e-3;
const HEIGHTS: [f64; 6] = [6e-3, 18e-3, 30e-3, 42e-3, 54e-3, 66e-3];
const HELD: &str = "particles: [(select: All, y: Held, rotation: Held)]";

/// Forces of the rows on a gate that is turned by `a`, their arms about the hinge, and their moment,
/// as the head of `scenes/turning_gate.ron` derives them.
fn by_hand(a: f64) -> (Vec<(f64, f64)>, f64) {
    let n = 4.0;
    let rows = HEIGHTS.map(|y| {
        let p = K * (R * (1.0 - a.cos()) + y * a.sin()) / (1.0 + n * a.cos().powi(2));
        let w = n * p * a.cos() / K;
        (p, y * a.cos() + (R + w) * a.sin())
    });
    (rows.to_vec(), rows.iter().map(|(p, s)| p * s).sum())
}

/// The angle under a moment, by bisection.
fn angle_under(moment: f64) -> f64 {
    let (mut low, mut high) = (0.0, 0.3);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if by_hand(middle).1 < moment {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// A gate under a moment turns until the springs balance it, in statics and in dynamics: a wall has
/// no mass. The angle is that of the closed form, and the moments are in equilibrium.
#[test]
fn a_gate_turns_under_a_moment_into_springs() {
    let moment = 800.0;
    let expected = angle_under(moment);
    for law in LAWS {
        for analysis in ["Static", "Dynamic(dt: 1.0e-3)"] {
            for shape in ["Line", "Segment", "Polyline([(0.04, 0.03)])"] {
                // In time steps the slowest motion of a row falls by 0.6 in each.
                let settle = if analysis == "Static" { 12 } else { 60 };
                let mut scene = rows(
                    // The weight is carried by what holds the disks.
                    &format!("analysis: {analysis}, gravity: (0.0, -9.81),"),
                    shape,
                    &format!(
                        "Load(name: \"close\", increments: 20, {HELD}, rigid: {{ \"gate\":
                            (walls: [\"gate\"], about: (0.04, 0.0), x: Held, y: Held, moment: {moment:?}) }}),
                         Load(name: \"settle\", increments: {settle}, {HELD}),
                         Load(name: \"open\", increments: 20, {HELD}, rigid: {{ \"gate\":
                            (x: Held, y: Held, moment: 8.0) }}),
                         Load(name: \"rest\", increments: {settle}, {HELD})"
                    ),
                );
                scene.friction_law = law;
                let mut simulation = Simulation::new(&scene, None);
                let all = records(&mut simulation);
                let what = format!("{analysis} {shape}");
                let [held, eased] = [19 + settle, 39 + 2 * settle];
                assert_eq!(all.len(), eased + 1, "{what}: {:?}", simulation.run());
                let gate = probe(&all[held], "gate");
                println!(
                    "{what}: angle off by {:.1e}, moment by {:.1e}",
                    gate.motion[2] / expected - 1.0,
                    gate.force[2] / moment + 1.0
                );
                // By the angle that it has, and by the closed form.
                assert_relative(by_hand(gate.motion[2]).1, moment, 1e-8);
                assert_relative(gate.motion[2], expected, 1e-8);
                assert_relative(gate.force[2], -moment, 1e-8);
                let total: f64 = by_hand(expected).0.iter().map(|(p, _)| p).sum();
                assert_relative(gate.force[0], total * expected.cos(), 1e-7);
                assert_relative(gate.force[1], total * expected.sin(), 1e-7);
                // The probe of the wall has the force of the wall on the specimen.
                let plate = probe(&all[held], "plate");
                assert_relative(plate.force[0], -gate.force[0], 1e-12);
                assert_eq!(plate.motion[2].to_bits(), gate.motion[2].to_bits());
                // The way back is the same.
                let gate = probe(&all[eased], "gate");
                assert_relative(gate.motion[2], angle_under(8.0), 1e-8);
                let total = simulation.world().resource::<EnergyLedger>().total;
                assert!(total.error().abs() < 1e-7 * total.throughput(), "{what}: {total:?}");
            }
        }
    }
}

/// Work of the moment along the angle of the closed form, by Simpson's rule, is what the springs
/// store; the ledger has it, to first order in the increment.
#[test]
fn the_work_of_the_moment_is_the_energy_of_the_springs() {
    let moment = 800.0;
    let n = 4.0;
    let a = angle_under(moment);
    let stored: f64 =
        by_hand(a).0.iter().map(|(p, _)| p * p * (1.0 + n * a.cos().powi(2)) / (2.0 * K)).sum();
    let mut errors = Vec::new();
    for increments in [20, 40] {
        let scene = rows(
            "",
            "Line",
            &format!(
                "Load(name: \"close\", increments: {increments}, {HELD}, rigid: {{ \"gate\":
                    (walls: [\"gate\"], about: (0.04, 0.0), x: Held, y: Held, moment: {moment:?}) }}),
                 Load(name: \"settle\", increments: 12, {HELD})"
            ),
        );
        let mut simulation = Simulation::new(&scene, None);
        records(&mut simulation);
        let total = simulation.world().resource::<EnergyLedger>().total;
        assert_relative(total.elastic, stored, 1e-8);
        errors.push(total.external / stored - 1.0);
    }
    println!("work of the moment: off by {errors:?}");
    assert!(errors.iter().all(|e| e.abs() < 2e-3), "{errors:?}");
    assert!((errors[1] / errors[0]).abs() < 0.6, "{errors:?}");
}

/// A plate of no mass on a hinge carries two disks that hold still along it: the moment on it is
/// that of their weights, whatever its angle; and the moment is zero without the plate.
#[test]
fn a_seesaw_balances_by_the_law_of_the_lever() {
    let weight = |r: f64| 2000.0 * std::f64::consts::PI * r * r * 9.81;
    let (near, far) = (weight(0.02) * 0.1, weight(0.01) * 0.4);
    assert_relative(near, far, 1e-12);
    for analysis in ["Static", "Dynamic(dt: 1.0e-3)"] {
        for (extra, falls) in [(0.0, false), (0.5, true), (-0.5, true)] {
            let scene = parse(&format!(
                "(version: 1, title: \"seesaw\", gravity: (0.0, -9.81), analysis: {analysis},
                  materials: {{ \"m\": (density: 2000.0) }},
                  specimen: Particles([(position: (-0.1, 0.02), radius: 0.02),
                    (position: (0.4, 0.01), radius: 0.01)]),
                  walls: [(name: \"plate\", shape: Segment, start: (-0.5, 0.0), end: (0.5, 0.0))],
                  stages: [Load(name: \"stand\", increments: 3,
                    particles: [(select: All, x: Held, rotation: Held)], rigid: {{ \"plate\":
                        (walls: [\"plate\"], about: (0.0, 0.0), x: Held, y: Held, moment: {extra:?}) }})])"
            ));
            let mut simulation = Simulation::new(&scene, None);
            let all = records(&mut simulation);
            let last = all.last().unwrap();
            if falls {
                let has_moved = probe(last, "plate").motion[2] != 0.0;
                let collapsed = matches!(simulation.run(), Outcome::Collapsed(_));
                assert!(collapsed == (analysis == "Static"), "{analysis} {extra}");
                assert!(collapsed || has_moved, "{analysis} {extra}");
                continue;
            }
            let plate = probe(last, "plate");
            assert_within(plate.motion[2], 0.0, 1e-12);
            assert_within(plate.force[2], 0.0, 1e-8 * near);
            assert_relative(plate.force[1], -weight(0.02) - weight(0.01), 1e-8);
        }
    }
}

/// A plate that belongs to a disk hangs on a pivot and swings with it: the plate has no mass, so
/// that the motion is that of the disk alone, and the plate turns with it.
#[test]
fn a_plate_swings_with_the_disk_that_carries_it() {
    let swing = |walls: &str| {
        let scene = parse(&format!(
            "(version: 1, title: \"pendulum\", gravity: (0.0, -9.81), analysis: Dynamic(dt: 1.0e-3, theta: 0.5),
              materials: {{ \"m\": (density: 2000.0) }},
              specimen: Particles([(position: (0.3, 0.4), radius: 0.05)]),
              walls: [(name: \"plate\", shape: Segment, start: (0.0, 0.6), end: (0.0, 0.9), probe: \"wall\")],
              stages: [Load(name: \"swing\", increments: 700, rigid: {{ \"bob\":
                (select: All, {walls} about: (0.0, 0.0), x: Held, y: Held) }})])"
        ));
        let mut simulation = Simulation::new(&scene, None);
        records(&mut simulation)
    };
    let (alone, with) = (swing(""), swing("walls: [\"plate\"],"));
    for (a, b) in alone.iter().zip(&with) {
        assert_eq!(probe(a, "bob").motion[2].to_bits(), probe(b, "bob").motion[2].to_bits());
        assert_within(probe(b, "wall").motion[2], probe(b, "bob").motion[2], 1e-13);
        // The middle of the plate goes along on its circle.
        let turned = probe(b, "bob").motion[2];
        let [x, y, _] = probe(b, "wall").motion;
        assert_within(x, -0.75 * turned.sin(), 1e-12);
        assert_within(y, 0.75 * (turned.cos() - 1.0), 1e-12);
    }
    // It starts at 0.9273 rad from the upright, and is through the lowest point by then.
    assert!(probe(with.last().unwrap(), "bob").motion[2] < -2.5);
}

/// A gate that nothing touches yet turns under its moment until it meets what is in its way, however
/// far that is; a gate with nothing in its way is a collapse, with a proof.
#[test]
fn a_gate_comes_from_afar_or_falls() {
    let gate = |disks: &str| {
        parse(&format!(
            "(version: 1, title: \"gate\", materials: {{ \"m\": (density: 2000.0,
                contact: (normal_stiffness: 1.0e7)) }},
              specimen: Particles([{disks}]),
              walls: [(name: \"gate\", shape: Segment, start: (0.0, 0.0), end: (0.0, 0.2),
                contact: (normal_stiffness: 1.0e7))],
              stages: [Load(name: \"turn\", increments: 30, particles: [(select: All, x: Held, y: Held)],
                rigid: {{ \"gate\":
                    (walls: [\"gate\"], about: (0.0, 0.0), x: Held, y: Held, moment: 10.0) }}),
                Load(name: \"settle\", increments: 12, particles: [(select: All, x: Held, y: Held)])])"
        ))
    };
    let far = gate("(position: (-0.08, 0.12), radius: 0.02)");
    for law in LAWS {
        let mut scene = far.clone();
        scene.friction_law = law;
        let mut simulation = Simulation::new(&scene, None);
        let all = records(&mut simulation);
        let last = probe(all.last().unwrap(), "gate");
        // The line through the hinge at the distance r - p/k from the centre.
        let (reach, turn) = (0.08_f64.hypot(0.12), (0.08_f64 / 0.12).atan());
        let arm = |a: f64| reach * (turn - a).cos();
        let p = 10.0 / arm(last.motion[2]);
        assert_within(reach * (turn - last.motion[2]).sin(), 0.02 - p / 1.0e7, 1e-10);
        assert_relative(last.force[2], -10.0, 1e-8);
        assert!(last.motion[2] > 0.4 && all.iter().all(|r| r.status == IncrementStatus::Solved));
    }
    let (all, outcome) = run(&gate("(position: (0.08, 0.12), radius: 0.02)"));
    assert!(matches!(outcome, Outcome::Collapsed(_)), "{outcome:?} {}", all.len());
}
