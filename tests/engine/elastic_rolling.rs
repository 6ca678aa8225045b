//! Rolling moments with a stiffness, `tau = k_R d_r` up to `mu_r r (p + f_t)`, against closed forms.

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::bond::RuptureMode;
use clastic::components::energy::EnergyLedger;
use clastic::components::observation::Observation;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::Scene;

/// What a program solved to a residual near 1e-11 must reproduce.
const EXACT: f64 = 1e-9;

const LAWS: [&str; 2] = ["Associated", "Coulomb()"];

const RADIUS: f64 = 10e-3;
const NORMAL: f64 = 1e7;
const TANGENTIAL: f64 = 5e6;
/// k_R, N m/rad.
const ROLLING: f64 = 400.0;
const ROLLING_FRICTION: f64 = 0.2;
/// Weight of the disk, N.
const WEIGHT: f64 = 50.0;
/// The moment at which it rolls, N m.
const LIMIT: f64 = ROLLING_FRICTION * RADIUS * WEIGHT;

/// A disk on a plane, pressed by `WEIGHT` in the first increment; then these stages. `more` are
/// fields of the law besides those of the constants.
fn on_a_plane(friction_law: &str, stiffness: &str, stages: &str) -> Scene {
    let contact = format!(
        "normal_stiffness: {NORMAL:?}, tangential_stiffness: {TANGENTIAL:?}, {stiffness} \
         friction: 0.8, rolling_friction: {ROLLING_FRICTION:?}"
    );
    parse(&format!(
        r#"(
            version: 1,
            title: "disk on a plane",
            friction_law: {friction_law},
            materials: {{ "stone": (contact: ({contact})) }},
            specimen: Particles([(position: (0.0, {RADIUS:?}), radius: {RADIUS:?}, probe: "disk")]),
            walls: [(name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), contact: ({contact}))],
            output: (energy: true),
            stages: [
                Load(name: "press", increments: 1,
                    particles: [(select: All, force: (0.0, {:?}))]),
                {stages}
            ],
        )"#,
        -WEIGHT
    ))
}

fn stiffness() -> String {
    format!("rolling_stiffness: {ROLLING:?},")
}

/// A stage in which the disk turns by `step` per increment.
fn turn(name: &str, increments: u32, step: f64) -> String {
    format!(
        r#"Load(name: "{name}", increments: {increments},
            particles: [(select: All, rotation: Displacement({step:?}))]),"#
    )
}

fn moment(record: &Observation) -> f64 {
    probe(record, "disk").force[2]
}

/// A force F at the centre has the moment F l about the contact, l the arm of the shear force: the
/// disk turns by F l/k_R and moves by that times l, and by the slip F/k_T of the contact.
#[test]
fn a_disk_pushed_at_its_centre_turns_by_the_moment_over_the_stiffness() {
    let (push, n) = (4.0, 5);
    let stages = format!(
        r#"Load(name: "push", increments: {n}, particles: [(select: All, force: ({push:?}, {:?}))])"#,
        -WEIGHT
    );
    for law in LAWS {
        let (records, outcome) = run(&on_a_plane(law, &stiffness(), &stages));
        assert_eq!(outcome, Outcome::Completed);
        let arm = RADIUS - 0.5 * WEIGHT / NORMAL;
        let per_increment = push / f64::from(n);
        for (k, record) in records.iter().enumerate() {
            let (moved, force) = (probe(record, "disk").motion, k as f64 * per_increment);
            // The disk rolls forward: clockwise for a push to the right.
            let turned = force * arm / ROLLING;
            assert_within(moved[2], -turned, 1e-8 * push * arm / ROLLING);
            let there = turned * arm + force / TANGENTIAL;
            assert_within(moved[0], there, 1e-8 * push / TANGENTIAL);
        }
    }
}

/// The force at which the moment about the contact reaches mu_r r p is the limit load.
#[test]
fn the_limit_load_is_that_of_the_rigid_law() {
    let arm = RADIUS - 0.5 * WEIGHT / NORMAL;
    for law in LAWS {
        for (factor, holds) in [(1.0 - 1e-5, true), (1.0 + 1e-5, false)] {
            let force = factor * LIMIT / arm;
            let stages = format!(
                r#"Load(name: "push", increments: 1,
                    particles: [(select: All, force: ({force:?}, {:?}))])"#,
                -WEIGHT
            );
            let mut scene = on_a_plane(law, &stiffness(), &stages);
            scene.acceptance.halvings = 0;
            let mut simulation = Simulation::new(&scene, None);
            let records: Vec<_> = std::iter::from_fn(|| step(&mut simulation)).collect();
            let ended = records.last().unwrap().status;
            assert_eq!(ended == IncrementStatus::Solved, holds, "{law}, {factor}: {ended:?}");
        }
    }
}

