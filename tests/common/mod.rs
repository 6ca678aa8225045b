//! What the tests share: scenes by name or text, runs that record every increment, states of
//! particles.
#![allow(dead_code, reason = "every test program uses its own part of this")]

use std::path::Path;

use clastic::components::attempt::IncrementStatus;
use clastic::components::body::{AngularVelocity, BodyId, Position, Rotation, Velocity};
use clastic::components::observation::{Observation, ProbeReading};
use clastic::components::particle::Particle;
use clastic::run::{Outcome, Simulation, Step};
use clastic::scene;
use clastic::scene::format::{Load, Scene, Stage};
use glam::DVec2;

/// A scene from its text.
pub fn parse(text: &str) -> Scene {
    scene::from_str(text, Path::new("test.ron"), Path::new(""), &[]).unwrap_or_else(|e| panic!("{e}")).scene
}

/// A scene of `scenes/` by name.
pub fn load(name: &str) -> Scene {
    let path = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
    scene::load(Path::new(&path), &[]).unwrap_or_else(|e| panic!("{e}")).scene
}

/// The loading stage with the given name, to change it.
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

/// Runs one increment and returns its record, or nothing at the end.
///
/// # Panics
/// Where a solved increment leaves a residual above 1e-8: no test accepts one.
pub fn next(simulation: &mut Simulation) -> Option<Observation> {
    let Step::Increment = simulation.step() else { return None };
    let record = simulation.world().resource::<Observation>().clone();
    let n = record.increment;
    if record.status == IncrementStatus::Solved {
        assert!(record.residuals.worst() <= 1e-8, "increment {n}: {:?}", record.residuals);
    }
    assert_ne!(record.status, IncrementStatus::Capped, "increment {n}");
    Some(record)
}

/// Runs a scene to its end: the record of every increment, and the outcome.
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

/// States of all particles by identity.
pub fn states(simulation: &mut Simulation) -> Vec<State> {
    let world = simulation.world_mut();
    let mut query =
        world.query::<(&BodyId, &Particle, &Position, &Rotation, &Velocity, &AngularVelocity)>();
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

/// Asserts that two numbers agree to a fraction of the expected one.
#[track_caller]
pub fn assert_relative(actual: f64, expected: f64, tolerance: f64) {
    assert_within(actual, expected, tolerance * expected.abs());
}

/// Asserts that two numbers agree to an absolute tolerance.
#[track_caller]
pub fn assert_within(actual: f64, expected: f64, tolerance: f64) {
    let error = (actual - expected).abs();
    assert!(error <= tolerance, "{actual:e} instead of {expected:e}: off by {error:.2e}, accepted {tolerance:.1e}");
}
