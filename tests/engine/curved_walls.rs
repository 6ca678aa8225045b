//! Arcs and end points where the geometry within an increment counts: finite motions and impacts.

use std::f64::consts::PI;

use crate::common::*;
use clastic::cone::program::ConeSolution;
use clastic::run::Simulation;
use clastic::scene::format::{Scene, Specimen};
use glam::DVec2;

/// A disk of radius 0.05 m at `place`, held but for what `motion` imposes.
fn driven(wall: &str, place: DVec2, motion: DVec2, settings: &str) -> Scene {
    parse(&format!(
        "(version: 1, title: \"curved\", {settings}
          materials: {{ \"m\": (density: 2000.0) }},
          specimen: Particles([(position: ({:?}, {:?}), radius: 0.05)]),
          walls: [({wall}, contact: (normal_stiffness: 1.0e8, tangential_stiffness: 5.0e7, friction: 1.0e5))],
          stages: [Load(name: \"go\", increments: 1, particles: [(select: All,
            x: Displacement({:?}), y: Displacement({:?}), rotation: Held)])])",
        place.x, place.y, motion.x, motion.y
    ))
}

/// A disk that is carried along a curve by a finite angle, at a constant
/// overlap, keeps its normal force k o and has the shear force k_T L phi, L the distance of its
/// centre from that of the curve.
#[test]
fn a_disk_follows_a_curve() {
    let overlap = 1e-5;
    let arc =
        "name: \"w\", shape: Arc(through: (0.0, -0.25)), start: (-0.2, -0.15), end: (0.2, -0.15)";
    let end = "name: \"w\", shape: Segment, start: (0.0, 0.0), end: (0.0, 0.5)";
    for (wall, distance) in [(arc, 0.2 + overlap), (arc, 0.3 - overlap), (end, 0.05 - overlap)] {
        for phi in [0.02_f64, -0.3] {
            let at = |angle: f64| distance * DVec2::new(angle.sin(), -angle.cos());
            let (start, finish) = (at(-0.1), at(-0.1 + phi));
            let scene = driven(wall, start, finish - start, "");
            let mut simulation = Simulation::new(&scene, None);
            next(&mut simulation).unwrap();
            let [p, q, _] = simulation.world().resource::<ConeSolution>().forces[0];
            assert_relative(p, 1e8 * overlap, 1e-6);
            assert_relative(q.abs(), 5e7 * distance * phi.abs(), 1e-9);
        }
    }
}

/// A disk that flies into a curve leaves it with v - (1 + e) (v . n) n, n the normal where it hits,
/// and is where it must be at the end of the increment.
#[test]
fn a_rebound_is_about_the_normal_where_it_hits() {
    let end = "name: \"w\", shape: Segment, start: (0.0, 0.0), end: (0.5, 0.0)";
    let arc =
        "name: \"w\", shape: Arc(through: (0.0, -0.25)), start: (-0.2, -0.15), end: (0.2, -0.15)";
    // Place, velocity, and the centre and distance of the centre at the impact.
    let cases = [
        (end, DVec2::new(-0.03, 0.12), DVec2::new(0.0, -2.0), 0.05),
        (arc, DVec2::new(0.05, -0.1), DVec2::new(0.3, -2.0), 0.2),
        (arc, DVec2::new(-0.06, -0.38), DVec2::new(0.3, 2.5), 0.3),
    ];
    for (wall, place, velocity, distance) in cases {
        for e in [1.0, 0.4] {
            let mut scene = parse(
                &format!(
                    "(version: 1, title: \"rebound\", analysis: Dynamic(dt: 0.06, theta: 0.5),
                  materials: {{ \"m\": (density: 2000.0, contact: (restitution: {e:?})) }},
                  specimen: Particles([(position: (0.0, 0.0), radius: 0.05)]),
                  walls: [({wall}, contact: (restitution: {e:?}))],
                  stages: [Load(name: \"fly\", increments: 1)])"
                )
                .replace(
                    "position: (0.0, 0.0)",
                    &format!("position: ({:?}, {:?})", place.x, place.y),
                ),
            );
            let Specimen::Particles(list) = &mut scene.specimen else {
                panic!("explicit particles")
            };
            list[0].velocity = velocity.into();
            // |place + t velocity| = distance, the first root in the future.
            let (a, b) = (velocity.length_squared(), place.dot(velocity));
            let root = (b * b - a * (place.length_squared() - distance * distance)).sqrt();
            let t = if place.length() < distance { -b + root } else { -b - root } / a;
            assert!((0.0..0.06).contains(&t));
            let hit = place + t * velocity;
            let n = hit / distance;
            let after = velocity - (1.0 + e) * velocity.dot(n) * n;
            let mut simulation = Simulation::new(&scene, None);
            next(&mut simulation).unwrap();
            let disk = states(&mut simulation)[0];
            assert_within(disk.velocity.distance(after), 0.0, 1e-7);
            assert_within(disk.position.distance(hit + (0.06 - t) * after), 0.0, 1e-7);
        }
    }
}

/// Over a corner that sticks out a disk has one contact, and in a drum of many segments as well as
/// in a circle it comes to rest at the bottom.
#[test]
fn a_drum_of_segments_is_nearly_a_circle() {
    let corner = |k: usize| {
        let angle = 2.0 * PI * (k as f64) / 60.0 - 0.5 * PI;
        format!("({:?}, {:?})", 0.3 * angle.cos(), 0.3 * angle.sin())
    };
    let corners: Vec<_> = (1..60).map(corner).collect();
    let drum =
        format!("shape: Polyline([{}]), start: {c}, end: {c}", corners.join(", "), c = corner(0));
    let circle = "shape: Arc(through: (0.0, 0.3)), start: (0.0, -0.3), end: (0.0, -0.3)".to_owned();
    for (shape, bottom) in [(drum, 0.002), (circle, 1e-6)] {
        let scene = parse(&format!(
            "(version: 1, title: \"drum\", analysis: Dynamic(dt: 1.0e-3), gravity: (0.0, -9.81),
              materials: {{ \"m\": (density: 2000.0) }},
              specimen: Particles([(position: (0.15, -0.1), radius: 0.05)]),
              walls: [(name: \"drum\", {shape}, probe: \"drum\",
                contact: (friction: 0.8, rolling_friction: 0.1))],
              stages: [Load(name: \"roll\", increments: 4000)])"
        ));
        let mut simulation = Simulation::new(&scene, None);
        let mut last = None;
        while let Some(record) = next(&mut simulation) {
            last = Some(record);
        }
        let disk = states(&mut simulation)[0];
        println!("{:?} {:?}", disk.position, disk.velocity);
        let weight = disk.mass * 9.81;
        assert_relative(probe(&last.unwrap(), "drum").force[1], weight, 1e-3);
        assert_within(disk.position.length(), 0.25, bottom);
        assert!(disk.position.y < -0.2 && disk.velocity.length() < 1e-3);
    }
}
