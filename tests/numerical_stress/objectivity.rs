//! Objectivity: a bonded beam turned by a full turn, in few large increments and in many.

use clastic::components::contact::BodyTable;
use clastic::cone::program::ConeSolution;
use clastic::run::Simulation;
use clastic::scene::format::{Motion, ParticleControl, Scene, Select, Stage};
use glam::DVec2;

use crate::common::{assert_within, next, parse, states};

const RADIUS: f64 = 5e-3;
const DISKS: u32 = 8;

/// Eight bonded disks in a row. The first two are led around the origin by `turn` in as many
/// increments as said, a stage each: the others follow through the bonds, whose strength would bear
/// a stretch of 1e-4 of a radius.
fn beam(turn: f64, increments: u32) -> Scene {
    let mut disks = String::new();
    let mut bonds = String::new();
    for k in 0..DISKS {
        disks +=
            &format!("(position: ({:?}, 0.0), radius: {RADIUS:?}),", 2.0 * RADIUS * f64::from(k));
        if k > 0 {
            bonds += &format!("(a: {}, b: {k}),", k - 1);
        }
    }
    // k = 1 MN/m: f_t = 2 r sigma = 0.5 N at a stretch of 0.5 um.
    let mut scene = parse(&format!(
        "(
            version: 1,
            title: \"beam turned in {increments} increments\",
            acceptance: (turn: 100.0),
            materials: {{ \"glue\": (bond: (normal_stiffness: 1.0e6, tangential_stiffness: 0.5e6,
                friction: 0.5, rolling_friction: 0.1, cohesion: 5.0e2, tensile_strength: 5.0e1)) }},
            specimen: Particles([{disks}]),
            bonds: [{bonds}],
            stages: [Load(name: \"turn\", increments: 1)],
        )"
    ));
    let Some(Stage::Load(template)) = scene.stages.pop() else { unreachable!() };
    for n in 0..increments {
        let angle = |n: u32| turn * f64::from(n) / f64::from(increments);
        let step = |x: f64| x * (DVec2::from_angle(angle(n + 1)) - DVec2::from_angle(angle(n)));
        let mut stage = template.clone();
        stage.name = format!("turn {n}");
        stage.particles = (0..2)
            .map(|k| {
                let u = step(2.0 * RADIUS * f64::from(k));
                ParticleControl {
                    select: Select::Index(vec![k]),
                    x: Motion::Displacement(u.x),
                    y: Motion::Displacement(u.y),
                    rotation: Motion::Displacement(angle(n + 1) - angle(n)),
                    affine: None,
                    force: None,
                    moment: None,
                    remains: None,
                }
            })
            .collect();
        scene.stages.push(Stage::Load(stage));
    }
    scene
}

struct Turned {
    /// Maximum stretch of a bond, and distance of a disk from where it should be, over a radius.
    stretch: f64,
    off: f64,
    broken: usize,
    solves: u32,
    halved: bool,
}

fn turned(scene: &Scene, turn: f64) -> Turned {
    let mut simulation = Simulation::new(scene, None);
    let (mut stretch, mut broken, mut solves, mut halved) = (0.0_f64, 0, 0, false);
    while let Some(record) = next(&mut simulation) {
        halved |= record.fraction < 1.0;
        broken = record.broken.iter().sum();
        solves += record.solves;
        for pair in states(&mut simulation).windows(2) {
            let gap = pair[0].position.distance(pair[1].position) - 2.0 * RADIUS;
            stretch = stretch.max(gap.abs() / RADIUS);
        }
    }
    let off = states(&mut simulation)
        .iter()
        .enumerate()
        .map(|(k, s)| {
            let x = 2.0 * RADIUS * k as f64 * DVec2::from_angle(turn);
            (s.position - x).length().max(RADIUS * (s.rotation - turn).abs()) / RADIUS
        })
        .fold(0.0, f64::max);
    Turned { stretch, off, broken, solves, halved }
}

/// With the normals of the start ten increments would stretch the bonds by 0.4 radii and break
/// them.
#[test]
fn a_beam_turns_as_a_rigid_body_in_ten_increments() {
    let full_turn = std::f64::consts::TAU;
    for n in [10, 20, 100] {
        let t = turned(&beam(full_turn, n), full_turn);
        println!(
            "{n} increments: stretch {:.1e}, off {:.1e} radii, {} solves",
            t.stretch, t.off, t.solves
        );
        assert!(!t.halved, "an increment was halved");
        assert_eq!(t.broken, 0);
        assert_within(t.stretch, 0.0, 1e-6);
        assert_within(t.off, 0.0, 1e-5);
    }
}

/// With the normals of the start the momentum of a wheel that turns by 0.02 rad an increment
/// changes by more than 1e-4.
#[test]
fn a_wheel_keeps_its_angular_momentum_for_every_theta() {
    for theta in [0.5, 0.75, 1.0] {
        let scene = crate::common::wheel(2e-3, theta, 50);
        let mut simulation = Simulation::new(&scene, None);
        let of = |simulation: &mut Simulation| {
            states(simulation)
                .iter()
                .map(|s| s.mass * s.position.perp_dot(s.velocity) + s.inertia * s.spin)
                .sum::<f64>()
        };
        let start = of(&mut simulation);
        while next(&mut simulation).is_some() {}
        assert!(simulation.world().resource::<BodyTable>().bonds.len() == 12);
        assert!(!simulation.world().resource::<ConeSolution>().forces.is_empty());
        let change = of(&mut simulation) / start - 1.0;
        println!("theta {theta}: {change:.1e}");
        assert_within(change, 0.0, 1e-10);
    }
}
