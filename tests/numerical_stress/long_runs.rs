//! Long runs: a stack at rest, a box that is shaken. No drift, no growth of energy, no penetration
//! that adds up, flat memory.

use std::process::Command;

use clastic::run::Simulation;
use clastic::scene::format::{Scene, Stage, WallControl};

use crate::common::{assert_within, load, next, parse, stage, states};
use crate::random::full;

/// Resident memory of this process, bytes.
fn memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(4096 * text.split(' ').nth(1)?.parse::<u64>().ok()?)
}

/// Maximum overlap of two disks over the mean radius.
fn penetration(simulation: &mut Simulation) -> f64 {
    let s = states(simulation);
    let mut maximum = 0.0_f64;
    for a in 0..s.len() {
        for b in 0..a {
            let overlap = s[a].radius + s[b].radius - s[a].position.distance(s[b].position);
            maximum = maximum.max(overlap / s[a].radius);
        }
    }
    maximum
}

fn resting(theta: f64, increments: u32) -> Scene {
    let mut scene = load("stack");
    scene.analysis = clastic::scene::format::Analysis::Dynamic { dt: 1e-3, theta };
    let Stage::Load(load) = &mut scene.stages[0] else { unreachable!() };
    load.increments = increments;
    load.stop.clear();
    scene
}

fn stack_rests(increments: u32) {
    for theta in [0.5, 1.0] {
        let mut simulation = Simulation::new(&resting(theta, increments), None);
        let start = states(&mut simulation);
        let (mut n, mut warm) = (0, None);
        let mut energy = 0.0_f64;
        while let Some(record) = next(&mut simulation) {
            n += 1;
            energy = energy.max(record.kinetic_energy);
            if n == increments / 10 {
                warm = memory();
            }
        }
        let (mut drift, mut turn) = (0.0_f64, 0.0_f64);
        for (s, before) in states(&mut simulation).iter().zip(&start) {
            drift = drift.max(s.position.distance(before.position) / s.radius);
            turn = turn.max(s.rotation.abs());
        }
        let overlap = penetration(&mut simulation);
        println!(
            "stack, theta {theta}, {n} increments: drift {drift:.1e} radii, {turn:.1e} rad, kinetic {energy:.1e} J, \
             overlap {overlap:.1e} radii, memory {warm:?} -> {:?}",
            memory()
        );
        assert_within(drift, 0.0, 1e-9);
        assert_within(turn, 0.0, 1e-9);
        assert_within(energy, 0.0, 1e-18);
        assert_within(overlap, 0.0, 1e-9);
        flat(warm);
    }
}

fn flat(warm: Option<u64>) {
    if let (Some(warm), Some(now)) = (warm, memory()) {
        assert!(now < warm + (4 << 20), "{warm} bytes after a tenth, {now} at the end");
    }
}

/// Runs a test of this file in a process of its own: the memory of others would count as its own.
fn alone(test: &str, run: impl Fn()) {
    const ALONE: &str = "CLASTIC_ALONE";
    if std::env::var_os(ALONE).is_some() {
        return run();
    }
    let name = format!("long_runs::{test}");
    let mut command = Command::new(std::env::current_exe().unwrap());
    let arguments = ["--exact", &name, "--include-ignored", "--nocapture"];
    let output = command.args(arguments).env(ALONE, "1").output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("1 passed"), "{name} is not there");
}

/// Twelve disks in a box whose floor goes up and down: a stage each way.
fn shaken(contact: &str, theta: f64, increments: u32) -> Scene {
    let half = 20;
    let mut disks = String::new();
    for k in 0..12 {
        let (x, y) = (0.012 + 0.0215 * f64::from(k % 4), 0.011 + 0.0215 * f64::from(k / 4));
        disks += &format!(
            "(position: ({:?}, {y:?}), radius: {:?}),",
            x + 1e-3 * f64::from(k / 4),
            0.01 - 5e-4 * f64::from(k % 3)
        );
    }
    let mut scene = parse(&format!(
        "(
            version: 1,
            title: \"shaken box\",
            analysis: Dynamic(dt: 1.0e-3, theta: {theta:?}),
            gravity: (0.0, -9.81),
            materials: {{ \"stone\": (contact: ({contact})) }},
            specimen: Particles([{disks}]),
            walls: [
                (name: \"floor\", start: (0.0, 0.0), end: (0.1, 0.0), contact: ({contact})),
                (name: \"left\", start: (0.0, 1.0), end: (0.0, 0.0), contact: ({contact})),
                (name: \"right\", start: (0.09, 0.0), end: (0.09, 1.0), contact: ({contact})),
            ],
            stages: [Load(name: \"shake\", increments: {half})],
        )"
    ));
    let template = stage(&mut scene, "shake").clone();
    scene.stages = (0..increments / half)
        .map(|k| {
            let mut load = template.clone();
            load.name = format!("shake {k}");
            let speed = if k % 2 == 0 { 0.2 } else { -0.2 };
            load.walls.insert("floor".into(), WallControl::Velocity(0.0, speed));
            Stage::Load(load)
        })
        .collect();
    scene
}

fn box_is_shaken(increments: u32) {
    let rigid = "friction: 0.3, rolling_friction: 0.02";
    let elastic = "normal_stiffness: 1.0e6, tangential_stiffness: 5.0e5, friction: 0.3";
    for (contact, theta) in [(rigid, 1.0), (rigid, 0.75), (elastic, 1.0), (elastic, 0.5)] {
        let mut simulation = Simulation::new(&shaken(contact, theta, increments), None);
        let (mut early, mut late, mut n, mut overlap) = (0.0_f64, 0.0_f64, 0, 0.0_f64);
        let mut warm = None;
        while let Some(record) = next(&mut simulation) {
            n += 1;
            if n <= increments / 2 {
                early = early.max(record.kinetic_energy);
            } else {
                late = late.max(record.kinetic_energy);
            }
            if n % 100 == 0 {
                overlap = overlap.max(penetration(&mut simulation));
            }
            if n == increments / 10 {
                warm = memory();
            }
        }
        println!(
            "shaken box, {contact}, theta {theta}: {n} increments, kinetic energy {early:.2e} and {late:.2e} J in \
             the halves, overlap {overlap:.1e} radii, memory {warm:?} -> {:?}",
            memory()
        );
        // 12 disks of 0.8 kg; the floor throws them with 0.2 m/s and 0.4 m/s at a turn.
        assert!(late < 2.0 * early && late < 12.0 * 0.5 * 0.83, "energy grows");
        // Elastic: what all of the kinetic energy would do to one contact.
        let deepest = (2.0 * early.max(late) / 1e6).sqrt() / 0.009;
        let accepted = if contact == rigid { 1e-6 } else { deepest };
        assert_within(overlap, 0.0, accepted);
        for s in states(&mut simulation) {
            assert!(
                (0.0..0.09).contains(&s.position.x) && s.position.y > -0.01 && s.position.y < 0.5
            );
        }
        flat(warm);
    }
}

#[test]
fn stack_rests_and_box_is_shaken_for_a_while() {
    alone("stack_rests_and_box_is_shaken_for_a_while", || {
        stack_rests(full(2_000, 10_000));
        box_is_shaken(full(1_000, 5_000));
    });
}

#[test]
#[ignore = "long"]
fn stack_rests_for_a_hundred_thousand_increments() {
    alone("stack_rests_for_a_hundred_thousand_increments", || stack_rests(100_000));
}

#[test]
#[ignore = "long"]
fn box_is_shaken_for_a_hundred_thousand_increments() {
    alone("box_is_shaken_for_a_hundred_thousand_increments", || box_is_shaken(100_000));
}
