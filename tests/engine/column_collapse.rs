//! A column of rigid frictional disks that collapses: energy, and the published scaling laws.

use std::f64::consts::PI;

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::run::Simulation;
use clastic::scene::format::{FrictionLaw, Scene};

const G: f64 = 9.81;

/// Run-out of the pile from the back wall, m: stray grains further than half a mean diameter ahead
/// of what lies behind them do not belong to it.
fn front(states: &[State]) -> f64 {
    let mut spans: Vec<_> =
        states.iter().map(|s| (s.position.x - s.radius, s.position.x + s.radius)).collect();
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut reach = 0.0_f64;
    for (from, to) in spans {
        if from > reach + 5e-3 {
            break;
        }
        reach = reach.max(to);
    }
    reach
}

fn height(states: &[State]) -> f64 {
    states.iter().map(|s| s.position.y + s.radius).fold(0.0, f64::max)
}

#[test]
fn column_collapse_loses_energy_and_spreads_as_published() {
    let mut exact = load("column_collapse_small");
    exact.friction_law = FrictionLaw::Associated;
    exact.acceptance.residual = 1e-8;
    loses_energy_and_spreads(&exact, 1e-9);
}

/// The scene as it ships: Coulomb's law to a residual of 1e-4.
#[test]
fn column_collapse_under_coulomb_loses_energy_and_spreads_as_published() {
    loses_energy_and_spreads(&load("column_collapse_small"), 1e-5);
}

/// No increment gives more energy than the part `gain` of that at the start.
fn loses_energy_and_spreads(scene: &Scene, gain: f64) {
    let mut simulation = Simulation::new(scene, None);
    let width = 0.12;
    let mut column = 0.0;
    let mut before = f64::INFINITY;
    let mut start = 0.0;
    let (mut increments, mut solves) = (0, 0);
    while let Some(record) = next(&mut simulation) {
        let now = states(&mut simulation);
        if record.stage == "compact" {
            continue;
        }
        increments += 1;
        solves += record.solves;
        // Plastic impacts, friction, and contacts that close from apart: nothing gives energy.
        let energy: f64 = now
            .iter()
            .map(|s| {
                let kinetic = s.mass * s.velocity.length_squared() + s.inertia * s.spin * s.spin;
                0.5 * kinetic + s.mass * G * s.position.y
            })
            .sum();
        if start == 0.0 {
            start = energy;
        }
        assert!(
            energy <= before + gain * start,
            "increment {}: {before} to {energy}",
            record.increment
        );
        before = energy;
        if record.stage == "settle" {
            column = height(&now);
        }
    }
    // Bodies that are hit may hit others: these pairs are in the program from the start. Without
    // them every fifth increment would be solved twice.
    assert!(20 * solves <= 21 * increments, "{solves} solves in {increments} increments");
    let end = states(&mut simulation);
    let aspect = column / width;
    assert_within(aspect, 2.0, 0.1);
    // Published factors depend on friction and on how the front is told from stray grains; three
    // hundred grains are few. Laws of two groups: 3.25 a^0.7 and 3.8 a^0.73; 1.42 a^(2/3).
    let run_out = front(&end) / width - 1.0;
    let slump = column / height(&end);
    assert!(
        (0.7 * 3.25 * aspect.powf(0.7)..1.3 * 3.8 * aspect.powf(0.73)).contains(&run_out),
        "{run_out}"
    );
    let law = 1.42 * aspect.powf(2.0 / 3.0);
    assert!((0.75 * law..1.25 * law).contains(&slump), "{slump} instead of {law}");
}

