//! Dynamics against analytic answers: impacts, inclines, oscillators, and what the associated law
//! does to sliding.

use std::f64::consts::PI;

use crate::common::*;
use clastic::components::contact::ContactTable;
use clastic::cone::program::ConeSolution;
use clastic::run::Simulation;
use clastic::scene::format::{Analysis, FrictionLaw, Scene, Specimen, WallControl};
use glam::DVec2;

/// Tolerance after some hundred increments that are solved to a residual near 1e-11.
const EXACT: f64 = 1e-9;

const COULOMB: FrictionLaw = FrictionLaw::COULOMB;

const G: f64 = 9.81;
/// Sine and cosine of the incline.
const SIN: f64 = 0.6;
const COS: f64 = 0.8;

fn set_analysis(scene: &mut Scene, dt: f64, theta: f64) {
    scene.analysis = Analysis::Dynamic { dt, theta };
}

fn only_disk(scene: &mut Scene) -> &mut clastic::scene::format::Particle {
    let Specimen::Particles(list) = &mut scene.specimen else { panic!("explicit particles") };
    assert_eq!(list.len(), 1);
    &mut list[0]
}

#[test]
fn bounce_rebounds_with_one_minus_theta_over_theta() {
    let (dt, n) = (1e-3, 100);
    for theta in [0.5, 0.6, 0.75, 1.0] {
        let mut scene = load("bounce");
        set_analysis(&mut scene, dt, theta);
        let steps = f64::from(n);
        let height = G * dt * dt * (0.5 * steps * (steps - 1.0) + steps * theta);
        only_disk(&mut scene).position.1 = 0.01 + height;
        let mut simulation = Simulation::new(&scene, None);
        for k in 1..=n {
            next(&mut simulation);
            assert_relative(states(&mut simulation)[0].velocity.y, -f64::from(k) * G * dt, EXACT);
        }
        let impact = -states(&mut simulation)[0].velocity.y;
        assert_within(states(&mut simulation)[0].position.y, 0.01, 1e-15);
        next(&mut simulation);
        let rebound = states(&mut simulation)[0].velocity.y;
        assert_within(rebound / impact, (1.0 - theta) / theta, EXACT);
    }
}

/// Runs an incline: speed along it and spin in every increment, against constant accelerations.
fn incline(scene: &str, acceleration: f64, angular: f64) {
    let radius = 0.05;
    for (dt, theta) in [(1e-2, 1.0), (1e-3, 1.0), (1e-2, 0.6)] {
        let mut scene = load(scene);
        set_analysis(&mut scene, dt, theta);
        scene.friction_law = COULOMB;
        let mut simulation = Simulation::new(&scene, None);
        let (along, normal) = (DVec2::new(COS, -SIN), DVec2::new(SIN, COS));
        let start = states(&mut simulation)[0].position;
        for k in 1..=50 {
            next(&mut simulation).unwrap();
            let t = dt * f64::from(k);
            let disk = states(&mut simulation)[0];
            // Relative to free fall along the incline, so that rest has a scale too.
            let scale = EXACT * G * SIN * t;
            assert_within(disk.velocity.dot(along), acceleration * t, scale);
            assert_within(disk.spin * radius, -angular * radius * t, scale);
            // Without dilation: the contact stays closed.
            assert_within((disk.position - start).dot(normal), 0.0, scale * t);
        }
    }
}

#[test]
fn incline_rolls_with_two_thirds_of_the_slope() {
    let a = 2.0 / 3.0 * G * SIN;
    incline("incline_rolls", a, a / 0.05);
}

#[test]
fn incline_rolls_with_resistance_taken_off() {
    let a = 2.0 / 3.0 * G * (SIN - 0.3 * COS);
    incline("incline_rolls_with_resistance", a, a / 0.05);
}

#[test]
fn incline_slips_with_friction_taken_off() {
    incline("incline_slips", G * (SIN - 0.2 * COS), 2.0 * 0.2 * G * COS / 0.05);
}

#[test]
fn incline_rests_under_rolling_resistance_or_held_rotation() {
    incline("incline_rests", 0.0, 0.0);
    incline("incline_held", 0.0, 0.0);
}

