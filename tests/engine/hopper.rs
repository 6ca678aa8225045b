//! The scene `hopper`: a discharge at a constant rate, and an arch that stops it.

use crate::common::*;
use clastic::run::Simulation;
use clastic::scene::format::{Scene, Specimen};

/// The scene with 160 disks and an outlet of this width, m.
fn hopper(width: f64, seed: u64) -> Scene {
    let mut scene = load("hopper");
    let Specimen::Packing { count, seed: of_scene, .. } = &mut scene.specimen else {
        panic!("a packing")
    };
    (*count, *of_scene) = (160, seed);
    scene.walls[0].end.0 = -0.5 * width;
    scene.walls[1].start.0 = 0.5 * width;
    stage(&mut scene, "settle").increments = 150;
    stage(&mut scene, "flow").increments = 350;
    scene
}

/// Number of disks below the outlet after every increment of the flow.
fn discharged(scene: &Scene) -> Vec<usize> {
    let mut simulation = Simulation::new(scene, None);
    let mut out = Vec::new();
    while let Some(record) = step(&mut simulation) {
        let disks = states(&mut simulation);
        let below = disks.iter().filter(|disk| disk.position.y < 0.0).count();
        // No disk passes through a wall.
        for disk in disks.iter().filter(|disk| disk.position.y > 0.08) {
            assert!(disk.position.x.abs() <= 0.1 - 0.99 * disk.radius);
        }
        if record.stage == "flow" {
            out.push(below);
        } else {
            assert_eq!(below, 0, "through the plate");
        }
    }
    out
}

/// The rate is the same in both halves of the flow, and that of Beverloo in two dimensions, C
/// sqrt(g) (D - k d)^1.5 times the solid fraction over the area of a disk, with k = 1.4 and C = 1.
#[test]
fn a_wide_outlet_discharges_at_a_constant_rate() {
    let below = discharged(&hopper(0.07, 11));
    let [first, second, third] = [80, 180, 280].map(|k| below[k] as f64);
    let rates = [(second - first) / 0.1, (third - second) / 0.1];
    let mean_area = std::f64::consts::PI * 76e-6 / 3.0;
    let beverloo = 9.81_f64.sqrt() * 0.056_f64.powf(1.5) * 0.8 / mean_area;
    println!("{rates:?}, Beverloo {beverloo:.0} in a second");
    assert!((rates[0] / rates[1] - 1.0).abs() < 0.25, "{rates:?}");
    assert!((rates[0] / beverloo - 1.0).abs() < 0.3, "{rates:?}, not {beverloo}");
}

/// Through an outlet of two diameters few grains fall before others bridge it.
#[test]
fn a_narrow_outlet_is_bridged() {
    let below = discharged(&hopper(0.02, 11));
    let last = below.len() - 1;
    println!("{} of 160 fell", below[last]);
    assert!(below[last] < 80);
    assert_eq!(below[last], below[last - 150], "still flowing");
}
