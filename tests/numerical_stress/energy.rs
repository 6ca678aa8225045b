//! The energy ledger closes: static and dynamic, elastic and rigid, and against analytic answers.

use clastic::components::energy::{Energies, EnergyLedger};
use clastic::components::increment::{self, Acceptance, AnalysisKind};
use clastic::components::observation::Observation;
use clastic::cone::program::{ConeProgram, ConeSolution};
use clastic::cone::residuals::{displacement_scale, force_scale};
use clastic::run::Simulation;
use clastic::scene::format::{Analysis, FrictionLaw, Scene};

use crate::common::{
    ELASTIC, RIGID, ROUGH, SMOOTH, assert_relative, assert_within, load, next, parse, small_cell,
    swarm,
};

/// Bound of the error of the ledger of an increment: the accepted residual in every row and every
/// limit, and the round-off of the energies.
pub fn accepted_error(simulation: &Simulation) -> f64 {
    let world = simulation.world();
    let (program, solution) = (world.resource::<ConeProgram>(), world.resource::<ConeSolution>());
    let rows = 3 * program.bodies.len() + 4 * program.interactions.len();
    // Undetermined forces between held bodies count here, because they do work too.
    let maximum = solution.forces.iter().map(|f| f[0].abs().max(f[1].abs())).fold(0.0, f64::max);
    let force = force_scale(program, &solution.forces).max(maximum);
    // A static residual of moments does its work on rotations; in dynamics balance holds to
    // round-off.
    let is_static = world.resource::<increment::ClasticAnalysis>().kind == AnalysisKind::Static;
    let turns = solution.displacements.iter().filter(|_| is_static).map(|u| u[2].abs());
    let turn = turns.fold(0.0, f64::max) * program.scales.length;
    let motion = displacement_scale(program, &solution.displacements).max(turn);
    let record = world.resource::<Observation>();
    let kinetic = record.kinetic_energy;
    let e = world.resource::<EnergyLedger>();
    // A capped increment reports its residual.
    let residual = world.resource::<Acceptance>().residual.max(record.residuals.worst());
    // The last term: round-off of fast bodies whose speed hardly changes.
    residual * rows as f64 * force * motion
        + 1e-12 * (e.increment.throughput() + e.stored.unwrap_or_default())
        + 1e-14 * kinetic
}

/// Runs a scene with its ledger; every increment must close. Returns the increments' energies.
fn ledger(scene: &Scene) -> Vec<Energies> {
    let mut scene = scene.clone();
    scene.output.energy = true;
    let mut simulation = Simulation::new(&scene, None);
    let mut rows = Vec::new();
    while let Some(record) = next(&mut simulation) {
        let e = simulation.world().resource::<EnergyLedger>().increment;
        let accepted = accepted_error(&simulation);
        let n = record.increment;
        assert!(e.error().abs() <= accepted, "{}, {n}: {:e} of {e:?}", scene.title, e.error());
        rows.push(e);
    }
    rows
}

fn sum(rows: &[Energies]) -> Energies {
    rows.iter().fold(Energies::default(), |mut sum, e| {
        sum += *e;
        sum
    })
}

#[test]
fn ledger_closes_in_a_static_specimen_that_breaks() {
    for (wall, grain) in [(SMOOTH, ROUGH), (ROUGH, ROUGH)] {
        let mut scene = small_cell(wall, grain);
        let bond = scene.materials.get_mut("sand").unwrap().bond.as_mut().unwrap();
        (bond.cohesion, bond.tensile_strength) = (50e3, 25e3);
        let total = sum(&ledger(&scene));
        assert!(total.external > 0.0 && total.rupture > 0.0 && total.friction > 0.0, "{total:?}");
    }
}

