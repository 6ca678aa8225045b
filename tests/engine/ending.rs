//! An increment is judged where it ends: its geometry is that of the end, and a time step keeps energy.

use std::fmt::Write as _;

use crate::common::*;
use clastic::run::Outcome;

const RADIUS: f64 = 0.05;
/// Rolling stiffness of a bond, N m/rad.
const BENDING: f64 = 2.0e4;

/// Disks in a row from the origin, bonded to bend and too strong to break, and what is done to them.
fn row(count: usize, step: (f64, f64), head: &str, stages: &str) -> String {
    let mut disks = String::new();
    for i in 0..count {
        let (x, y) = (step.0 * i as f64, step.1 * i as f64);
        let probe = if i + 1 == count { ", probe: \"tip\"" } else { "" };
        _ = write!(disks, "(position: ({x:?}, {y:?}), radius: {RADIUS:?}{probe}),");
    }
    format!(
        "(version: 1, title: \"row\", {head}
          materials: {{ \"a\": (density: 1000.0, bond: (normal_stiffness: 1.0e9,
            tangential_stiffness: 1.0e9, rolling_stiffness: {BENDING:?}, rolling_friction: 10.0,
            cohesion: 1.0e12, tensile_strength: 1.0e12)) }},
          specimen: Particles([{disks}]),
          stages: [Cement(name: \"bond\", length: 1.0e-6), {stages}])"
    )
}

/// A column of `n` joints under the axial load P and the lateral load H at its tip. The rotations th of
/// its disks follow from the joints, `K th_(i-1) - th_i`, and from the lines between centres, which
/// turn by the mean rotation of their disks: `(K - P G) th = H r`. Returns P_cr and the deflection at
/// `part` of it.
fn column(n: usize, part: f64, lateral: f64) -> (f64, f64, f64) {
    let matrix = |load: f64| -> Vec<Vec<f64>> {
        let mut a = vec![vec![0.0; n]; n];
        for joint in 0..n {
            let ends = [joint.checked_sub(1).map(|i| (i, -1.0)), Some((joint, 1.0))];
            for (p, s) in ends.iter().flatten() {
                for (q, t) in ends.iter().flatten() {
                    a[*p][*q] += BENDING * s * t - load * 2.0 * RADIUS * 0.25;
                }
            }
        }
        a
    };
    let solve = |mut a: Vec<Vec<f64>>, mut b: Vec<f64>| -> (Vec<f64>, bool) {
        let mut positive = true;
        for k in 0..n {
            positive &= a[k][k] > 0.0;
            for i in k + 1..n {
                let f = a[i][k] / a[k][k];
                for j in k..n {
                    a[i][j] -= f * a[k][j];
                }
                b[i] -= f * b[k];
            }
        }
        for k in (0..n).rev() {
            let sum: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
            b[k] = (b[k] - sum) / a[k][k];
        }
        (b, positive)
    };
    // The buckling load is the largest with a positive definite matrix.
    let (mut low, mut high) = (0.0, 1.0e6);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if solve(matrix(middle), vec![0.0; n]).1 { low = middle } else { high = middle }
    }
    let force = lateral * low;
    let arms = (0..n).map(|i| if i + 1 == n { RADIUS } else { 2.0 * RADIUS });
    let loads: Vec<f64> = arms.clone().map(|arm| arm * force).collect();
    let turns = solve(matrix(part * low), loads).0;
    let deflection = turns.iter().zip(arms).map(|(turn, arm)| turn * arm).sum();
    (part * low, force, deflection)
}

/// A column at 0.9 of its buckling load had 0.6 of its deflection, with residuals of 1e-10.
#[test]
fn a_column_below_its_buckling_load_is_right_with_any_number_of_increments() {
    for part in [0.5, 0.9] {
        let (axial, lateral, expected) = column(10, part, 1e-4);
        for increments in [1, 3, 10] {
            let stages = format!(
                "Load(name: \"load\", increments: {increments}, particles: [
                    (select: Index([0]), x: Held, y: Held, rotation: Held),
                    (select: Index([10]), force: ({lateral:?}, {:?}))])",
                -axial
            );
            let scene = parse(&row(11, (0.0, 2.0 * RADIUS), "", &stages));
            let (records, outcome) = run(&scene);
            assert_eq!(outcome, Outcome::Completed);
            let found = probe(records.last().unwrap(), "tip").motion[0];
            println!("{part} of the buckling load, {increments} increments: {}", found / expected);
            assert_relative(found, expected, 1e-3);
        }
    }
}

/// A chain that swings from a held disk gained 1e18 times its energy in four seconds with theta = 1/2.
#[test]
fn a_chain_that_swings_keeps_its_energy() {
    let head =
        "gravity: (0.0, -9.81), analysis: Dynamic(dt: 1.0e-3, theta: 0.5), output: (energy: true),";
    let stages = "Load(name: \"swing\", increments: 1000, particles: [
        (select: Index([0]), x: Held, y: Held, rotation: Held)])";
    // Without bending stiffness the disks roll on each other.
    let text = row(6, (2.0 * RADIUS, 0.0), head, stages)
        .replace("rolling_stiffness: 20000.0, rolling_friction: 10.0,", "");
    let mut simulation = clastic::run::Simulation::new(&parse(&text), None);
    let mut largest = 0.0_f64;
    while let Some(record) = next(&mut simulation) {
        largest = largest.max(record.kinetic_energy);
    }
    let ledger = simulation.world().resource::<clastic::components::energy::EnergyLedger>();
    let turning = ledger.total.turning;
    println!("{turning:e} J of {largest} J");
    assert!(largest > 1.0, "{largest}");
    assert_within(turning, 0.0, 1e-4 * largest);
}