/// A column of 500 disks with the aspect ratio `a` = h0/d0, and its width, m.
fn column(a: f64, seed: u64) -> (Scene, f64) {
    // 500 disks of 10 mm and a porosity of 0.2.
    let width = (500.0 * PI * 25.3e-6 / 0.8 / a).sqrt();
    let columns = (width / 12.5e-3) as usize;
    let origin = 0.5 * (width - columns as f64 * 12.5e-3);
    let top = 12.5e-3 * 500_f64.div_euclid(columns as f64) + 30e-3;
    // Six times the time of fall from the top.
    let release = (6.0 * (a * width / G).sqrt() / 2e-3).ceil();
    let text = format!(
        r#"(
            version: 1, title: "column",
            analysis: Dynamic(dt: 2.0e-3, theta: 1.0), gravity: (0.0, -9.81),
            materials: {{ "stone": (density: 2650.0, contact: (friction: 0.5)) }},
            specimen: Packing(
                count: 500, columns: {columns}, spacing: 12.5e-3, origin: ({origin}, 0.0),
                sizes: Uniform(radius: (4.0e-3, 6.0e-3)), seed: {seed},
            ),
            walls: [
                (name: "floor", start: (0.0, 0.0), end: ({width}, 0.0), contact: (friction: 0.5)),
                (name: "back", start: (0.0, {top}), end: (0.0, 0.0)),
                (name: "gate", start: ({width}, 0.0), end: ({width}, {top})),
                (name: "lid", start: ({width}, {top}), end: (0.0, {top})),
            ],
            stages: [
                Compact(name: "compact", wall: "lid", base: "floor", target: Porosity(0.2),
                    step: 10.0e-3, agitation: 0.1, seed: {seed}),
                Load(name: "settle", increments: 50, remove_walls: ["lid"]),
                Load(name: "release", increments: {release}, remove_walls: ["gate"]),
            ],
        )"#
    );
    (parse(&text), width)
}

/// Aspect ratio, run-out (d - d0)/d0 and h0/h of a column that has collapsed.
fn collapse(a: f64, seed: u64) -> [f64; 3] {
    let (scene, width) = column(a, seed);
    let mut simulation = Simulation::new(&scene, None);
    let mut column = 0.0;
    while let Some(record) = next(&mut simulation) {
        if record.stage == "settle" {
            column = height(&states(&mut simulation));
        }
    }
    let end = states(&mut simulation);
    [column / width, front(&end) / width - 1.0, column / height(&end)]
}

/// Exponent of a power law through points, by least squares of logarithms.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logarithms = || points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (x, y) = logarithms().fold((0.0, 0.0), |(x, y), (u, v)| (x + u / n, y + v / n));
    let (xy, xx) = logarithms()
        .fold((0.0, 0.0), |(xy, xx), (u, v)| (xy + (u - x) * (v - y), xx + (u - x) * (u - x)));
    xy / xx
}

#[test]
#[ignore = "15 columns of 500 disks"]
fn run_out_and_height_grow_with_the_aspect_ratio_as_published() {
    let mut all = Vec::new();
    for a in [0.8, 1.4, 2.5, 4.5, 8.0] {
        for seed in 1..=3 {
            let measured = collapse(a, seed);
            println!("{a} {seed}: a, run-out, h0/h = {measured:.3?}");
            all.push(measured);
        }
    }
    let law = |range: std::ops::Range<f64>, which: usize| {
        let inside = all.iter().filter(|m| range.contains(&m[0]));
        exponent(&inside.map(|m| (m[0], m[which])).collect::<Vec<_>>())
    };
    let (low, high, slump) = (law(0.65..2.0, 1), law(2.0..9.0, 1), law(2.0..9.0, 2));
    println!("exponents: run-out {low:.3} below 2, {high:.3} above; h0/h {slump:.3} above");
    // Published: 0.96 to 1 below, 0.7 to 0.73 above; 2/3.
    assert_within(low, 0.98, 0.12);
    assert_within(high, 0.715, 0.1);
    assert_within(slump, 2.0 / 3.0, 0.05);
}

/// With a larger `acceptance.residual` the solver takes fewer iterations, and the pile differs no
/// more than between runs with other round-off.
#[test]
fn what_need_not_be_exact_takes_fewer_iterations() {
    let collapse = |residual: f64| {
        let mut scene = load("column_collapse_small");
        scene.friction_law = FrictionLaw::Associated;
        scene.acceptance.residual = residual;
        let mut simulation = Simulation::new(&scene, None);
        let (mut iterations, mut worst) = (0, 0.0_f64);
        while let Some(record) = step(&mut simulation) {
            assert_eq!(record.status, IncrementStatus::Solved);
            iterations += record.iterations;
            worst = worst.max(record.residuals.worst());
        }
        (iterations, worst, front(&states(&mut simulation)))
    };
    let (exact, small, reach) = collapse(1e-8);
    let (fewer, greater, about) = collapse(1e-3);
    assert!(small <= 1e-8 && greater <= 1e-3 && greater > 1e-6, "{small:e} {greater:e}");
    assert!(3 * fewer < 2 * exact, "{fewer} of {exact} iterations");
    assert_relative(about, reach, 0.1);
}