/// Turned beyond its limit and back: elastic up to mu_r r p, constant, elastic on the way back, and
/// the rotation that is left without a moment is that beyond the limit. The ledger has the energies
/// of the three parts; rolling under the associated law leaves a gap, whose energy is `dilation`.
#[test]
fn a_contact_that_yields_keeps_the_rotation_beyond_its_limit() {
    let yields_at = LIMIT / ROLLING;
    let step = yields_at / 4.0;
    let stages = [turn("there", 10, step), turn("back", 14, -step)].concat();
    for law in LAWS {
        let mut simulation = Simulation::new(&on_a_plane(law, &stiffness(), &stages), None);
        let mut sums = Vec::new();
        let mut records = Vec::new();
        while let Some(record) = next(&mut simulation) {
            records.push(record);
            sums.push(simulation.world().resource::<EnergyLedger>().total);
        }
        let expected = |k: i32| match k {
            0..=4 => f64::from(k) * step * ROLLING,
            5..=10 => LIMIT,
            // Eight increments from the limit to its opposite.
            11..=18 => LIMIT - f64::from(k - 10) * step * ROLLING,
            _ => -LIMIT,
        };
        for (k, record) in records.iter().enumerate() {
            assert_within(moment(record), expected(k as i32), 1e-8 * LIMIT);
        }
        let before = sums[0];
        let stored = 0.5 * LIMIT * LIMIT / ROLLING;
        let there = sums[10];
        if law != "Associated" {
            assert_relative(there.elastic - before.elastic, stored, 1e-7);
        }
        assert_relative(there.rolling - before.rolling, LIMIT * 6.0 * step, 1e-7);
        // Back to zero moment after four increments: six steps of rotation are left.
        assert_within(sums[14].elastic - before.elastic, 0.0, 1e-7 * stored);
        assert_relative(sums[14].rolling - before.rolling, LIMIT * 6.0 * step, 1e-7);
        let last = sums[24];
        assert_relative(last.rolling - before.rolling, LIMIT * 12.0 * step, 1e-7);
        assert_within(last.numerical - before.numerical, 0.0, 1e-7 * stored);
        assert_within(last.error(), 0.0, 1e-7 * stored);
    }
}

/// With a stiffness far above all others the moment is at its limit in the first increment, as under
/// the rigid law, and all forces and motions are those of the rigid law.
#[test]
fn a_large_stiffness_gives_the_moments_of_the_rigid_law() {
    let step = 1e-5;
    let stages = [turn("there", 4, step), turn("back", 4, -step)].concat();
    for law in LAWS {
        let of = |stiffness: &str| run(&on_a_plane(law, stiffness, &stages)).0;
        let (stiff, rigid) = (of("rolling_stiffness: 1.0e14,"), of(""));
        for (k, (a, b)) in stiff.iter().zip(&rigid).enumerate().skip(1) {
            assert_relative(moment(a), if k <= 4 { LIMIT } else { -LIMIT }, 1e-8);
            assert_relative(moment(a), moment(b), 1e-8);
            let (a, b) = (probe(a, "disk"), probe(b, "disk"));
            for i in 0..2 {
                assert_within(a.motion[i], b.motion[i], 1e-7 * step * RADIUS);
            }
        }
    }
}

/// A rigid disk that rolls on a plane without slip has the inertia 3/2 m r^2 about its contact, and
/// swings on the spring of its moment with omega^2 = k_R/(3/2 m r^2). With theta = 1/2 the steps are
/// those of the trapezoidal rule, `tan(omega' dt/2) = omega dt/2`, and no energy is lost.
#[test]
fn a_disk_swings_on_its_rolling_spring() {
    let (k, density, dt, spin) = (2.0, 2650.0, 1e-4, 0.05);
    let mass = density * std::f64::consts::PI * RADIUS * RADIUS;
    let omega = (k / (1.5 * mass * RADIUS * RADIUS)).sqrt();
    let discrete = 2.0 / dt * (0.5 * omega * dt).atan();
    for law in LAWS {
        let contact = format!("friction: 0.9, rolling_friction: 0.5, rolling_stiffness: {k:?}");
        let scene = parse(&format!(
            r#"(
                version: 1,
                title: "rolling pendulum",
                analysis: Dynamic(dt: {dt:?}, theta: 0.5),
                gravity: (0.0, -9.81),
                friction_law: {law},
                materials: {{ "stone": (density: {density:?}, contact: ({contact})) }},
                specimen: Particles([(position: (0.0, {RADIUS:?}), radius: {RADIUS:?},
                    velocity: ({:?}, 0.0), angular_velocity: {spin:?})]),
                walls: [(name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), contact: ({contact}))],
                output: (energy: true),
                stages: [Load(name: "swing", increments: 2000)],
            )"#,
            -spin * RADIUS
        ));
        let mut simulation = Simulation::new(&scene, None);
        let mut n = 0;
        while next(&mut simulation).is_some() {
            n += 1;
            let phase = discrete * dt * f64::from(n);
            let disk = states(&mut simulation)[0];
            assert_within(disk.spin, spin * phase.cos(), 1e-7 * spin);
            assert_within(disk.rotation, spin / omega * phase.sin(), 1e-7 * spin / omega);
            assert_within(disk.position.x, -RADIUS * disk.rotation, 1e-7 * RADIUS * spin / omega);
        }
        // Some periods, in which the elastic and the kinetic energy are exchanged without a loss.
        assert!(discrete * dt * f64::from(n) > 4.0 * std::f64::consts::PI, "{omega}");
        let total = simulation.world().resource::<EnergyLedger>().total;
        let whole = 0.75 * mass * RADIUS * RADIUS * spin * spin;
        assert_within(total.elastic + total.kinetic, 0.0, 1e-6 * whole);
        assert_within(total.error(), 0.0, 1e-6 * whole);
        assert!(total.elastic > 0.0);
    }
}