#[test]
fn incline_changes_from_rolling_to_slipping_at_a_third_of_the_slope() {
    let slip_after_run = |friction: f64| {
        let mut scene = load("incline_rolls");
        scene.walls[0].contact.friction = friction;
        scene.friction_law = COULOMB;
        let mut simulation = Simulation::new(&scene, None);
        while next(&mut simulation).is_some() {}
        let disk = states(&mut simulation)[0];
        disk.velocity.dot(DVec2::new(COS, -SIN)) + disk.radius * disk.spin
    };
    // The speed of slip at t = 0.5 s is g t (sin b - 3 mu cos b) below the limit, zero above.
    assert_within(slip_after_run(0.25 * 1.001), 0.0, EXACT);
    assert_within(slip_after_run(0.25 * 0.999), G * 0.5 * SIN * 1e-3, EXACT);
}

/// A disk of 10 mm that touches a rough floor and moves into it.
fn impact(velocity: (f64, f64), friction: f64, law: FrictionLaw, theta: f64, stage: &str) -> Scene {
    let (vx, vy) = velocity;
    let mut scene = parse(&format!(
        "(
            version: 1,
            title: \"oblique impact\",
            analysis: Dynamic(dt: 1.0e-3, theta: {theta:?}),
            materials: {{ \"stone\": () }},
            specimen: Particles([(position: (0.0, 0.01), radius: 0.01, velocity: ({vx:?}, {vy:?}))]),
            walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0), contact: (friction: {friction:?}))],
            stages: [Load(name: \"impact\", increments: 1{stage})],
        )"
    ));
    scene.friction_law = law;
    scene
}

fn after_one_increment(scene: &Scene) -> State {
    let mut simulation = Simulation::new(scene, None);
    next(&mut simulation).unwrap();
    states(&mut simulation)[0]
}

#[test]
fn oblique_impact_slides_throughout_where_it_is_fast_enough() {
    for theta in [1.0, 0.75, 0.6] {
        for friction in [0.1, 0.3, 0.6] {
            let e = (1.0 - theta) / theta;
            let (vn, limit) = (2.0, 3.0 * friction * (1.0 + e) * 2.0);
            let vt = 1.1 * limit;
            let disk = after_one_increment(&impact((vt, -vn), friction, COULOMB, theta, ""));
            assert_within(disk.velocity.y, e * vn, EXACT * vt);
            assert_within(disk.velocity.x, vt - friction * (1.0 + e) * vn, EXACT * vt);
            assert_within(-disk.spin * disk.radius, 2.0 * friction * (1.0 + e) * vn, EXACT * vt);
        }
    }
}

#[test]
fn oblique_impact_sticks_where_it_is_slow() {
    // Plastic: below 3 mu v_n of slip the disk rolls on, with 2/3 of its speed.
    let disk = after_one_increment(&impact((0.9 * 3.0 * 0.3 * 2.0, -2.0), 0.3, COULOMB, 1.0, ""));
    assert_relative(disk.velocity.x, 0.6 * 3.0 * 0.3 * 2.0, EXACT);
    assert_relative(-disk.spin * disk.radius, disk.velocity.x, EXACT);
}

#[test]
fn associated_law_slows_a_point_impact_too_much() {
    for friction in [0.1, 0.5, 1.0] {
        let held = ", particles: [(select: All, rotation: Held)]";
        let (vt, vn) = (3.0, 2.0);
        let after =
            |law| after_one_increment(&impact((vt, -vn), friction, law, 1.0, held)).velocity;
        let associated = after(FrictionLaw::Associated);
        let expected = (vt - friction * vn) / (1.0 + friction * friction);
        assert_relative(associated.x, expected, EXACT);
        // It leaves the floor with mu times its speed: the dilation of the law.
        assert_relative(associated.y, friction * expected, EXACT);
        let coulomb = after(COULOMB);
        assert_relative(coulomb.x, vt - friction * vn, EXACT);
        assert_within(coulomb.y, 0.0, EXACT * vt);
    }
}

