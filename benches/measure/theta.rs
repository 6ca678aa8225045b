//! Order of the theta-method with averaged elastic forces, observed on a smooth linear problem: a
//! free chain of bonded disks of which the first one is struck along the chain.
//!
//! With n disks of mass m and n - 1 bonds of stiffness k the modes are
//! `phi_j(i) = cos(j pi (i + 1/2)/n)`, the frequencies `w_j = 2 sqrt(k/m) sin(j pi/(2 n))`, and
//! disk i moves by `v/n (t + 2 sum_j phi_j(0) phi_j(i) sin(w_j t)/w_j)`.

use std::f64::consts::PI;
use std::path::Path;

use crate::chart::{Chart, Line};
use bevy_ecs::prelude::*;
use clastic::components::body::{BodyId, BodyOrigin, BodyPosition};
use clastic::components::particle::Particle;
use clastic::run::{Outcome, Simulation};
use clastic::scene::{LoadedScene, from_str};

use crate::BenchError;
use crate::table::{Part, Table};

/// Disks of the chain.
const DISKS: u32 = 8;
/// Radius, m; density, kg/m^3; stiffness, N/m.
const RADIUS: f64 = 5e-3;
const DENSITY: f64 = 2650.0;
const STIFFNESS: f64 = 1e7;
/// Speed of the first disk over the speed of waves, so small that nothing but the bonds acts.
const SPEED: f64 = 1e-4;
/// Time that is computed, over sqrt(m/k).
const TIME: f64 = 6.0;
/// Increments of the coarsest run, and number of times that they are doubled.
const COARSEST: u32 = 50;
const DOUBLINGS: u32 = 5;

/// Values of theta with the expected order.
const ORDERS: [(f64, f64); 4] = [(0.5, 2.0), (0.6, 1.0), (0.75, 1.0), (1.0, 1.0)];

/// sqrt(k/m), 1/s.
fn frequency() -> f64 {
    (STIFFNESS / (DENSITY * PI * RADIUS * RADIUS)).sqrt()
}

/// Runs this part.
///
/// # Errors
/// Where a run does not come to its end.
pub fn run() -> Result<Part, BenchError> {
    let mut table = Table::new(
        "theta",
        "Error of the theta-method on a chain of eight bonded disks",
        &["theta", "increments", "w_dt", "error", "observed_order", "expected_order"],
    );
    let mut lines = Vec::new();
    for (theta, expected) in ORDERS {
        let mut before: Option<f64> = None;
        let mut line = Line { name: format!("theta = {theta}"), points: Vec::new() };
        for n in (0..=DOUBLINGS).map(|k| COARSEST << k) {
            let error = error(theta, n)?;
            let step = TIME / f64::from(n);
            let order = before.map(|before| (before / error).log2());
            table.rows.push(vec![
                theta.into(),
                n.into(),
                step.into(),
                error.into(),
                order.into(),
                expected.into(),
            ]);
            line.points.push((step.log10(), error.log10()));
            before = Some(error);
        }
        lines.push(line);
    }
    let text = "Error of the displacement at sqrt(k/m) t = 6: root mean square over the disks, \
        over that of the exact displacement. `w_dt` is sqrt(k/m) dt. The observed order \
        is log2 of the error over the error with twice the increments.";
    let chart = Chart {
        title: "Order of the theta-method".to_owned(),
        caption: "chain of eight bonded disks, the first one struck".to_owned(),
        x: "log10 of sqrt(k/m) dt".to_owned(),
        y: "log10 of the error".to_owned(),
        lines,
    };
    Ok(Part {
        name: "theta",
        text: text.to_owned(),
        tables: vec![table],
        charts: vec![("theta".to_owned(), chart)],
    })
}

fn scene(theta: f64, increments: u32) -> Result<LoadedScene, BenchError> {
    let dt = TIME / f64::from(increments) / frequency();
    let speed = SPEED * RADIUS * frequency();
    let disks: String = (0..DISKS)
        .map(|i| {
            let x = 2.0 * RADIUS * f64::from(i);
            let v = if i == 0 { speed } else { 0.0 };
            format!("(position: ({x:?}, 0.0), radius: {RADIUS:?}, velocity: ({v:?}, 0.0)),")
        })
        .collect();
    let bonds: String = (1..DISKS).map(|i| format!("(a: {}, b: {i}),", i - 1)).collect();
    let text = format!(
        "(
            version: 1,
            title: \"struck chain\",
            analysis: Dynamic(dt: {dt:?}, theta: {theta:?}),
            materials: {{ \"steel\": (
                density: {DENSITY:?},
                bond: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?},
                    friction: 0.5, cohesion: 1.0e9, tensile_strength: 1.0e9),
            ) }},
            specimen: Particles([{disks}]),
            bonds: [{bonds}],
            stages: [Load(name: \"free\", increments: {increments})],
        )"
    );
    Ok(from_str(&text, Path::new("chain.ron"), Path::new(""), &[])?)
}

/// Exact displacement of disk i at the end, over v sqrt(m/k).
fn exact(i: u32) -> f64 {
    let n = f64::from(DISKS);
    let mode = |j: f64, i: u32| (j * PI * (f64::from(i) + 0.5) / n).cos();
    let sum: f64 = (1..DISKS)
        .map(|j| {
            let j = f64::from(j);
            let w = 2.0 * (0.5 * j * PI / n).sin();
            mode(j, 0) * mode(j, i) * (w * TIME).sin() / w
        })
        .sum();
    (TIME + 2.0 * sum) / n
}

/// Relative error of the displacements at the end.
fn error(theta: f64, increments: u32) -> Result<f64, BenchError> {
    let loaded = scene(theta, increments)?;
    let mut simulation = Simulation::new(&loaded.scene, None);
    let outcome = simulation.run();
    if outcome != Outcome::Completed {
        return Err(BenchError::Run(format!("the struck chain ended with {outcome:?}")));
    }
    let unit = SPEED * RADIUS;
    let world = simulation.world_mut();
    let mut disks = world.query_filtered::<(&BodyId, &BodyPosition, &BodyOrigin), With<Particle>>();
    let mut rows: Vec<_> = disks
        .iter(world)
        .map(|(id, x, x0)| ((x.0 - x0.0).x / unit - exact(id.0), exact(id.0), id.0))
        .collect();
    rows.sort_by_key(|row| row.2);
    let square =
        |f: &dyn Fn(&(f64, f64, u32)) -> f64| rows.iter().map(|r| f(r).powi(2)).sum::<f64>();
    Ok((square(&|r| r.0) / square(&|r| r.1)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_orders_are_those_expected() -> Result<(), BenchError> {
        for (theta, expected) in ORDERS {
            let order = (error(theta, 400)? / error(theta, 800)?).log2();
            assert!((order - expected).abs() < 0.05, "theta {theta}: {order}");
        }
        Ok(())
    }
}