/// At theta = 1 the same spring is damped, as every elastic force is.
#[test]
fn at_theta_one_a_rolling_spring_is_damped() {
    let contact = "friction: 0.9, rolling_friction: 0.5, rolling_stiffness: 2.0";
    let scene = parse(&format!(
        r#"(
            version: 1,
            title: "rolling pendulum",
            analysis: Dynamic(dt: 1.0e-3, theta: 1.0),
            gravity: (0.0, -9.81),
            materials: {{ "stone": (contact: ({contact})) }},
            specimen: Particles([(position: (0.0, {RADIUS:?}), radius: {RADIUS:?},
                velocity: (-5.0e-4, 0.0), angular_velocity: 0.05)]),
            walls: [(name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), contact: ({contact}))],
            stages: [Load(name: "swing", increments: 1)],
        )"#
    ));
    let mut simulation = Simulation::new(&scene, None);
    next(&mut simulation).unwrap();
    let mass = 2650.0 * std::f64::consts::PI * RADIUS * RADIUS;
    let omega = (2.0 / (1.5 * mass * RADIUS * RADIUS)).sqrt();
    // Implicit Euler: v_1 (1 + (omega dt)^2) = v_0.
    assert_relative(states(&mut simulation)[0].spin, 0.05 / (1.0 + (1e-3 * omega).powi(2)), EXACT);
}

/// A bond, pressed by P and turned, has tau = k_R alpha up to mu_r r (P + f_t). There it breaks, and
/// its contact keeps mu_r r P.
#[test]
fn a_bond_breaks_at_its_rolling_limit_and_leaves_the_moment_of_its_contact() {
    let (pressed, tensile, contact_friction) = (10.0, 24.0, 0.05);
    let (bond_limit, contact_limit) =
        (0.1 * RADIUS * (pressed + tensile), contact_friction * RADIUS * pressed);
    let step = bond_limit / ROLLING / 4.0;
    let strength = tensile / (2.0 * RADIUS);
    let springs = format!(
        "normal_stiffness: {NORMAL:?}, tangential_stiffness: {TANGENTIAL:?}, rolling_stiffness: {ROLLING:?}"
    );
    let scene = parse(&format!(
        r#"(
            version: 1,
            title: "bonded pair",
            materials: {{ "glue": (
                contact: ({springs}, friction: 0.6, rolling_friction: {contact_friction:?}),
                bond: ({springs}, friction: 0.6, rolling_friction: 0.1, cohesion: 1.0e6,
                    tensile_strength: {strength:?}),
            ) }},
            specimen: Particles([
                (position: (0.0, 0.0), radius: {RADIUS:?}),
                (position: ({:?}, 0.0), radius: {RADIUS:?}, probe: "disk"),
            ]),
            bonds: [(a: 0, b: 1)],
            output: (energy: true),
            stages: [
                Load(name: "press", increments: 1, particles: [
                    (select: Index([0]), x: Held, y: Held, rotation: Held),
                    (select: Index([1]), y: Held, rotation: Held, force: ({:?}, 0.0)),
                ]),
                Load(name: "turn", increments: 5, particles: [
                    (select: Index([0]), x: Held, y: Held, rotation: Held),
                    (select: Index([1]), y: Held, rotation: Displacement({step:?}), force: ({:?}, 0.0)),
                ]),
            ],
        )"#,
        2.0 * RADIUS,
        -pressed,
        -pressed
    ));
    let mut simulation = Simulation::new(&scene, None);
    let (mut records, mut totals) = (Vec::new(), Vec::new());
    while let Some(record) = next(&mut simulation) {
        records.push(record);
        totals.push(simulation.world().resource::<EnergyLedger>().total);
    }
    for (k, record) in records.iter().enumerate() {
        let expected = match k {
            0..=3 => k as f64 * step * ROLLING,
            4 => bond_limit,
            _ => contact_limit,
        };
        // The shear force has a moment about the centre as well.
        let arm = RADIUS - 0.5 * pressed / NORMAL;
        let of_shear = -arm * probe(record, "disk").force[1];
        assert_within(moment(record) - of_shear, expected, 1e-7 * bond_limit);
        assert_eq!(record.broken, if k < 4 { [0; 3] } else { [0, 0, 1] }, "{k}");
    }
    assert_eq!(records[4].ruptures[0].mode, RuptureMode::Rolling);
    let energy = |limit: f64| 0.5 * limit * limit / ROLLING;
    let lost = energy(bond_limit) - energy(contact_limit);
    assert_relative(totals[4].rupture, lost, 1e-6);
    assert_within(totals.last().unwrap().error(), 0.0, 1e-7 * lost);
}