/// The associated law stops a grain that passes a wall nearer than its opening; Coulomb's lets it
/// by.
#[test]
fn a_disk_that_passes_a_wall_closely_touches_it_under_the_associated_law_alone() {
    let passing = |law| {
        let mut scene = impact((3.0, 0.0), 0.5, law, 1.0, "");
        // It moves 3 mm: the opening would be 1.5 mm.
        only_disk(&mut scene).position.1 += 0.2e-3;
        after_one_increment(&scene).velocity
    };
    assert!(passing(FrictionLaw::Associated).x < 2.9);
    assert_within(passing(COULOMB).distance(DVec2::new(3.0, 0.0)), 0.0, EXACT);
}

#[test]
fn associated_law_lags_a_sliding_block_and_lets_it_hover() {
    for friction in [0.2, 0.5] {
        for dt in [1e-2, 1e-3] {
            let mut scene = load("incline_held");
            scene.walls[0].contact.friction = friction;
            scene.friction_law = FrictionLaw::Associated;
            set_analysis(&mut scene, dt, 1.0);
            let mut simulation = Simulation::new(&scene, None);
            let (along, normal) = (DVec2::new(COS, -SIN), DVec2::new(SIN, COS));
            let start = states(&mut simulation)[0].position;
            let acceleration = G * (SIN - friction * COS);
            let rho = friction * friction / (1.0 + friction * friction);
            for n in 1..=50 {
                next(&mut simulation).unwrap();
                let lag = friction * friction * (1.0 - rho.powi(n));
                let speed = acceleration * dt * (f64::from(n) - lag);
                let block = states(&mut simulation)[0];
                assert_relative(block.velocity.dot(along), speed, EXACT);
                let hover = (block.position - start).dot(normal);
                assert_within(hover, dt * friction * speed, EXACT * acceleration * dt * dt);
            }
        }
    }
}

/// A disk with its rotation held, on a plate that starts sideways at 5 m/s.
fn on_a_plate_that_starts(
    law: FrictionLaw,
    friction: f64,
    increments: u32,
) -> (State, State, [f64; 2]) {
    let mut scene = load("incline_held");
    scene.friction_law = law;
    set_analysis(&mut scene, 1e-3, 1.0);
    scene.walls[0].end = (1.6, 0.0);
    scene.walls[0].contact.friction = friction;
    only_disk(&mut scene).position = (0.8, 0.05);
    let run = stage(&mut scene, "run");
    run.increments = increments;
    run.walls.insert("incline".into(), WallControl::Velocity(5.0, 0.0));
    let mut simulation = Simulation::new(&scene, None);
    let start = states(&mut simulation)[0];
    while next(&mut simulation).is_some() {}
    let end = states(&mut simulation)[0];
    let [p, q, _] = simulation.world().resource::<ConeSolution>().forces[0];
    (start, end, [p, q])
}

#[test]
fn a_plate_that_starts_sideways_drags_a_disk_and_does_not_lift_it() {
    for friction in [0.3, 0.8] {
        let (start, end, [p, q]) = on_a_plate_that_starts(COULOMB, friction, 10);
        let weight = start.mass * G;
        assert_within(end.position.y, start.position.y, 1e-10);
        assert_relative(p, weight, 1e-10);
        assert_relative(q.abs(), friction * weight, 1e-10);
        assert_relative(end.velocity.x, friction * G * 10e-3, 1e-10);
        // Under the associated law a sliding contact opens by mu v dt.
        let (start, end, _) = on_a_plate_that_starts(FrictionLaw::Associated, friction, 1);
        let rise = end.position.y - start.position.y;
        assert_relative(rise, friction * (5.0 - end.velocity.x) * 1e-3, 1e-8);
    }
}