#[test]
fn ledger_closes_in_colliding_swarms() {
    let coulomb = "Coulomb()";
    for law in ["Associated", coulomb] {
        for contact in [RIGID, ELASTIC] {
            for theta in [0.5, 0.7, 1.0] {
                let total = sum(&ledger(&swarm(law, contact, 2e-4, theta, 60)));
                assert!(total.friction > 0.0 && total.kinetic < 0.0);
                assert_within(total.external, 0.0, 0.0);
                if law == coulomb || contact == RIGID {
                    assert_within(total.dilation, 0.0, 1e-6 * total.friction);
                }
                if contact == ELASTIC {
                    // Springs give back what they take: their error is no loss.
                    assert_within(total.collision, 0.0, 0.0);
                }
                if contact == RIGID {
                    // Impulses take all of it, exactly: there are no loads.
                    let taken = total.friction + total.rolling + total.collision;
                    assert_relative(taken, -total.kinetic, 1e-12);
                    assert_within(total.numerical, 0.0, 1e-12 * taken);
                    assert!(law != coulomb || total.collision > 0.0, "{total:?}");
                }
            }
        }
    }
}

#[test]
fn ledger_closes_where_disks_roll_slip_bounce_and_rest() {
    let scenes = ["bounce", "incline_rolls", "incline_slips", "incline_rests", "stack", "tension"];
    for name in scenes {
        let total = sum(&ledger(&load(name)));
        assert!(total.throughput() > 0.0, "{name}");
    }
}

/// Coulomb friction takes mu m g cos b times the slip, gravity gives m g sin b times the way.
#[test]
fn friction_of_a_sliding_block_is_its_force_times_its_way() {
    let (sin, cos, friction) = (0.6, 0.8, 0.3);
    let mut scene = load("incline_held");
    scene.walls[0].contact.friction = friction;
    scene.friction_law = FrictionLaw::COULOMB;
    scene.analysis = Analysis::Dynamic { dt: 1e-3, theta: 0.5 };
    let total = sum(&ledger(&scene));
    assert_relative(total.friction, friction * cos / sin * total.gravity, 1e-9);
    let acceleration = sin - friction * cos;
    assert_relative(total.kinetic, acceleration / sin * total.gravity, 1e-9);
    assert_within(total.numerical, 0.0, 1e-9 * total.gravity);
    assert!(total.kinetic > 0.0);
}

