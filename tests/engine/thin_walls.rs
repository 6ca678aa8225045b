//! Segments, polylines and arcs against closed forms.

use std::f64::consts::PI;

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::body::BodyVelocity;
use clastic::components::contact::{BodyTable, ContactTable};
use clastic::run::Simulation;
use clastic::scene::format::{Analysis, FrictionLaw, Scene};
use glam::DVec2;

const G: f64 = 9.81;
/// Mass of a disk of radius 0.05 m and 2000 kg/m^3, times g.
const WEIGHT: f64 = 2000.0 * PI * 0.05 * 0.05 * G;

/// Disks of radius 0.05 m under gravity among walls.
fn rig(disks: &[DVec2], walls: &str, contact: &str, stages: &str) -> Scene {
    let disks: Vec<_> = disks
        .iter()
        .enumerate()
        .map(|(i, x)| format!("(position: ({:?}, {:?}), radius: 0.05, probe: \"d{i}\")", x.x, x.y))
        .collect();
    parse(&format!(
        "(version: 1, title: \"thin walls\", gravity: (0.0, -{G}),
          materials: {{ \"m\": (density: 2000.0, contact: ({contact})) }},
          specimen: Particles([{}]), walls: [{walls}], stages: [{stages}])",
        disks.join(", ")
    ))
}

const STATIC: &str = "Load(name: \"rest\", increments: 3)";

/// Both friction laws, in statics and in one long step of dynamics.
fn every_way(scene: &Scene, check: impl Fn(&mut Simulation)) {
    let analyses = [Analysis::Static, Analysis::Dynamic { dt: 1e-3, theta: 1.0 }];
    for law in [FrictionLaw::Associated, FrictionLaw::COULOMB] {
        for analysis in analyses {
            let mut scene = scene.clone();
            scene.friction_law = law;
            scene.analysis = analysis;
            let mut simulation = Simulation::new(&scene, None);
            while let Some(record) = next(&mut simulation) {
                assert_eq!(record.status, IncrementStatus::Solved);
            }
            check(&mut simulation);
        }
    }
}

/// Force of the specimen on the wall with this probe, N.
fn on(simulation: &mut Simulation, name: &str) -> DVec2 {
    let record = simulation.world().resource::<clastic::components::observation::Observation>();
    let force = probe(record, name).force;
    -DVec2::new(force[0], force[1])
}

/// Walls at the angles alpha and beta to the horizontal carry W sin(beta)/sin(alpha + beta) and
/// W sin(alpha)/sin(alpha + beta).
#[test]
fn a_corner_of_two_segments_carries_the_weight_on_both() {
    let (alpha, beta) = (0.5_f64, 1.1_f64);
    let (left, right) = (DVec2::new(-alpha.cos(), alpha.sin()), DVec2::new(beta.cos(), beta.sin()));
    // The centre is at the distance r from both.
    let bisector = (left + right).normalize();
    let centre = bisector * (0.05 / bisector.perp_dot(right).abs());
    let point = |x: DVec2| format!("({:?}, {:?})", 0.4 * x.x, 0.4 * x.y);
    let segments = format!(
        "(name: \"l\", shape: Segment, start: {}, end: (0.0, 0.0), probe: \"l\"),
         (name: \"r\", shape: Segment, start: (0.0, 0.0), end: {}, probe: \"r\")",
        point(left),
        point(right)
    );
    let sum = (alpha + beta).sin();
    let normal = |along: DVec2| if along.x < 0.0 { along.perp() } else { -along.perp() };
    every_way(&rig(&[centre], &segments, "", STATIC), |simulation| {
        let (l, r) = (on(simulation, "l"), on(simulation, "r"));
        assert_within(l.distance(normal(left) * (WEIGHT * beta.sin() / sum)), 0.0, 1e-7 * WEIGHT);
        assert_within(r.distance(normal(right) * (WEIGHT * alpha.sin() / sum)), 0.0, 1e-7 * WEIGHT);
    });
    let polyline = format!(
        "(name: \"v\", shape: Polyline([(0.0, 0.0)]), start: {}, end: {}, probe: \"v\")",
        point(left),
        point(right)
    );
    every_way(&rig(&[centre], &polyline, "", STATIC), |simulation| {
        assert_within(on(simulation, "v").distance(DVec2::new(0.0, -WEIGHT)), 0.0, 1e-7 * WEIGHT);
        assert_eq!(simulation.world().resource::<ContactTable>().0.len(), 2);
    });
}

/// On two ends that are w apart the disk is carried by W/2/cos(a) each, sin(a) = w/2r.
#[test]
fn a_disk_bridges_the_outlet_between_two_ends() {
    let half = 0.03;
    let height = (0.05_f64 * 0.05 - half * half).sqrt();
    let walls =
        "(name: \"l\", shape: Segment, start: (-0.3, 0.2), end: (-0.03, 0.0), probe: \"l\"),
        (name: \"r\", shape: Segment, start: (0.03, 0.0), end: (0.3, 0.2), probe: \"r\")";
    every_way(&rig(&[DVec2::new(0.0, height)], walls, "", STATIC), |simulation| {
        let expected = DVec2::new(0.5 * WEIGHT * half / height, -0.5 * WEIGHT);
        assert_within(on(simulation, "r").distance(expected), 0.0, 1e-7 * WEIGHT);
        assert_within(on(simulation, "l").x, -expected.x, 1e-7 * WEIGHT);
    });
}

/// A grain beside the end of a plate falls, grains lie below and above the plate, and the plate
/// stops grains that fly at it from either side.
#[test]
fn a_plate_has_two_sides() {
    let disks = [DVec2::new(0.1, 0.05), DVec2::new(0.1, -0.05), DVec2::new(0.31, 0.01)];
    let walls = "(name: \"plate\", shape: Segment, start: (0.0, 0.0), end: (0.26, 0.0)),
        (name: \"floor\", start: (-1.0, -0.2), end: (1.0, -0.2))";
    let stages = "Load(name: \"fall\", increments: 800)";
    let mut scene = rig(&disks, walls, "", stages);
    scene.analysis = Analysis::Dynamic { dt: 1e-3, theta: 1.0 };
    let mut simulation = Simulation::new(&scene, None);
    while next(&mut simulation).is_some() {}
    let end = states(&mut simulation);
    assert_within(end[0].position.y, 0.05, 1e-9);
    assert_within(end[1].position.y, -0.15, 1e-9);
    assert_within(end[2].position.y, -0.15, 1e-9);
}

/// A disk that moves by many radii in an increment is stopped by a plate and by an arc.
#[test]
fn nothing_passes_through_a_thin_wall_in_one_increment() {
    let plate = "(name: \"w\", shape: Segment, start: (0.0, 0.5), end: (0.0, -0.5))";
    let arc =
        "(name: \"w\", shape: Arc(through: (0.0, 0.0)), start: (-0.3, 0.3), end: (-0.3, -0.3))";
    for (walls, from, speed) in
        [(plate, -0.7, 1e3), (plate, 0.7, -1e3), (arc, -0.2, 1e3), (arc, 0.7, -1e3)]
    {
        let stages = "Load(name: \"fly\", increments: 3, gravity: (0.0, 0.0))";
        let mut scene = rig(&[DVec2::new(from, 0.0)], walls, "", stages);
        scene.analysis = Analysis::Dynamic { dt: 1e-3, theta: 1.0 };
        let clastic::scene::format::Specimen::Particles(list) = &mut scene.specimen else {
            panic!("explicit particles")
        };
        list[0].velocity = (speed, 0.0);
        let mut simulation = Simulation::new(&scene, None);
        while next(&mut simulation).is_some() {}
        assert_within(states(&mut simulation)[0].position.x, 0.05 * from.signum(), 1e-9);
    }
}

/// Without friction a disk that slides over the edge at speed v turns about it, and leaves it where
/// g cos(a) = v^2/r: cos(a) = (2 + v_0^2/(g r))/3.
#[test]
fn a_disk_that_slides_over_the_edge_leaves_it_where_it_must() {
    let walls =
        "(name: \"table\", shape: Segment, start: (-1.0, 0.0), end: (0.0, 0.0), probe: \"t\")";
    let leaves = |dt: f64, law: FrictionLaw| {
        let mut scene = rig(
            &[DVec2::new(-0.02, 0.05)],
            walls,
            "",
            "Load(name: \"slide\", increments: 10000000)",
        );
        scene.friction_law = law;
        scene.analysis = Analysis::Dynamic { dt, theta: 1.0 };
        let clastic::scene::format::Specimen::Particles(list) = &mut scene.specimen else {
            panic!("explicit particles")
        };
        list[0].velocity = (0.2, 0.0);
        let mut simulation = Simulation::new(&scene, None);
        loop {
            next(&mut simulation).unwrap();
            let x = states(&mut simulation)[0].position;
            let force = on(&mut simulation, "t");
            assert!(x.length() >= 0.05 - 1e-9, "into the edge");
            if x.x < 0.0 {
                assert_within(x.y, 0.05, 1e-9);
                assert_within(force.distance(DVec2::new(0.0, -WEIGHT)), 0.0, 1e-6 * WEIGHT);
            } else if force.length() < 1e-9 * WEIGHT {
                break x.y / x.length();
            }
        }
    };
    let v = 0.2_f64;
    let expected = (2.0 + v * v / (G * 0.05)) / 3.0;
    for law in [FrictionLaw::Associated, FrictionLaw::COULOMB] {
        let errors = [4e-4, 2e-4, 1e-4].map(|dt| leaves(dt, law) - expected);
        println!("{errors:?}");
        // The time step is the only error, and it is of first order.
        assert!(errors[2].abs() < 2e-3 && errors[2].abs() < 0.5 * errors[0].abs(), "{errors:?}");
    }
}

/// A disk that rolls without slip in an arc swings like a pendulum, with the period
/// 2 pi sqrt(3 (R - r)/(2 g)) at small angles.
#[test]
fn a_disk_in_an_arc_swings_with_the_period_of_a_pendulum() {
    let (radius, arm, angle) = (0.25, 0.2, 0.02_f64);
    let walls = "(name: \"bowl\", shape: Arc(through: (0.0, -0.25)), start: (-0.2, -0.15),
        end: (0.2, -0.15), contact: (friction: 1.0))";
    let expected = 2.0 * PI * (3.0 * arm / (2.0 * G)).sqrt();
    let period = |dt: f64, law: FrictionLaw| {
        let start = arm * DVec2::new(angle.sin(), -angle.cos());
        let mut scene = rig(&[start], walls, "", "Load(name: \"swing\", increments: 10000000)");
        scene.friction_law = law;
        scene.analysis = Analysis::Dynamic { dt, theta: 1.0 };
        let mut simulation = Simulation::new(&scene, None);
        let mut crossings = Vec::new();
        let mut before = (0.0, start.x);
        while crossings.len() < 5 {
            let time = next(&mut simulation).unwrap().time;
            let disk = states(&mut simulation)[0];
            let x = disk.position.x;
            if x * before.1 < 0.0 {
                crossings.push(before.0 + (time - before.0) * before.1 / (before.1 - x));
            }
            before = (time, x);
            // Rolling: the angle of the disk is that of its way on the arc less that of its place.
            let place = x.atan2(-disk.position.y) - angle;
            assert_within(disk.rotation, -arm / (radius - arm) * place, 1e-4 * angle);
        }
        0.5 * (crossings[4] - crossings[0])
    };
    for law in [FrictionLaw::Associated, FrictionLaw::COULOMB] {
        let errors = [2e-3, 1e-3].map(|dt| period(dt, law) / expected - 1.0);
        println!("{errors:?}");
        assert!(errors[1].abs() < 1e-3, "{errors:?}");
    }
}

/// Two jaws of stiffness k about one disk close by d: k d/2 on each.
#[test]
fn jaws_press_a_disk_with_half_the_closing_each() {
    let law = "contact: (normal_stiffness: 1.0e8, tangential_stiffness: 5.0e7, friction: 0.4)";
    let walls = format!(
        "(name: \"low\", shape: Arc(through: (0.0, 0.0)), start: (-0.03, 0.0075), end: (0.03, 0.0075),
            probe: \"low\", {law}),
         (name: \"high\", shape: Arc(through: (0.0, 0.1)), start: (0.03, 0.0925), end: (-0.03, 0.0925),
            probe: \"high\", {law})"
    );
    for (control, force) in
        [("Displacement(0.0, -1.0e-6)", 0.5 * 1e8 * 5e-6), ("Force(400.0)", 400.0)]
    {
        let stages = format!(
            "Load(name: \"press\", increments: 5, gravity: (0.0, 0.0), walls: {{ \"high\": {control} }})"
        );
        let scene = rig(&[DVec2::new(0.0, 0.05)], &walls, "", &stages);
        let (records, _) = run(&scene);
        let last = records.last().unwrap();
        for (name, sign) in [("high", -1.0), ("low", 1.0)] {
            assert_relative(sign * probe(last, name).force[1], force, 1e-7);
            assert_within(probe(last, name).force[0], 0.0, 1e-7 * force);
        }
    }
}

/// A static grain whose centre is past the end of a shelf finds the floor; one before it stays, and
/// one that has no room to pass comes to rest between the end and the stop.
#[test]
fn a_static_grain_past_the_edge_falls_to_the_floor() {
    for (stop, height) in [(0.11, -0.07), (0.08, 0.04)] {
        past_the_edge(stop, height);
    }
}

fn past_the_edge(stop: f64, height: f64) {
    let walls = format!(
        "(name: \"shelf\", shape: Segment, start: (-1.0, 0.0), end: (0.0, 0.0)),
        (name: \"floor\", start: (-1.0, -0.12), end: (1.0, -0.12), contact: (friction: 0.5)),
        (name: \"stop\", start: ({stop}, -1.0), end: ({stop}, 1.0))"
    );
    let disks = [DVec2::new(-0.1, 0.05), DVec2::new(0.02, (0.05_f64 * 0.05 - 0.02 * 0.02).sqrt())];
    for law in [FrictionLaw::Associated, FrictionLaw::COULOMB] {
        let mut scene = rig(&disks, &walls, "", STATIC);
        scene.friction_law = law;
        let mut simulation = Simulation::new(&scene, None);
        let mut steps = 0;
        while let Some(record) = next(&mut simulation) {
            assert_eq!(record.status, IncrementStatus::Solved);
            steps += record.motion_steps;
        }
        let end = states(&mut simulation);
        assert_within(end[0].position.distance(disks[0]), 0.0, 1e-9);
        assert_within(end[1].position.y, height, 1e-6);
        assert!(steps > 0 || height > 0.0, "no motion was followed");
    }
}

/// A disk in a whole circle, and a disk on one: nothing is at the start of the circle.
#[test]
fn a_whole_circle_has_no_end() {
    let centre = DVec2::new(0.2, 0.1);
    let radius = centre.length();
    let walls =
        "(name: \"drum\", shape: Arc(through: (0.4, 0.2)), start: (0.0, 0.0), end: (0.0, 0.0),
        probe: \"drum\")";
    for place in [0.05 - radius, 0.05 + radius] {
        let scene = rig(&[centre + DVec2::new(0.0, place)], walls, "", STATIC);
        every_way(&scene, |simulation| {
            let force = on(simulation, "drum");
            assert_within(force.distance(DVec2::new(0.0, -WEIGHT)), 0.0, 1e-6 * WEIGHT);
            assert_eq!(simulation.world().resource::<BodyTable>().walls.len(), 1);
        });
    }
}

/// A floor in one line: one wall, a polyline, or segments with common ends, drawn either way.
fn floors(joints: &[f64], contact: &str) -> Vec<String> {
    let piece = |shape: &str, k: usize, [from, to]: [f64; 2]| {
        format!(
            "(name: \"f{k}\", start: ({from:?}, 0.0), end: ({to:?}, 0.0), {shape} contact: ({contact}))"
        )
    };
    let corners: Vec<_> = joints.iter().map(|x| format!("({x:?}, 0.0)")).collect();
    let all: Vec<_> = [-1.0].iter().chain(joints).chain(&[2.0]).copied().collect();
    let pieces = |turns: usize| {
        let of = all.windows(2).enumerate().map(|(k, ends)| {
            let ends = if k % 2 < turns { [ends[1], ends[0]] } else { [ends[0], ends[1]] };
            piece("shape: Segment,", k, ends)
        });
        of.collect::<Vec<_>>().join(", ")
    };
    let polyline = format!("shape: Polyline([{}]),", corners.join(", "));
    vec![piece("", 0, [-1.0, 2.0]), piece(&polyline, 0, [-1.0, 2.0]), pieces(0), pieces(1)]
}

/// A disk exactly over a joint sinks in by W/k, as on one line.
#[test]
fn a_joint_in_a_line_is_one_contact() {
    let stiff = 1.0e6;
    for x in [0.0, 1e-9, -3e-5, 0.001] {
        for floor in floors(&[-0.5, 0.0, 0.7], &format!("normal_stiffness: {stiff:?}")) {
            let held = "Load(name: \"rest\", increments: 3, particles: [(select: All, x: Held)])";
            let disk = [DVec2::new(x, 0.05)];
            every_way(&rig(&disk, &floor, "", &held.replace("3", "1")), |simulation| {
                assert_eq!(simulation.world().resource::<ContactTable>().0.len(), 1, "{floor}");
            });
            let mut simulation = Simulation::new(&rig(&disk, &floor, "", held), None);
            while next(&mut simulation).is_some() {}
            let y = states(&mut simulation)[0].position.y;
            assert_within(y, 0.05 - WEIGHT / stiff, 1e-9);
        }
    }
}

/// A disk slides and then rolls over the joints of a floor as on one line.
#[test]
fn joints_in_a_line_are_not_felt() {
    let contact = "normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.2";
    let ends: Vec<_> = floors(&[0.13, 0.3, 0.42, 0.5], contact)
        .iter()
        .map(|floor| {
            let stages = "Load(name: \"run\", increments: 1000)";
            let mut scene = rig(&[DVec2::new(0.0, 0.05 - WEIGHT / 1e6)], floor, "", stages);
            scene.friction_law = FrictionLaw::COULOMB;
            scene.analysis = Analysis::Dynamic { dt: 1e-3, theta: 1.0 };
            let mut simulation = Simulation::new(&scene, None);
            let world = simulation.world_mut();
            world.query::<&mut BodyVelocity>().single_mut(world).unwrap().0 = DVec2::X;
            while next(&mut simulation).is_some() {
                let y = states(&mut simulation)[0].position.y;
                assert_within(y, 0.05 - WEIGHT / 1e6, 1e-9);
            }
            states(&mut simulation)[0].position.x
        })
        .collect();
    // Sliding until t = v/(3 mu g), then rolling at 2/3 v.
    let slides = 1.0 / (3.0 * 0.2 * G);
    assert_within(ends[0], slides * 5.0 / 6.0 + 2.0 / 3.0 * (1.0 - slides), 1e-3);
    for end in &ends[1..] {
        assert_within(*end, ends[0], 1e-4);
    }
}

/// Disks left a closed polyline and a circle at 6 to 17 radii an increment: past the corner of two
/// segments, and beyond the tangent of an arc.
#[test]
fn no_disk_leaves_a_closed_wall_however_far_an_increment_takes_it() {
    let boxed =
        "start: (0.0, 0.0), end: (0.0, 0.0), shape: Polyline([(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])";
    let round = "start: (0.0, 0.5), end: (0.0, 0.5), shape: Arc(through: (1.0, 0.5))";
    for contact in ["restitution: 1.0", "normal_stiffness: 1e7"] {
        for (wall, half) in [(boxed, 0.5), (round, 0.5)] {
            for speed in [3.0, 4.7, 8.3, 15.0] {
                let scene = parse(&format!(
                    "(version: 1, title: \"closed\", analysis: Dynamic(dt: 0.1),
                    materials: {{\"a\": (contact: ({contact}))}},
                    specimen: Particles([(position: (0.37, 0.52), radius: 0.05, velocity: ({speed:?}, 2.41))]),
                    walls: [(name: \"closed\", {wall}, contact: ({contact}))],
                    stages: [Load(name: \"run\", increments: 100)])"
                ));
                let mut simulation = Simulation::new(&scene, None);
                while let Some(record) = next(&mut simulation) {
                    let at = states(&mut simulation)[0].position - DVec2::splat(0.5);
                    assert!(
                        at.x.abs() <= half && at.y.abs() <= half,
                        "{wall}, {contact}, {speed} m/s: outside in increment {}",
                        record.increment
                    );
                }
            }
        }
    }
}

/// A plough that moves by two radii an increment left three of five disks behind it.
#[test]
fn no_disk_passes_a_thin_wall_in_statics() {
    for increments in [5, 20] {
        let disks =
            [0.1, 0.22, 0.34, 0.46, 0.58].map(|x| DVec2::new(x, 0.05 + 0.013 * (x * 50.0 % 2.0)));
        let step = 2.0 / f64::from(increments);
        let plough = "(name: \"floor\", start: (-3.0, 0.0), end: (6.0, 0.0), contact: (normal_stiffness: 1e6)),
            (name: \"plough\", shape: Segment, start: (0.0, 2.5), end: (0.0, -0.02), probe: \"plough\",
             contact: (normal_stiffness: 1e6))";
        let stage = format!(
            "Load(name: \"push\", increments: {increments}, walls: {{ \"plough\": Displacement({step:?}, 0.0) }})"
        );
        let mut scene = rig(&disks, plough, "normal_stiffness: 1e6, friction: 0.3", &stage);
        scene.gravity = (0.0, 0.0);
        let mut simulation = Simulation::new(&scene, None);
        let mut wall = 0.0;
        while let Some(record) = next(&mut simulation) {
            wall = probe(&record, "plough").motion[0];
            for (i, disk) in states(&mut simulation).iter().take(5).enumerate() {
                assert!(
                    disk.position.x > wall,
                    "disk {i} at {} m, wall at {wall} m",
                    disk.position.x
                );
            }
        }
        assert_within(wall, 2.0, 1e-12);
    }
}