#[test]
fn stack_rests_and_every_contact_carries_what_stands_on_it() {
    let mut simulation = Simulation::new(&load("stack"), None);
    let start = states(&mut simulation);
    let weight = start[0].mass * G;
    assert_relative(weight, 2650.0 * PI * 1e-4 * G, 1e-12);
    while let Some(record) = next(&mut simulation) {
        let mut carried: Vec<_> = simulation
            .world()
            .resource::<ContactTable>()
            .0
            .iter()
            .zip(&simulation.world().resource::<ConeSolution>().forces)
            .map(|(contact, force)| (contact.a, contact.b, force[0]))
            .collect();
        // The contact below disk k carries disks k to 9; the floor has the maximum number.
        carried.sort_by_key(|(a, b, _)| if *b == 10 { 0 } else { a + 1 });
        assert_eq!(carried.len(), 10);
        for (k, (.., force)) in carried.iter().enumerate() {
            assert_relative(*force, (10 - k) as f64 * weight, EXACT);
        }
        assert_relative(probe(&record, "floor").force[1], 10.0 * weight, EXACT);
    }
    // 0.5 s: at rest to round-off of its height.
    for (now, before) in states(&mut simulation).iter().zip(&start) {
        assert_within(now.position.distance(before.position), 0.0, 1e-12);
        assert_within(now.velocity.length(), 0.0, 1e-10);
        assert_within(now.rotation, 0.0, 1e-10);
    }
}

/// Two disks of mass m with a spring k between them, or one disk and a wall.
struct Spring {
    /// omega = sqrt(k/m*).
    frequency: f64,
    speed: f64,
    scene: Scene,
}

const STIFFNESS: f64 = 8e6;
const RADIUS: f64 = 6e-3;

fn disk_mass() -> f64 {
    2650.0 * PI * RADIUS * RADIUS
}

/// Two touching disks that approach each other at `speed`, bonded (an oscillator) or not (an
/// impact).
fn two_disks(bonded: bool, dt: f64, theta: f64, increments: u32) -> Spring {
    let speed = 0.1;
    let bonds = if bonded { "bonds: [(a: 0, b: 1)]," } else { "" };
    let scene = parse(&format!(
        "(
            version: 1,
            title: \"two disks\",
            analysis: Dynamic(dt: {dt:?}, theta: {theta:?}),
            materials: {{ \"stone\": (
                contact: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?}, friction: 0.5),
                bond: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?}, friction: 0.5,
                    cohesion: 1.0e9, tensile_strength: 1.0e9),
            ) }},
            specimen: Particles([
                (position: (0.0, 0.0), radius: {RADIUS:?}, velocity: ({:?}, 0.0)),
                (position: ({:?}, 0.0), radius: {RADIUS:?}, velocity: ({:?}, 0.0)),
            ]),
            {bonds}
            stages: [Load(name: \"free\", increments: {increments})],
        )",
        0.5 * speed,
        2.0 * RADIUS,
        -0.5 * speed,
    ));
    Spring { frequency: (STIFFNESS / (0.5 * disk_mass())).sqrt(), speed, scene }
}

fn frequency() -> f64 {
    two_disks(true, 1e-5, 0.5, 1).frequency
}

/// Overlap and its rate.
fn closing(simulation: &mut Simulation) -> (f64, f64) {
    let s = states(simulation);
    (2.0 * RADIUS - (s[1].position.x - s[0].position.x), s[0].velocity.x - s[1].velocity.x)
}

#[test]
fn undamped_oscillator_keeps_its_energy_at_theta_one_half() {
    // w dt = 0.1 for 1000 increments: 16 periods.
    let rig = two_disks(true, 0.1 / frequency(), 0.5, 1000);
    let mut simulation = Simulation::new(&rig.scene, None);
    let energy = |simulation: &mut Simulation| {
        let kinetic: f64 =
            states(simulation).iter().map(|s| 0.5 * s.mass * s.velocity.length_squared()).sum();
        kinetic + 0.5 * STIFFNESS * closing(simulation).0.powi(2)
    };
    let before = energy(&mut simulation);
    while next(&mut simulation).is_some() {
        assert_relative(energy(&mut simulation), before, 1e-11);
    }
}