/// A disk that cannot roll is thrown along a rough floor, or driven along it. Friction takes mu m g
/// times its way: by Coulomb's law in every step, and by the associated law, which makes it hop,
/// over the hops.
fn slide(law: &str, analysis: &str, drive: &str, increments: u32) -> Energies {
    let scene = parse(&format!(
        "(
            version: 1,
            title: \"sliding block, {law}, {analysis}\",
            analysis: {analysis},
            friction_law: {law},
            gravity: (0.0, -10.0),
            materials: {{ \"stone\": () }},
            specimen: Particles([(position: (0.0, 0.01), radius: 0.01, velocity: (0.5, 0.0))]),
            walls: [(name: \"floor\", start: (-1.0, 0.0), end: (1.0, 0.0), contact: (friction: 0.3))],
            stages: [Load(name: \"slide\", increments: {increments},
                particles: [(select: All, rotation: Held{drive})])],
        )"
    ));
    sum(&ledger(&scene))
}

#[test]
fn a_block_that_slides_to_rest_loses_its_energy_to_friction() {
    let mass = 2650.0 * std::f64::consts::PI * 1e-4;
    let start = 0.5 * mass * 0.25;
    for theta in ["0.5", "1.0"] {
        let analysis = format!("Dynamic(dt: 1.0e-3, theta: {theta})");
        let total = slide("Coulomb()", &analysis, "", 400);
        assert_relative(total.friction, -total.kinetic, 1e-9);
        // With theta = 1/2 a disk that sticks keeps a speed of at most mu g dt from its last step.
        assert_within(total.kinetic, -start, (3e-3_f64 / 0.5).powi(2) * start);
        assert_within(total.collision, 0.0, 1e-9 * start);
        assert_within(total.numerical, 0.0, 1e-9 * start);
    }
    // The friction loss is smaller by the kinetic energy of the last hop: its vertical speed is at
    // most mu v.
    let total = slide("Associated", "Dynamic(dt: 1.0e-4, theta: 1.0)", "", 4000);
    println!("{total:?}");
    assert_relative(total.friction, start, 0.02);
    assert_within(total.collision, 0.0, 0.02 * start);
    assert_within(total.numerical, 0.0, 1e-3 * start);
    assert_within(total.kinetic, -start, 1e-2 * start);
}

#[test]
fn a_block_that_is_driven_loses_its_friction_times_its_way() {
    let weight = 2650.0 * std::f64::consts::PI * 1e-4 * 10.0;
    let way = 50.0 * 1e-4;
    for law in ["Coulomb()", "Associated"] {
        let total = slide(law, "Static", ", x: Displacement(1.0e-4)", 50);
        println!("{law}: {total:?}");
        assert_relative(total.friction, 0.3 * weight * way, 1e-8);
        assert_relative(total.external, 0.3 * weight * way, 1e-8);
        assert_within(total.numerical, 0.0, 1e-8 * total.external);
        // The gap of the last increment is still open, and the block is lifted by it.
        let lifted = if law == "Associated" { 0.3 * 1e-4 * weight } else { 0.0 };
        assert_within(total.dilation + lifted, 0.0, 1e-8 * total.external);
        assert_within(total.gravity + lifted, 0.0, 1e-8 * total.external);
    }
}

/// Two rigid disks meet head on: with theta = 1 their kinetic energy is gone.
#[test]
fn a_plastic_impact_takes_the_kinetic_energy() {
    let scene = parse(
        "(
            version: 1,
            title: \"head on\",
            analysis: Dynamic(dt: 1.0e-3, theta: 1.0),
            materials: { \"stone\": () },
            specimen: Particles([
                (position: (-0.0123, 0.0), radius: 0.01, velocity: (1.0, 0.0)),
                (position: (0.0123, 0.0), radius: 0.01, velocity: (-1.0, 0.0)),
            ]),
            stages: [Load(name: \"fly\", increments: 10)],
        )",
    );
    let start = 2650.0 * std::f64::consts::PI * 1e-4;
    let total = sum(&ledger(&scene));
    assert_relative(total.kinetic, -start, 1e-12);
    assert_relative(total.collision, start, 1e-12);
    assert_within(total.numerical, 0.0, 1e-12 * start);
}

/// `bounce`: the impact of increment 101 turns -v to 2/3 v. Its impulse is that of the jump and of
/// the weight.
#[test]
fn a_collision_takes_the_impulse_times_the_mean_velocity() {
    let rows = ledger(&load("bounce"));
    let mass = 2650.0 * std::f64::consts::PI * 1e-4;
    let (v, kick) = (0.981, 9.81e-3);
    let impulse = mass * (5.0 / 3.0 * v + kick);
    assert_relative(rows[100].collision, impulse * v / 6.0, 1e-9);
    assert_within(rows[..100].iter().map(|e| e.collision).sum(), 0.0, 1e-12);
}

/// The part of the work that the ledger does not attribute is small.
#[test]
fn little_of_the_work_is_numerical() {
    for name in [
        "bounce",
        "incline_rolls",
        "incline_slips",
        "rolling",
        "lattice",
        "tension",
        "direct_shear_-10N",
        "direct_shear_0N",
        "direct_shear_10N",
    ] {
        let total = sum(&ledger(&load(name)));
        let work = total.external + total.gravity;
        assert!(total.numerical.abs() < 0.02 * work, "{name}: {total:?}");
    }
}

/// 4.1: a bond of 8 MN/m takes 24 N to 3 um and breaks; the elastic energy goes with it.
#[test]
fn a_bond_that_breaks_takes_its_elastic_energy() {
    let total = sum(&ledger(&load("tension")));
    let stored = 0.5 * 24.0 * 3e-6;
    assert!(total.rupture >= stored * (1.0 - 1e-9), "{:e} of {stored:e}", total.rupture);
    // Driven beyond its limit within the increment it pulls with 24 N: at most one increment more.
    assert!(total.rupture <= stored + 24.0 * 1e-6, "{:e}", total.rupture);
    assert_within(total.elastic, 0.0, 1e-9 * stored);
}

/// Two bonded disks on a line: normals stand still.
fn oscillator(theta: f64) -> Scene {
    parse(&format!(
        "(
            version: 1,
            title: \"oscillator, theta {theta}\",
            analysis: Dynamic(dt: 1.0e-5, theta: {theta:?}),
            materials: {{ \"stone\": (
                contact: (normal_stiffness: 8.0e6),
                bond: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6, cohesion: 1.0e9, tensile_strength: 1.0e9),
            ) }},
            specimen: Particles([
                (position: (0.0, 0.0), radius: 6.0e-3, velocity: (0.05, 0.0)),
                (position: (12.0e-3, 0.0), radius: 6.0e-3, velocity: (-0.05, 0.0)),
            ]),
            bonds: [(a: 0, b: 1)],
            stages: [Load(name: \"free\", increments: 500)],
        )"
    ))
}

#[test]
fn smooth_elastic_energy_is_kept_at_one_half_and_never_gained_above() {
    let start = 2650.0 * std::f64::consts::PI * 36e-6 * 0.05 * 0.05;
    for theta in [0.5, 0.6, 0.8, 1.0] {
        let rows = ledger(&oscillator(theta));
        assert_eq!(rows.len(), 500);
        for e in &rows {
            if theta == 0.5 {
                assert_within(e.numerical, 0.0, 1e-12 * start);
            } else {
                assert!(e.numerical >= 0.0, "theta {theta}: {e:?}");
            }
        }
        let total = sum(&rows);
        assert_within(total.kinetic + total.elastic + total.numerical, 0.0, 1e-10 * start);
        if theta == 0.5 {
            assert_within(total.kinetic + total.elastic, 0.0, 1e-10 * start);
        } else {
            assert!(total.numerical > 0.01 * start, "theta {theta}: {total:?}");
        }
    }
}

/// With turning normals the energy at theta = 1/2 has the error of constant normals.
#[test]
fn a_turning_lattice_keeps_its_energy_as_the_increment_vanishes() {
    let gained = |n: u32| {
        let scene = crate::common::wheel(0.02 / f64::from(n), 0.5, n);
        let total = sum(&ledger(&scene));
        assert_within(total.friction.abs() + total.rupture.abs(), 0.0, 1e-12);
        -(total.turning + total.numerical)
    };
    let (coarse, fine) = (gained(100), gained(200));
    assert!(coarse.abs() > 0.0 && fine.abs() <= 0.55 * coarse.abs(), "{coarse:e}, {fine:e}");
}

/// The reaction of a driven disk is its mass times the change of its velocity over the increment,
/// whatever theta: it was divided by theta.
#[test]
fn force_of_a_driven_disk_is_its_change_of_momentum() {
    for theta in [0.5, 1.0] {
        let scene = parse(&format!(
            "(
                version: 1,
                title: \"driven disk\",
                analysis: Dynamic(dt: 1.0e-3, theta: {theta:?}),
                materials: {{ \"stone\": () }},
                specimen: Particles([(position: (0.0, 0.0), radius: 0.01, probe: \"disk\")]),
                stages: [Load(name: \"drive\", increments: 3, particles: [(select: All, x: Velocity(2.0))])],
            )"
        ));
        let mut simulation = Simulation::new(&scene, None);
        let mass = 2650.0 * std::f64::consts::PI * 1e-4;
        for expected in [mass * 2.0 / 1e-3, 0.0, 0.0] {
            let record = next(&mut simulation).unwrap();
            assert_within(record.probes[0].force[0], expected, 1e-9 * mass * 2.0 / 1e-3);
        }
        let rows = ledger(&scene);
        assert_relative(rows[0].kinetic, 0.5 * mass * 4.0, 1e-12);
        // The blow that sets it in motion does its work at the mean velocity.
        assert_relative(rows[0].external, 0.5 * mass * 4.0, 1e-12);
    }
}
