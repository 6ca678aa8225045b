//! Shared parts of the tests: scenes by name or text, runs that record every increment, and states
//! of particles.
#![allow(dead_code, reason = "every test program uses its own part of this")]

pub mod programs;
pub mod random;
pub mod settings;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clastic::components::attempt::IncrementStatus;
use clastic::components::body::{
    BodyAngularVelocity, BodyId, BodyPosition, BodyRotation, BodyVelocity,
};
use clastic::components::increment::Acceptance;
use clastic::components::observation::{Observation, ProbeReading};
use clastic::components::particle::Particle;
use clastic::run::{Outcome, Simulation, Step};
use clastic::scene;
use clastic::scene::format::{Load, Scene, Stage};
use glam::DVec2;

/// A scene from its text.
pub fn parse(text: &str) -> Scene {
    scene::from_str(text, Path::new("test.ron"), Path::new(""), &[])
        .unwrap_or_else(|e| panic!("{e}"))
        .scene
}

/// A scene of `scenes/` by name.
pub fn load(name: &str) -> Scene {
    let path = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
    scene::load(Path::new(&path), &[]).unwrap_or_else(|e| panic!("{e}")).scene
}

/// A scene of `scenes/` by name, with its specimen file.
pub fn load_with_specimen(name: &str) -> scene::LoadedScene {
    let path = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
    scene::load(Path::new(&path), &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// The loading stage with the given name, for changes.
pub fn stage<'a>(scene: &'a mut Scene, name: &str) -> &'a mut Load {
    scene
        .stages
        .iter_mut()
        .find_map(|s| match s {
            Stage::Load(load) if load.name == name => Some(load),
            _ => None,
        })
        .unwrap()
}

/// Runs one increment and returns its record, whatever its status; `None` at the end of the run.
pub fn step(simulation: &mut Simulation) -> Option<Observation> {
    let Step::Increment = simulation.step() else { return None };
    Some(simulation.world().resource::<Observation>().clone())
}

/// Runs one increment and returns its record; `None` at the end of the run.
///
/// # Panics
/// If an increment is neither solved nor collapsed, or has a residual above the accepted one, 1e-8 by
/// default.
pub fn next(simulation: &mut Simulation) -> Option<Observation> {
    let record = step(simulation)?;
    let n = record.increment;
    if record.status == IncrementStatus::Solved {
        let accepted = simulation.world().resource::<Acceptance>().residual;
        assert!(record.residuals.worst() <= accepted, "increment {n}: {:?}", record.residuals);
    }
    let fine = [IncrementStatus::Solved, IncrementStatus::Collapsed].contains(&record.status);
    assert!(fine, "increment {n} {}", record.status.name());
    Some(record)
}

/// Runs a scene to its end. Returns the record of every increment, and the outcome.
pub fn run(scene: &Scene) -> (Vec<Observation>, Outcome) {
    let mut simulation = Simulation::new(scene, None);
    let records = std::iter::from_fn(|| next(&mut simulation)).collect();
    (records, simulation.run())
}

/// The reading of a probe.
pub fn probe<'a>(record: &'a Observation, name: &str) -> &'a ProbeReading {
    record.probes.iter().find(|p| p.name == name).unwrap()
}

/// State of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    pub position: DVec2,
    pub rotation: f64,
    pub velocity: DVec2,
    pub spin: f64,
    pub radius: f64,
    pub mass: f64,
    pub inertia: f64,
}

/// States of all particles in the order of identities.
pub fn states(simulation: &mut Simulation) -> Vec<State> {
    let world = simulation.world_mut();
    let mut query = world.query::<(
        &BodyId,
        &Particle,
        &BodyPosition,
        &BodyRotation,
        &BodyVelocity,
        &BodyAngularVelocity,
    )>();
    let mut rows: Vec<_> = query
        .iter(world)
        .map(|(id, p, x, rotation, v, spin)| {
            let state = State {
                position: x.0,
                rotation: rotation.0,
                velocity: v.0,
                spin: spin.0,
                radius: p.radius,
                mass: p.mass,
                inertia: p.inertia,
            };
            (*id, state)
        })
        .collect();
    rows.sort_by_key(|(id, _)| *id);
    rows.into_iter().map(|(_, state)| state).collect()
}

/// Asserts that two numbers agree within a fraction of the expected one.
#[track_caller]
pub fn assert_relative(actual: f64, expected: f64, tolerance: f64) {
    assert_within(actual, expected, tolerance * expected.abs());
}

/// Asserts that two numbers agree within an absolute tolerance.
#[track_caller]
pub fn assert_within(actual: f64, expected: f64, tolerance: f64) {
    let error = (actual - expected).abs();
    assert!(
        error <= tolerance,
        "{actual:e} instead of {expected:e}: off by {error:.2e}, accepted {tolerance:.1e}"
    );
}

