//! Objectivity: a bonded beam turned by a full turn, in few large increments and in many.

use clastic::run::Simulation;
use clastic::scene::format::{Motion, ParticleControl, Scene, Select, Stage};
use glam::DVec2;

use crate::common::{State, assert_within, next, parse, states};
use crate::random::full;

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
            acceptance: (throw: 100.0),
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
                }
            })
            .collect();
        scene.stages.push(Stage::Load(stage));
    }
    scene
}

/// Maximum stretch of a bond over a radius, and stretch of the first bond that is not led, at the
/// end.
fn stretched(scene: &Scene) -> [f64; 2] {
    let mut simulation = Simulation::new(scene, None);
    let stretch =
        |pair: &[State]| (pair[0].position.distance(pair[1].position) - 2.0 * RADIUS) / RADIUS;
    let mut maximum = 0.0_f64;
    while next(&mut simulation).is_some() {
        let of_bonds = states(&mut simulation);
        maximum = of_bonds.windows(2).map(|pair| stretch(pair).abs()).fold(maximum, f64::max);
    }
    [maximum, stretch(&states(&mut simulation)[1..3])]
}

/// Too strong to break: what a frozen normal does to the distance, L alpha^2/2 an increment.
#[test]
fn stretch_of_a_turned_beam_falls_with_the_square_of_the_increment() {
    let full_turn = std::f64::consts::TAU;
    let stretch = |n: u32| {
        let mut scene = beam(full_turn, n);
        let bond = scene.materials.get_mut("glue").unwrap().bond.as_mut().unwrap();
        (bond.cohesion, bond.tensile_strength, bond.rolling_friction) = (1e12, 1e12, 0.0);
        let [maximum, first] = stretched(&scene);
        assert!(maximum <= 2.0 * first.abs(), "{maximum} and {first}");
        first
    };
    let mut last = None;
    let counts: &[u32] = if full(0, 1) == 1 { &[10, 100, 1000] } else { &[10, 100] };
    for &n in counts {
        // L = 2 r: L alpha^2/2 over a radius.
        let alpha = full_turn / f64::from(n);
        let (found, expected) = (stretch(n), alpha * alpha);
        println!("{n} increments: stretch {found:.2e} radii, L alpha^2/2 = {expected:.2e}");
        if n >= 100 {
            assert_within(found / expected, 1.0, 0.03);
        }
        if let Some(last) = last {
            assert!(found < 0.02 * last);
        }
        last = Some(found);
    }
}