#[test]
fn undamped_oscillator_follows_the_trapezoidal_rule_exactly() {
    // At theta = 1/2 a linear oscillator turns its phase by 2 atan(w dt/2) an increment.
    let dt = 0.1 / frequency();
    let rig = two_disks(true, dt, 0.5, 200);
    let mut simulation = Simulation::new(&rig.scene, None);
    let amplitude = rig.speed / rig.frequency;
    for n in 1..=200 {
        next(&mut simulation).unwrap();
        let phase = f64::from(n) * 2.0 * (0.5 * rig.frequency * dt).atan();
        let (overlap, rate) = closing(&mut simulation);
        assert_within(overlap, amplitude * phase.sin(), EXACT * amplitude);
        assert_within(rate, rig.speed * phase.cos(), EXACT * rig.speed);
    }
}

/// Error of the overlap of a bonded pair against `A sin(w t)` after w t = 2, over A.
fn oscillator_error(theta: f64, increments: u32) -> f64 {
    let dt = 2.0 / f64::from(increments) / frequency();
    let rig = two_disks(true, dt, theta, increments);
    let mut simulation = Simulation::new(&rig.scene, None);
    while next(&mut simulation).is_some() {}
    let amplitude = rig.speed / rig.frequency;
    (closing(&mut simulation).0 / amplitude - 2.0_f64.sin()).abs()
}

#[test]
fn theta_method_is_second_order_at_one_half_and_first_order_elsewhere() {
    let ratio = |theta, n| oscillator_error(theta, n) / oscillator_error(theta, 2 * n);
    // Halving the increment divides the error by 4 and 2, up to the next order.
    assert_within(ratio(0.5, 50), 4.0, 0.01);
    assert_within(ratio(0.6, 200), 2.0, 0.05);
    assert_within(ratio(1.0, 400), 2.0, 0.05);
}

#[test]
fn linear_spring_impact_has_its_contact_time_and_maximum_overlap() {
    // dt such that the trapezoidal rule turns the phase by pi/2 in n increments: the overlap has
    // its maximum v sqrt(m*/k) after n of them, and the contact ends after 2 n.
    let contact_time = |n: u32| {
        let dt = 2.0 / frequency() * (PI / f64::from(4 * n)).tan();
        let rig = two_disks(false, dt, 0.5, 2 * n + 1);
        let mut simulation = Simulation::new(&rig.scene, None);
        let amplitude = rig.speed / rig.frequency;
        for k in 1..=2 * n {
            next(&mut simulation).unwrap();
            let (overlap, rate) = closing(&mut simulation);
            if k == n {
                assert_relative(overlap, amplitude, EXACT);
                assert_within(rate, 0.0, EXACT * rig.speed);
            }
        }
        let (overlap, rate) = closing(&mut simulation);
        assert_within(overlap, 0.0, EXACT * amplitude);
        assert_relative(rate, -rig.speed, EXACT);
        // And it flies off.
        next(&mut simulation).unwrap();
        assert_relative(closing(&mut simulation).1, -rig.speed, EXACT);
        f64::from(2 * n) * dt
    };
    let exact = PI / frequency();
    let (coarse, fine) = (contact_time(20) / exact - 1.0, contact_time(40) / exact - 1.0);
    // (w dt)^2/12 too long.
    assert_relative(fine, (PI / 80.0).powi(2) / 12.0, 1e-2);
    assert_within(coarse / fine, 4.0, 0.01);
}

/// `Rest` ended a fall after its first increment, slow as it was.
#[test]
fn a_fall_that_begins_is_not_at_rest() {
    let scene = parse(
        "(
            version: 1,
            title: \"fall\",
            analysis: Dynamic(dt: 1.0e-4),
            gravity: (0.0, -9.81),
            materials: { \"stone\": (contact: ()) },
            specimen: Particles([(position: (0.0, 2.0e-3), radius: 1.0e-3)]),
            walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0))],
            stages: [Load(name: \"fall\", increments: 1000, stop: [Rest(0.01)])],
        )",
    );
    let (records, _) = run(&scene);
    // 1 mm takes sqrt(2 h/g) = 14.3 ms, 143 increments; theta = 1 sticks to the floor.
    assert!((140..160).contains(&records.len()), "{} increments", records.len());
}