/// A cemented specimen of 60 disks in a biaxial cell, which is prepared, confined and loaded within
/// a second. `wall` and `grain` are inserted into the contact laws of walls and of grains.
pub fn small_cell(wall: &str, grain: &str) -> Scene {
    parse(&format!(
        "(
            version: 1,
            title: \"cell of 60 disks\",
            rupture: (rolling: Yields),
            materials: {{ \"sand\": (
                contact: ({grain}),
                bond: (normal_stiffness: 60.0e6, tangential_stiffness: 30.0e6, friction: 0.5,
                    rolling_friction: 0.1, cohesion: 200.0e3, tensile_strength: 100.0e3),
            ) }},
            specimen: Packing(count: 60, columns: 6, spacing: 10.0e-3, origin: (1.0e-3, 0.0),
                sizes: Uniform(radius: (3.0e-3, 5.0e-3)), seed: 3),
            walls: [
                (name: \"bottom\", start: (0.0, 0.0), end: (0.062, 0.0), probe: \"bottom\", contact: ({wall})),
                (name: \"top\", start: (0.062, 0.1), end: (0.0, 0.1), probe: \"top\", contact: ({wall})),
                (name: \"left\", start: (0.0, 0.1), end: (0.0, 0.0), probe: \"left\", contact: ({wall})),
                (name: \"right\", start: (0.062, 0.0), end: (0.062, 0.1), probe: \"right\", contact: ({wall})),
            ],
            stages: [
                Compact(name: \"compact\", wall: \"top\", base: \"bottom\", target: Porosity(0.24),
                    step: 4.0e-3, agitation: 0.1, seed: 1),
                Cement(name: \"cement\", length: 0.4e-3),
                Load(name: \"confine\", increments: 5, walls: {{
                    \"bottom\": Stress(stress: 200.0e3, between: (\"left\", \"right\")),
                    \"top\": Stress(stress: 200.0e3, between: (\"left\", \"right\")),
                    \"left\": Stress(stress: 200.0e3, between: (\"bottom\", \"top\")),
                    \"right\": Stress(stress: 200.0e3, between: (\"bottom\", \"top\")),
                }}),
                Load(name: \"load\", increments: 30, walls: {{
                    \"bottom\": Displacement(0.0, 0.01e-3),
                    \"top\": Displacement(0.0, -0.01e-3),
                }}),
            ],
            measures: [
                (name: \"axial_strain\", of: Strain(Walls(\"bottom\", \"top\"))),
                (name: \"lateral_strain\", of: Strain(Walls(\"left\", \"right\"))),
                (name: \"axial_stress\", of: Stress(Average(component: Yy, area: Box((\"bottom\", \"top\"), (\"left\", \"right\"))))),
                (name: \"lateral_stress\", of: Stress(Average(component: Xx, area: Box((\"bottom\", \"top\"), (\"left\", \"right\"))))),
            ],
        )"
    ))
}

/// Contact laws of the small cell: elastic without friction, and with friction.
pub const SMOOTH: &str = "normal_stiffness: 60.0e6, tangential_stiffness: 30.0e6";
pub const ROUGH: &str = "normal_stiffness: 60.0e6, tangential_stiffness: 30.0e6, friction: 0.3";

/// Nineteen rotating disks of three sizes on a jittered hexagonal grid fly into each other.
pub fn swarm(law: &str, contact: &str, dt: f64, theta: f64, increments: u32) -> Scene {
    let mut disks = String::new();
    let mut k = 0;
    for row in -2_i32..=2 {
        for column in 0..(5 - row.abs()) {
            let x = 0.021 * (f64::from(column) - 0.5 * f64::from(4 - row.abs()));
            let y = 0.021 * 0.75_f64.sqrt() * f64::from(row);
            // Any deterministic disorder is suitable.
            let wiggle = |p: f64| 4e-4 * (p * f64::from(k + 1)).sin();
            let (x, y) = (x + wiggle(12.9), y + wiggle(78.2));
            let radius = 0.01 - 4e-4 * f64::from(k % 3);
            let (vx, vy) = (-20.0 * x + 0.3 * wiggle(3.7) * 1e3, -20.0 * y + 8.0 * x);
            let spin = 3e4 * wiggle(5.3);
            disks += &format!(
                "(position: ({x:?}, {y:?}), radius: {radius:?}, velocity: ({vx:?}, {vy:?}), angular_velocity: {spin:?}),"
            );
            k += 1;
        }
    }
    parse(&format!(
        "(
            version: 1,
            title: \"swarm\",
            analysis: Dynamic(dt: {dt:?}, theta: {theta:?}),
            friction_law: {law},
            materials: {{ \"stone\": (contact: ({contact})) }},
            specimen: Particles([{disks}]),
            stages: [Load(name: \"free\", increments: {increments})],
        )"
    ))
}

/// Contact laws of a swarm.
pub const RIGID: &str = "friction: 0.4, rolling_friction: 0.05";
pub const ELASTIC: &str =
    "normal_stiffness: 1.0e7, tangential_stiffness: 5.0e6, friction: 0.4, rolling_friction: 0.05";

/// Seven bonded disks that rotate about their centre. The motion is smooth, so an order of
/// convergence is visible.
pub fn wheel(dt: f64, theta: f64, increments: u32) -> Scene {
    let spin = 10.0;
    let (mut disks, mut bonds) = (String::new(), String::new());
    for k in 0..7_u32 {
        let at = if k == 0 {
            DVec2::ZERO
        } else {
            0.02 * DVec2::from_angle(f64::from(k) * std::f64::consts::FRAC_PI_3)
        };
        let v = spin * at.perp();
        disks += &format!(
            "(position: ({:?}, {:?}), radius: 0.01, velocity: ({:?}, {:?}), angular_velocity: {spin:?}),",
            at.x, at.y, v.x, v.y
        );
        if k > 0 {
            bonds += &format!("(a: 0, b: {k}), (a: {k}, b: {}),", k % 6 + 1);
        }
    }
    parse(&format!(
        "(
            version: 1,
            title: \"wheel\",
            analysis: Dynamic(dt: {dt:?}, theta: {theta:?}),
            materials: {{ \"stone\": (bond: (normal_stiffness: 1.0e6, tangential_stiffness: 5.0e5, friction: 0.5,
                cohesion: 1.0e9, tensile_strength: 1.0e9)) }},
            specimen: Particles([{disks}]),
            bonds: [{bonds}],
            stages: [Load(name: \"turn\", increments: {increments})],
        )"
    ))
}

/// All files below a directory except the timings.
pub fn files(directory: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut left = vec![directory.to_owned()];
    while let Some(next) = left.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                left.push(path);
            } else if !path.ends_with("timings.csv") {
                let name = path.strip_prefix(directory).unwrap().to_owned();
                found.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// Momentum, and angular momentum about the origin.
pub fn momentum(states: &[State]) -> (DVec2, f64) {
    (
        states.iter().map(|s| s.mass * s.velocity).sum(),
        states.iter().map(|s| s.mass * s.position.perp_dot(s.velocity) + s.inertia * s.spin).sum(),
    )
}

/// Scales of momentum and angular momentum: sums of absolute values.
pub fn momentum_scales(states: &[State]) -> (f64, f64) {
    (
        states.iter().map(|s| s.mass * s.velocity.length()).sum(),
        states
            .iter()
            .map(|s| s.mass * s.position.length() * s.velocity.length() + s.inertia * s.spin.abs())
            .sum(),
    )
}

/// A disk is pulled away from another one. Both have 12 mm, and two smaller disks hold them
/// together. All springs have 10 MN/m. Only the middle disk moves freely, and only along x.
///
/// With both small disks the middle disk moves by a third of the displacement U of the pulled disk,
/// and with one of them by half of it. A bond at 30 degrees carries k u cos 30. The bond of the 3
/// mm disk (12 N) breaks at U = 4.16 um. The bond of the 3.6 mm disk then carries more than its
/// strength of 14.4 N.
pub fn fork_scene(rules: &str, increments: u32, pull: &str) -> Scene {
    let (cosine, sine) = (0.75_f64.sqrt(), 0.5);
    let small = |r: f64, sign: f64| {
        let d = 12e-3 + r;
        format!("(position: ({:?}, {:?}), radius: {r:?})", -d * cosine, sign * d * sine)
    };
    parse(&format!(
            "(
                version: 1,
                title: \"fork\",
                rupture: ({rules}),
                materials: {{ \"glue\": (
                    contact: (normal_stiffness: 1.0e7),
                    bond: (normal_stiffness: 1.0e7, tangential_stiffness: 1.0e7, cohesion: 1.0e9, tensile_strength: 2.0e3),
                ) }},
                specimen: Particles([
                    (position: (24.0e-3, 0.0), radius: 12.0e-3, probe: \"pulled\"),
                    (position: (0.0, 0.0), radius: 12.0e-3, probe: \"middle\"),
                    {}, {},
                ]),
                bonds: [(a: 0, b: 1), (a: 1, b: 2), (a: 1, b: 3)],
                stages: [Load(name: \"pull\", increments: {increments}, particles: [
                    (select: Index([0, 1]), y: Held, rotation: Held),
                    (select: Index([2, 3]), x: Held, y: Held, rotation: Held),
                    (select: Index([0]), {pull}),
                ])],
            )",
            small(3e-3, 1.0),
            small(3.6e-3, -1.0),
    ))
}
