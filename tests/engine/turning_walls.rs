//! Walls that turn about a point: geometry, forces, moments and work.

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::body::BodyExternalForce;
use clastic::components::contact_history::ContactHistory;
use clastic::components::energy::EnergyLedger;
use clastic::components::observation::Observation;
use clastic::components::wall::{Wall, WallControl};
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::{FrictionLaw, Scene};
use glam::DVec2;

const MASS: f64 = 2000.0 * std::f64::consts::PI * 0.01 * 0.01;
const WEIGHT: f64 = MASS * 9.81;

/// Three disks on a plate that is hinged at its left end, (0, 0).
fn plate(analysis: &str, contact: &str, stages: &str) -> Scene {
    let disks = [0.05, 0.09, 0.15]
        .map(|x| format!("(position: ({x:?}, 0.01), radius: 0.01, probe: \"{x:?}\")"));
    parse(&format!(
        "(version: 1, title: \"plate\", analysis: {analysis}, gravity: (0.0, -9.81),
          materials: {{ \"m\": (density: 2000.0, contact: ({contact})) }},
          specimen: Particles([{}]),
          walls: [(name: \"plate\", shape: Segment, start: (0.0, 0.0), end: (0.2, 0.0), probe: \"plate\",
            contact: ({contact}))],
          stages: [{stages}], output: (energy: true))",
        disks.join(", ")
    ))
}

fn both_laws(scene: &Scene, mut check: impl FnMut(&mut Simulation, &[Observation])) {
    for law in [FrictionLaw::Associated, FrictionLaw::COULOMB] {
        let mut scene = scene.clone();
        scene.friction_law = law;
        let mut simulation = Simulation::new(&scene, None);
        let records: Vec<_> = std::iter::from_fn(|| next(&mut simulation)).collect();
        assert!(records.iter().all(|o| o.status == IncrementStatus::Solved));
        check(&mut simulation, &records);
    }
}

fn tangent(simulation: &mut Simulation) -> DVec2 {
    let world = simulation.world_mut();
    let mut walls = world.query::<&Wall>();
    walls.iter(world).next().map(|wall| wall.tangent).unwrap()
}

const ELASTIC: &str = "normal_stiffness: 1e7, tangential_stiffness: 1e7, friction: 0.6";
const UPRIGHT: &str = "particles: [(select: All, rotation: Held)]";

/// A row of disks on a plate that has turned by 0.3 rad, held by friction: the plate carries the
/// weight, and its moment about any point is that of the weight through the contact points.
#[test]
fn a_tilted_plate_carries_the_weight_and_its_moment() {
    let stages = format!(
        "Load(name: \"stand\", increments: 1, {UPRIGHT}),
         Load(name: \"tilt\", increments: 60, {UPRIGHT},
            walls: {{ \"plate\": Rotation(about: (0.0, 0.0), angle: 0.005) }}),
         Load(name: \"hold\", increments: 2, {UPRIGHT})"
    );
    for contact in [ELASTIC, "friction: 0.6"] {
        both_laws(&plate("Static", contact, &stages), |simulation, records| {
            let last = probe(records.last().unwrap(), "plate");
            assert_within(last.motion[2], 0.3, 1e-12);
            assert_within(tangent(simulation).angle_to(DVec2::from_angle(0.3)), 0.0, 1e-12);
            let middle = 0.1 * DVec2::from_angle(0.3);
            let moved = DVec2::new(last.motion[0], last.motion[1]);
            assert!(moved.distance(middle - DVec2::new(0.1, 0.0)) < 1e-14);
            assert_within(last.force[0], 0.0, 1e-6 * WEIGHT);
            assert_relative(last.force[1], 3.0 * WEIGHT, 1e-7);
            // Contact points lie below the centres, along the normal of the plate.
            let normal = DVec2::from_angle(0.3).perp();
            let levers = states(simulation).into_iter().map(|disk| {
                let height = disk.position.dot(normal);
                assert_within(height, disk.radius, 2e-6);
                // In the middle of the overlap.
                disk.position.x - 0.5 * (height + disk.radius) * normal.x - middle.x
            });
            let moment: f64 = levers.map(|lever| WEIGHT * lever).sum();
            assert_relative(last.force[2], moment, 1e-6);
            // Nothing slides: disks that do not turn roll on the plate that turns under them.
            for (x, disk) in [0.05, 0.09, 0.15].into_iter().zip(states(simulation)) {
                assert_within(disk.position.dot(DVec2::from_angle(0.3)), x + 0.01 * 0.3, 1e-4);
            }
        });
    }
}

/// The work of the hinge is the potential energy of what it lifts.
#[test]
fn the_plate_lifts_the_weight() {
    let stages = format!(
        "Load(name: \"stand\", increments: 1, {UPRIGHT}),
         Load(name: \"tilt\", increments: 100, {UPRIGHT},
            walls: {{ \"plate\": Rotation(about: (0.0, 0.0), angle: 0.003) }})"
    );
    let scene = plate("Static", ELASTIC, &stages);
    both_laws(&scene, |simulation, _| {
        let lifted: f64 = states(simulation).iter().map(|s| WEIGHT * (s.position.y - 0.01)).sum();
        let total = &simulation.world().resource::<EnergyLedger>().total;
        assert_relative(total.gravity, -lifted, 1e-4);
        // The program has the rotation to first order, 0.003 in an increment.
        assert_relative(total.external, lifted, 1e-3);
    });
}

/// A bead on a rotating rod: without friction and gravity its distance s from the hinge follows
/// s'' = omega^2 s. A disk of radius r that rests at first has s' = omega r, since the rod turns back
/// under its centre: s = s_0 cosh(omega t) + r sinh(omega t). It stays on the rod.
#[test]
fn a_disk_without_friction_runs_along_a_spinning_plate() {
    let stages = "Load(name: \"spin\", increments: 1000, gravity: (0.0, 0.0),
        walls: { \"plate\": Spin(about: (0.0, 0.0), angular_velocity: 1.0) })";
    let mut errors = Vec::new();
    for (dt, steps) in [(2e-3, 500), (1e-3, 1000)] {
        let mut scene = plate(&format!("Dynamic(dt: {dt:?})"), "", stages);
        scene.walls[0].end = (0.5, 0.0);
        stage(&mut scene, "spin").increments = steps;
        let mut simulation = Simulation::new(&scene, None);
        while next(&mut simulation).is_some() {}
        let along = tangent(&mut simulation);
        assert_within(along.angle_to(DVec2::from_angle(1.0)), 0.0, 1e-12);
        let expected = |x: f64| x * 1.0_f64.cosh() + 0.01 * 1.0_f64.sinh();
        let disks = states(&mut simulation);
        for (x, disk) in [0.05, 0.09, 0.15].into_iter().zip(&disks) {
            assert_relative(disk.position.dot(along), expected(x), 3.0 * dt);
            assert_within(disk.position.dot(along.perp()), 0.01, 1e-5);
        }
        errors.push(disks[2].position.dot(along) - expected(0.15));
    }
    // Of first order in the time step.
    assert!((errors[0] / errors[1] - 2.0).abs() < 0.1, "{errors:?}");
}

/// A wall that turns about its toe into a stack of held springs: every force is the stiffness times
/// the exact overlap, and the moment about the toe is their sum with their arms.
#[test]
fn a_wall_turns_about_its_toe_into_springs() {
    let heights = [0.01, 0.03, 0.05, 0.07];
    let disks = heights.map(|y| format!("(position: (-0.01, {y:?}), radius: 0.01)")).join(", ");
    for shape in ["Line", "Segment", "Polyline([(0.0, 0.04)])"] {
        let scene = parse(&format!(
            "(version: 1, title: \"toe\",
              materials: {{ \"m\": (density: 2000.0, contact: (normal_stiffness: 1e7)) }},
              specimen: Particles([{disks}]),
              walls: [(name: \"wall\", start: (0.0, 0.0), end: (0.0, 0.1), shape: {shape}, probe: \"wall\",
                contact: (normal_stiffness: 1e7))],
              stages: [
                Load(name: \"push\", increments: 5, particles: [(select: All, x: Held, y: Held)],
                    walls: {{ \"wall\": Rotation(about: (0.0, 0.0), angle: 0.01) }}),
                Load(name: \"hold\", increments: 1, particles: [(select: All, x: Held, y: Held)]),
              ])"
        ));
        both_laws(&scene, |_, records| {
            let along = DVec2::Y.rotate(DVec2::from_angle(0.05));
            let into = along.perp();
            let (mut force, mut moment) = (DVec2::ZERO, 0.0);
            for y in heights {
                let centre = DVec2::new(-0.01, y);
                let distance = centre.dot(into);
                let push = 1e7 * (0.01 - distance).max(0.0) * into;
                force += push;
                // The contact point is the middle of the overlap.
                let point = centre - into * (0.01 + 0.5 * (distance - 0.01));
                moment += point.perp_dot(push);
            }
            let last = probe(records.last().unwrap(), "wall");
            let found = DVec2::new(last.force[0], last.force[1]);
            assert!(found.distance(force) < 1e-6 * force.length(), "{shape}: {found} {force}");
            // The moment of the probe is about the middle of the first piece.
            let piece = if shape.starts_with("Poly") { 0.02 } else { 0.05 };
            assert_relative(last.force[2] + (piece * along).perp_dot(found), moment, 1e-6);
        });
    }
}

/// In a drum that turns under it a disk that cannot roll slides where the slope is the friction
/// coefficient: the moment on the drum is that of its weight.
#[test]
fn a_drum_turns_under_a_disk_that_slides() {
    let (radius, mu) = (0.1, 0.3_f64);
    let slope = mu.atan();
    let centre = (radius - 0.01) * DVec2::new(slope.sin(), -slope.cos());
    for (analysis, control) in [
        ("Static", "Rotation(about: (0.0, 0.0), angle: 0.002)"),
        ("Dynamic(dt: 1e-3)", "Spin(about: (0.0, 0.0), angular_velocity: 2.0)"),
    ] {
        let mut scene = parse(&format!(
            "(version: 1, title: \"drum\", analysis: {analysis}, gravity: (0.0, -9.81),
              materials: {{ \"m\": (density: 2000.0, contact: (friction: {mu:?})) }},
              specimen: Particles([(position: ({:?}, {:?}), radius: 0.01)]),
              walls: [(name: \"drum\", shape: Arc(through: (0.0, 0.1)), start: (0.0, -0.1), end: (0.0, -0.1),
                probe: \"drum\", contact: (friction: {mu:?}))],
              stages: [Load(name: \"turn\", increments: 300, {UPRIGHT}, walls: {{ \"drum\": {control} }})])",
            centre.x, centre.y
        ));
        scene.friction_law = FrictionLaw::COULOMB;
        let mut simulation = Simulation::new(&scene, None);
        let records: Vec<_> = std::iter::from_fn(|| next(&mut simulation)).collect();
        assert_eq!((simulation.run(), records.len()), (Outcome::Completed, 300), "{analysis}");
        let last = probe(records.last().unwrap(), "drum");
        let disk = states(&mut simulation)[0];
        let at = disk.position.x.atan2(-disk.position.y);
        // Forces are in equilibrium with the normal at the start of the increment, in which the disk
        // moves by a turn of 0.002 of the drum. In statics it sticks and slips: it is carried up until
        // no equilibrium is left, and a step of the motion that is followed then takes it down by at
        // most half of its radius.
        let turn = 1.01 * 0.002 * radius / (radius - 0.01);
        let slip = if analysis == "Static" { 0.5 * 0.01 / (radius - 0.01) } else { turn };
        assert!((slope - slip..slope + turn).contains(&at), "{analysis}: {at} {slope}");
        assert_relative(last.force[1], WEIGHT, 5e-3);
        assert_within(last.force[2], WEIGHT * radius * at.sin(), WEIGHT * radius * turn);
    }
}

/// Disks that are cemented to a plate go with it through a quarter turn, free of force.
#[test]
fn cemented_disks_turn_with_their_plate() {
    let bond = "normal_stiffness: 1e7, tangential_stiffness: 1e7, cohesion: 1e7, \
                tensile_strength: 1e7, rolling_friction: 0.5, friction: 0.5";
    let scene = parse(&format!(
        "(version: 1, title: \"clamp\", rupture: (rolling: Yields),
          materials: {{ \"m\": (density: 2000.0, bond: ({bond})) }},
          specimen: Particles([(position: (0.1, 0.01), radius: 0.01), (position: (0.1, 0.03), radius: 0.01)]),
          walls: [(name: \"plate\", shape: Segment, start: (0.0, 0.0), end: (0.2, 0.0), probe: \"plate\")],
          stages: [
            Cement(name: \"cement\", length: 1e-6, walls: true),
            Load(name: \"turn\", increments: 500,
                walls: {{ \"plate\": Rotation(about: (0.0, 0.0), angle: 0.0031415926535897933) }}),
          ])"
    ));
    both_laws(&scene, |simulation, records| {
        let last = probe(records.last().unwrap(), "plate");
        assert_within(last.motion[2], std::f64::consts::FRAC_PI_2, 1e-12);
        for (height, disk) in [0.01, 0.03].into_iter().zip(states(simulation)) {
            let error = disk.position.distance(DVec2::new(-height, 0.1));
            assert!(error < 2e-4, "{error}");
            assert_within(disk.rotation, std::f64::consts::FRAC_PI_2, 1e-2);
        }
    });
}

/// A wall that follows a table of angles is where the table says, at the start, in the middle and at
/// the end of a stage, in statics and in dynamics, whatever its shape.
#[test]
fn a_wall_follows_a_table_of_angles() {
    for (analysis, end) in [("Static", 1.0), ("Dynamic(dt: 1.0e-3)", 0.04)] {
        for shape in ["Line", "Segment", "Polyline([(0.0, 0.04)])", "Arc(through: (0.01, 0.05))"] {
            let scene = parse(&format!(
                "(version: 1, title: \"table\", analysis: {analysis},
                  materials: {{ \"m\": (density: 2000.0) }},
                  specimen: Particles([(position: (-0.5, 0.01), radius: 0.01)]),
                  walls: [(name: \"wall\", start: (0.0, 0.0), end: (0.0, 0.1), shape: {shape}, probe: \"wall\")],
                  stages: [
                    Load(name: \"turn\", increments: 40, particles: [(select: All, x: Held, y: Held)],
                        walls: {{ \"wall\": Follow(Rotation(about: (0.02, 0.0),
                            angle: [(0.0, 0.0), ({:?}, 0.3), ({:?}, 0.1), ({:?}, 0.1)])) }}),
                    Load(name: \"stay\", increments: 1, particles: [(select: All, x: Held, y: Held)]),
                  ])",
                0.25 * end, 0.75 * end, end
            ));
            let (records, _) = run(&scene);
            assert_eq!(records.len(), 41, "{analysis} {shape}");
            for (increment, angle) in
                [(5, 0.15), (10, 0.3), (20, 0.2), (30, 0.1), (35, 0.1), (41, 0.1)]
            {
                let wall = probe(&records[increment - 1], "wall");
                assert_within(wall.motion[2], angle, 1e-14);
                let middle = if shape.starts_with("Poly") { 0.02 } else { 0.05 };
                // The middle of an arc is that of its curve.
                let x = if shape.starts_with("Arc") { 0.01 } else { 0.0 };
                let start = DVec2::new(x - 0.02, middle);
                let moved = DVec2::from_angle(angle).rotate(start) - start;
                assert!(
                    DVec2::new(wall.motion[0], wall.motion[1]).distance(moved) < 1e-14,
                    "{shape}"
                );
            }
        }
    }
}

/// The normal and the tangent of a wall that turns are those along which its contacts carry: without
/// friction there is no force along the tangent, however far it turns in an increment.
#[test]
fn a_smooth_wall_that_turns_carries_along_its_normal_alone() {
    let scene = parse(
        "(version: 1, title: \"smooth\",
          materials: { \"m\": (density: 2000.0, contact: (normal_stiffness: 1e7)) },
          specimen: Particles([(position: (-0.01, 0.03), radius: 0.01), (position: (-0.01, 0.07), radius: 0.01)]),
          walls: [(name: \"wall\", start: (0.0, 0.0), end: (0.0, 0.1), contact: (normal_stiffness: 1e7))],
          stages: [
            Load(name: \"push\", increments: 5, particles: [(select: All, x: Held, y: Held)],
                walls: { \"wall\": Rotation(about: (0.0, 0.0), angle: 0.02) }),
            Load(name: \"hold\", increments: 1, particles: [(select: All, x: Held, y: Held)]),
          ],
          measures: [
            (name: \"normal_n\", of: WallForce(wall: \"wall\", along: Normal)),
            (name: \"tangent_n\", of: WallForce(wall: \"wall\", along: Tangent)),
            (name: \"x_n\", of: WallForce(wall: \"wall\", along: X)),
            (name: \"y_n\", of: WallForce(wall: \"wall\", along: Y)),
            (name: \"axial_stress\", of: Stress(Walls(walls: [\"wall\"], length: Fixed(1.0)))),
          ])",
    );
    let mut simulation = Simulation::new(&scene, None);
    let mut count = 0;
    while next(&mut simulation).is_some() {
        let read = |name: &str| clastic::run::measures::reading(simulation.world(), name).unwrap();
        let [normal, tangent, x, y] = ["normal_n", "tangent_n", "x_n", "y_n"].map(read);
        assert!(normal > 1e3, "{normal}");
        assert_within(tangent, 0.0, 1e-12 * normal);
        assert_relative(x.hypot(y), normal, 1e-12);
        assert_relative(read("axial_stress"), normal, 1e-12);
        count += 1;
    }
    assert_eq!(count, 6);
}

/// Disks that are held press a rough plate and shear it; it turns by a large angle, and is then to
/// carry a force. The force starts from the sum of the normal forces of the contacts. Along the
/// present normal the force would include a part of the friction, in proportion to the angle.
#[test]
fn a_force_after_a_turn_starts_from_the_normal_forces() {
    let held = "particles: [(select: All, x: Held, y: Held, rotation: Held)]";
    let mut errors = Vec::new();
    for angle in [0.002, 0.001] {
        let scene = plate(
            "Static",
            ELASTIC,
            &format!(
                "Load(name: \"press\", increments: 1, particles: [(select: All,
                    x: Displacement(1.0e-4), y: Displacement(-5.0e-4), rotation: Held)]),
                 Load(name: \"turn\", increments: 1, {held},
                    walls: {{ \"plate\": Rotation(about: (0.0, 0.0), angle: {angle:?}) }}),
                 Load(name: \"carry\", increments: 1, {held}, walls: {{ \"plate\": Force(1.0e4) }})"
            ),
        );
        let mut simulation = Simulation::new(&scene, None);
        next(&mut simulation).unwrap();
        next(&mut simulation).unwrap();
        let world = simulation.world_mut();
        let normal: f64 = world.resource::<ContactHistory>().0.iter().map(|c| c.p).sum();
        let mut walls = world.query::<(&Wall, &BodyExternalForce)>();
        let (wall, force) = walls.single(world).unwrap();
        let present = DVec2::new(force.0[0], force.0[1]).dot(wall.inward());
        next(&mut simulation).unwrap();
        let world = simulation.world_mut();
        let mut walls = world.query::<&WallControl>();
        let WallControl::Force { from, .. } = *walls.single(world).unwrap() else { panic!() };
        assert_relative(from, normal, 1e-9);
        errors.push(present / normal - 1.0);
    }
    // A force along the present normal has an error of first order.
    println!("{errors:?}");
    assert!(errors[0].abs() > 1e-5 && (errors[0] / errors[1] - 2.0).abs() < 0.5, "{errors:?}");
}
