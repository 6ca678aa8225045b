//! Excavations: tractions that stay as loads and are released, loose particles, and rings around holes.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use bevy_ecs::prelude::With;
use clastic::components::body::{BodyId, BodyPosition, LoadControl};
use clastic::components::measure::Readings;
use clastic::components::membrane::Membrane;
use clastic::components::particle::Particle;
use clastic::run::{CollapsedBy, Outcome, Simulation};
use clastic::scene::format::Scene;
use glam::DVec2;

use crate::common::*;

/// Disks under a pressure in a box, cemented where `cement` is a stage, that stand still when `stages`
/// begin.
fn ground(law: &str, cement: &str, stages: &str) -> String {
    let wall = |name: &str, start: &str, end: &str| {
        format!(
            "(name: \"{name}\", start: {start}, end: {end}, contact: (normal_stiffness: 2.0e7))"
        )
    };
    format!(
        "(version: 1, title: \"ground\", friction_law: {law}, let: {{ \"p\": 2.0e4 }},
          materials: {{ \"m\": (density: 2000.0,
            contact: (normal_stiffness: 2.0e7, tangential_stiffness: 1.0e7, friction: 0.5),
            bond: (normal_stiffness: 2.0e7, tangential_stiffness: 1.0e7, friction: 0.5,
                cohesion: 1.0e7, tensile_strength: 1.0e7)) }},
          groups: {{ \"loose\": Loose(2) }},
          specimen: Packing(count: 144, columns: 12, spacing: 10.1e-3, seed: 2,
            sizes: Uniform(radius: (3.0e-3, 5.0e-3))),
          walls: [{}, {}, {}, {}],
          stages: [
            Compact(name: \"compact\", wall: \"top\", base: \"bottom\", target: Jammed, step: 1.0e-3,
                agitation: 0.1, seed: 1), {cement}
            Load(name: \"press\", increments: 5, walls: {{
                \"top\": Stress(stress: p, between: (\"left\", \"right\")),
                \"right\": Stress(stress: p, between: (\"bottom\", \"top\")) }}),
            Load(name: \"stand\", increments: 10), {stages}])",
        wall("bottom", "(0.0, 0.0)", "(0.1212, 0.0)"),
        wall("right", "(0.1212, 0.0)", "(0.1212, 0.13)"),
        wall("top", "(0.1212, 0.13)", "(0.0, 0.13)"),
        wall("left", "(0.0, 0.13)", "(0.0, 0.0)"),
    )
}

const CEMENT: &str = "Cement(name: \"cement\", length: 0.2e-3),";

const HOLE: &str = "Circle(centre: (0.06, 0.05), radius: 0.015)";

/// Displacements of the particles that are left at the end, m, since the end of the stage `stand`.
fn moved(scene: &Scene) -> BTreeMap<BodyId, DVec2> {
    let mut simulation = Simulation::new(scene, None);
    let places = |simulation: &mut Simulation| -> BTreeMap<BodyId, DVec2> {
        let world = simulation.world_mut();
        let mut all = world.query_filtered::<(&BodyId, &BodyPosition), With<Particle>>();
        all.iter(world).map(|(id, x)| (*id, x.0)).collect()
    };
    let mut start = BTreeMap::new();
    while let Some(record) = next(&mut simulation) {
        if record.stage == "stand" {
            start = places(&mut simulation);
        }
    }
    assert_eq!(simulation.run(), Outcome::Completed);
    places(&mut simulation).into_iter().map(|(id, x)| (id, x - start[&id])).collect()
}

fn maximum(moved: &BTreeMap<BodyId, DVec2>) -> f64 {
    moved.values().map(|u| u.length()).fold(0.0, f64::max)
}

/// Under the tractions of the part that is gone nothing moves: with and without bonds, under both laws of
/// friction, in statics and in dynamics. Without them the wall of the hole moves a million times further.
#[test]
fn nothing_moves_before_tractions_are_released() {
    for cement in [CEMENT, ""] {
        for law in ["Associated", "Coulomb()"] {
            let dig = |keep: bool, analysis: &str| {
                let stages = format!(
                    "Remove(name: \"dig\", select: {HOLE}, keep_tractions: {keep}),
                     Remove(name: \"scale\", select: Loose(2), keep_tractions: {keep}),
                     Load(name: \"hold\", increments: 3 {analysis})"
                );
                maximum(&moved(&parse(&ground(law, cement, &stages))))
            };
            let released = dig(false, "");
            let held = dig(true, "");
            let in_time = dig(true, ", analysis: Dynamic(dt: 1.0e-4)");
            assert!(released > 1e-6, "{released}");
            assert!(held < 1e-6 * released && in_time < 1e-6 * released, "{held} {in_time}");
        }
    }
}

/// Elastic ground ends in the same state whether the tractions go at once, in a stage, or in two stages
/// with a part that remains between: equilibrium does not depend on the path. Closure is in proportion to
/// what is released.
#[test]
fn closure_of_elastic_ground_is_in_proportion_to_what_is_released() {
    // A lattice, in which no grain hangs on a bond or two.
    let packed = |scene: &str| {
        let (head, rest) = scene.split_once("specimen:").unwrap();
        let (_, rest) = rest.split_once("walls:").unwrap();
        let (walls, rest) = rest.split_once("Compact(").unwrap();
        let (_, stages) = rest.split_once("Cement(").unwrap();
        let lattice = "Lattice(columns: 12, rows: 13, radius: 5.0e-3, origin: (5.0e-3, 5.0e-3))";
        let text = format!("{head} specimen: {lattice}, walls: {walls} Cement({stages}");
        parse(&text.replace("0.1212", "0.12").replace("0.13)", "0.114)"))
    };
    let dig = |keep: bool, stages: &str| {
        let dig = format!("Remove(name: \"dig\", select: {HOLE}, keep_tractions: {keep})");
        moved(&packed(&ground("Associated", CEMENT, &format!("{dig}, {stages}"))))
    };
    let release = |name: &str, remains: f64| {
        format!(
            "Load(name: \"{name}\", increments: 2, particles: [(select: All, remains: {remains:?})])"
        )
    };
    let at_once = dig(false, "Load(name: \"release\", increments: 2)");
    let in_a_stage = dig(true, &release("release", 0.0));
    let part = dig(true, &release("part", 0.4));
    let in_two = dig(true, &format!("{}, {}", release("part", 0.4), release("rest", 0.0)));
    // All of it in the first of two increments.
    let early = dig(
        true,
        "Load(name: \"release\", increments: 2, particles: [(select: All, remains: 0.0)],
            scale: (loads: [(0.0, 0.0), (0.5, 1.0)]))",
    );
    let far = maximum(&at_once);
    for (id, whole) in &at_once {
        assert!((in_a_stage[id] - *whole).length() < 1e-3 * far, "{id:?}");
        assert!((in_two[id] - *whole).length() < 1e-3 * far, "{id:?}");
        assert!((early[id] - *whole).length() < 1e-3 * far, "{id:?}");
        assert!((part[id] - 0.6 * *whole).length() < 1e-3 * far, "{id:?}");
    }
}

/// Four disks around a fifth, each pressed towards it with F: the closure of the ring is F/k, and the
/// force on it -4F over the circumference of its inner circle.
#[test]
fn a_ring_reads_its_closure_and_its_support() {
    let (force, stiffness) = (50.0, 1.0e6);
    let around = [(0.02, 0.0), (0.0, 0.02), (-0.02, 0.0), (0.0, -0.02)];
    let disks: String =
        around.iter().map(|(x, y)| format!("(position: ({x:?}, {y:?}), radius: 0.01),")).collect();
    let loads: String = around
        .iter()
        .enumerate()
        .map(|(i, (x, y))| {
            let load = (-force * x / 0.02, -force * y / 0.02);
            format!("(select: Index([{}]), force: {load:?}, rotation: Held),", i + 1)
        })
        .collect();
    let scene = parse(&format!(
        "(version: 1, title: \"ring\", thickness: 2.0,
          materials: {{ \"m\": (contact: (normal_stiffness: {stiffness:?},
            tangential_stiffness: {stiffness:?}, friction: 0.5)) }},
          specimen: Particles([(position: (0.0, 0.0), radius: 0.01), {disks}]),
          stages: [Load(name: \"press\", increments: 2,
            particles: [(select: Index([0]), x: Held, y: Held, rotation: Held), {loads}])],
          measures: [
            (name: \"closure\", of: Ring(centre: (0.0, 0.0), radii: (0.015, 0.03), value: Closure)),
            (name: \"support\", of: Ring(centre: (0.0, 0.0), radii: (0.015, 0.03), value: Support)),
          ])"
    ));
    let mut simulation = Simulation::new(&scene, None);
    while next(&mut simulation).is_some() {}
    let read = &simulation.world().resource::<Readings>().0;
    assert_relative(read[0].unwrap(), force / stiffness, 1e-6);
    assert_relative(read[1].unwrap(), -4.0 * force / (TAU * 0.015 * 2.0), 1e-9);
}

/// Their columns were empty without a word.
#[test]
fn measures_of_no_particle_are_refused_where_they_begin() {
    let pair = |of: &str| {
        parse(&format!(
            "(version: 1, title: \"pair\", materials: {{ \"m\": () }},
              specimen: Particles([(position: (0.0, 0.0), radius: 1.0), (position: (3.0, 0.0), radius: 1.0)]),
              stages: [Load(name: \"rest\", increments: 1)],
              measures: [(name: \"time\", of: Time), (name: \"none\", of: {of})])"
        ))
    };
    let far = "select: Circle(centre: (9.0, 9.0), radius: 1.0)";
    for (of, said) in [
        (
            "Ring(centre: (0.0, 0.0), radii: (5.0, 6.0), value: Support)".to_owned(),
            "measures[1].of.radii",
        ),
        (format!("GroupForce({far})"), "measures[1].of.select"),
    ] {
        let Outcome::Refused { stage, message } = Simulation::new(&pair(&of), None).run() else {
            panic!("{of}");
        };
        assert!(
            stage == "rest" && message.contains(said) && message.contains("`none`"),
            "{message}"
        );
    }
    let live = pair(&format!("GroupForce({far}, live: true)"));
    assert!(matches!(Simulation::new(&live, None).run(), Outcome::Completed));
}

/// A bonded block with a tail of three disks, and a disk by itself. `Loose(1)` is what nothing holds, and
/// `Loose(2)` also what comes off once its end is gone.
#[test]
fn loose_particles_are_those_that_too_few_contacts_hold() {
    let block = [(0.0, 0.0), (0.02, 0.0), (0.0, 0.02), (0.02, 0.02)];
    let tail = [(0.04, 0.0), (0.06, 0.0), (0.08, 0.0)];
    let disks: String = block
        .into_iter()
        .chain(tail)
        .chain([(0.2, 0.0)])
        .map(|(x, y)| format!("(position: ({x:?}, {y:?}), radius: 0.01),"))
        .collect();
    for (contacts, left) in [(1, 7), (2, 4)] {
        let scene = parse(&format!(
            "(version: 1, title: \"loose\", materials: {{ \"m\": (contact: (normal_stiffness: 1.0e6),
                bond: (normal_stiffness: 1.0e6, cohesion: 1.0e6, tensile_strength: 1.0e6)) }},
              specimen: Particles([{disks}]),
              stages: [Cement(name: \"cement\", length: 1.0e-4),
                Remove(name: \"scale\", select: Loose({contacts})),
                Remove(name: \"again\", select: Loose({contacts}))])"
        ));
        let mut simulation = Simulation::new(&scene, None);
        assert_eq!(simulation.run(), Outcome::Completed);
        assert_eq!(states(&mut simulation).len(), left, "Loose({contacts})");
    }
}

#[test]
fn tractions_that_cannot_stay_are_refused_when_the_stage_begins() {
    let refused = |stages: &str| {
        let mut simulation = Simulation::new(&parse(&ground("Associated", "", stages)), None);
        match simulation.run() {
            Outcome::Refused { message, .. } => message,
            other => panic!("{other:?}"),
        }
    };
    let at = |x: f64| {
        let circle = format!("Circle(centre: ({x:?}, 0.05), radius: 0.015)");
        refused(&format!("Remove(name: \"dig\", select: {circle}, keep_tractions: true)"))
    };
    let loaded = at(0.12);
    assert!(loaded.contains("stage `dig` cannot begin") && loaded.contains("`right`"), "{loaded}");
    let wrapped = refused(
        "Load(name: \"wrap\", increments: 1, walls: { \"top\": Fixed, \"bottom\": Fixed },
            remove_walls: [\"left\", \"right\"],
            membranes: { \"skin\": (pressure: p, between: (\"bottom\", \"top\")) }),
         Remove(name: \"dig\", select: Circle(centre: (0.0, 0.05), radius: 0.015), keep_tractions: true)",
    );
    assert!(wrapped.contains("the membrane `skin` presses"), "{wrapped}");
    let none =
        refused("Load(name: \"release\", increments: 1, particles: [(select: All, remains: 0.5)])");
    assert!(none.contains("particles[0].remains") && none.contains("have none"), "{none}");
}

/// The wall on the left is held and drawn longer than the specimen is high. A membrane once started from
/// its force over the drawn length, and let the specimen go slack.
#[test]
fn a_membrane_starts_from_the_stress_of_the_walls_that_it_replaces() {
    let wrap = "Load(name: \"wrap\", increments: 4, walls: { \"top\": Fixed, \"bottom\": Fixed },
        remove_walls: [\"left\", \"right\"],
        membranes: { \"skin\": (pressure: 3.0e4, between: (\"bottom\", \"top\")) })";
    let mut simulation = Simulation::new(&parse(&ground("Associated", "", wrap)), None);
    while let Some(record) = next(&mut simulation) {
        if record.stage == "wrap" {
            break;
        }
    }
    let world = simulation.world_mut();
    let before = world.query::<&Membrane>().single(world).unwrap().pressure.0;
    assert_relative(before, 2.0e4, 1e-3);
}

/// Loads of the particles at the end of a run, by particle: force (N) and moment (N m).
fn loads(scene: &Scene) -> BTreeMap<BodyId, [f64; 3]> {
    let mut simulation = Simulation::new(scene, None);
    assert_eq!(simulation.run(), Outcome::Completed);
    let world = simulation.world_mut();
    let mut all = world.query_filtered::<(&BodyId, &LoadControl), With<Particle>>();
    all.iter(world).map(|(id, load)| (*id, load.0.map(|(_, now)| now))).collect()
}

const HOLD: &str = "Load(name: \"hold\", increments: 1,
    particles: [(select: All, x: Held, y: Held, rotation: Held)])";

/// A bond that broke in the last increment carried 20 N in it, and carries nothing now.
#[test]
fn a_bond_that_has_just_broken_leaves_no_traction() {
    let loads_of = |pulled: f64| {
        loads(&parse(&format!(
            "(version: 1, title: \"pair\", rupture: (order: OneRound),
              materials: {{ \"m\": (density: 2000.0,
                contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.5),
                bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.5,
                    cohesion: 1.0e3, tensile_strength: 1.0e3)) }},
              specimen: Particles([(position: (0.0, 0.0), radius: 0.01), (position: (0.02, 0.0), radius: 0.01)]),
              stages: [Cement(name: \"cement\", length: 1.0e-4),
                Load(name: \"pull\", increments: 1, particles: [
                    (select: Index([0]), x: Held, y: Held, rotation: Held),
                    (select: Index([1]), x: Displacement({pulled:?}), y: Held, rotation: Held)]),
                Remove(name: \"dig\", select: Index([0]), keep_tractions: true), {HOLD}])"
        )))
    };
    // It breaks at 2 r 1 kPa = 20 N, an elongation of 20 um.
    let [intact, broken] = [1.0e-5, 3.0e-5].map(|pulled| loads_of(pulled)[&BodyId(1)]);
    assert!((intact[0] + 10.0).abs() < 1e-6, "{intact:?}");
    assert_eq!(broken, [0.0; 3]);
}

/// What touched across the side of a cell that has ended leaves no tractions on the other side.
#[test]
fn contacts_across_the_sides_of_a_cell_end_with_it() {
    let loads = loads(&parse(&format!(
        "(version: 1, title: \"cell\", let: {{ \"p\": 2.0e4 }},
          materials: {{ \"m\": (density: 2000.0,
            contact: (normal_stiffness: 2.0e7, tangential_stiffness: 1.0e7, friction: 0.5)) }},
          specimen: Packing(count: 100, columns: 10, spacing: 10.1e-3, seed: 2,
            sizes: Uniform(radius: (3.0e-3, 5.0e-3))),
          cell: (size: (0.101, 0.101)),
          stages: [
            Compact(name: \"compact\", target: Jammed, step: 1.0e-3, agitation: 0.1, seed: 1),
            Load(name: \"press\", increments: 5, cell: (xx: Stress(p), yy: Stress(p))),
            Remove(name: \"open\", open_cell: true, select: Box(min: (0.0, 0.0), max: (0.01, 0.01))),
            Remove(name: \"dig\", select: Box(min: (-1.0, -1.0), max: (0.02, 1.0)), keep_tractions: true),
            {HOLD}])"
    )));
    let loaded: Vec<_> = loads.iter().filter(|(_, load)| **load != [0.0; 3]).collect();
    assert!(loaded.len() > 3, "{loaded:?}");
    // What is dug presses to the right.
    assert!(loaded.iter().all(|(_, [x, ..])| *x > 0.0), "{loaded:?}");
}

/// A group of loose particles may be a part of a selection.
#[test]
fn a_group_of_loose_particles_is_known_when_the_stage_begins() {
    let scale = format!(
        "Remove(name: \"dig\", select: {HOLE}, keep_tractions: true),
         Remove(name: \"scale\", select: Intersection([Group(\"loose\"), Circle(centre: (0.06, 0.05), radius: 0.03)]),
            keep_tractions: true),
         Remove(name: \"none\", select: Group(\"loose\")), {HOLD}"
    );
    let left = loads(&parse(&ground("Associated", CEMENT, &scale))).len();
    assert!(left < 144, "{left}");
}

/// A grain falls on a bonded bridge that carries itself and not the grain. The mechanism of the state at
/// hand moves the grain alone, and the bridge falls in the motion that follows.
#[test]
fn a_collapse_says_what_the_mechanism_moves_and_what_the_motion_moves() {
    let weight = 2000.0 * PI * 0.01 * 0.01 * 9.81;
    let bridge: String = (0..7)
        .map(|k| format!("(position: ({:?}, 0.0), radius: 0.01),", 0.02 * f64::from(k)))
        .collect();
    // Each end carries 2.5 weights of the bridge, and 3 with the grain.
    let cohesion = 2.7 * weight / 0.02;
    let stages = |floor: &str| {
        parse(&format!(
            "(version: 1, title: \"bridge\", gravity: (0.0, -9.81),
              materials: {{ \"m\": (density: 2000.0,
                contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.5),
                bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, rolling_friction: 1.0e3,
                    cohesion: {cohesion:?}, tensile_strength: {cohesion:?})) }},
              specimen: Particles([{bridge} (position: (0.06, 0.03), radius: 0.01)]),
              walls: [{floor}],
              stages: [Cement(name: \"cement\", length: 1.0e-4),
                Load(name: \"stand\", increments: 1,
                    particles: [(select: Index([0, 6]), x: Held, y: Held, rotation: Held)])])"
        ))
    };
    let (_, outcome) = run(&stages(""));
    let Outcome::Collapsed(collapse) = outcome else { panic!("{outcome:?}") };
    // The mechanism is that of the grain, and what falls in the end is the bridge.
    assert_eq!(collapse.by, CollapsedBy::Proof, "{}", collapse.reason);
    for share in [
        "it moves 1 of 8 particles (12.5 % of the mass)",
        "the motion moved 6 of 8 particles (75.0 % of the mass)",
    ] {
        assert!(collapse.reason.contains(share), "{}", collapse.reason);
    }
    let floor = "(name: \"floor\", start: (-1.0, -0.05), end: (1.0, -0.05), contact: (normal_stiffness: 1.0e6, friction: 0.5))";
    let (records, outcome) = run(&stages(floor));
    assert_eq!(outcome, Outcome::Completed);
    assert!(records.last().unwrap().broken.iter().sum::<usize>() >= 2);
}

/// Measures at the end of each stage, and the strains as `yy` and `xx`.
fn read_by_stage(scene: &Scene) -> BTreeMap<String, BTreeMap<String, f64>> {
    let mut simulation = Simulation::new(scene, None);
    let mut read = BTreeMap::new();
    while let Some(record) = next(&mut simulation) {
        let named = simulation.world().resource::<Readings>().0.clone();
        let names = scene.further_measures().map(|measure| measure.name.clone());
        let mut of: BTreeMap<_, _> =
            names.zip(named.into_iter().map(Option::unwrap_or_default)).collect();
        of.insert("yy".into(), record.axial_strain.unwrap_or_default());
        of.insert("xx".into(), record.lateral_strain.unwrap_or_default());
        read.insert(record.stage.clone(), of);
    }
    assert_eq!(simulation.run(), Outcome::Completed);
    read
}

/// A lining that comes at half of the support carries the thrust at which the reaction curve of the
/// ground, a straight line, meets the line of the ring: the comment of the scene.
#[test]
fn a_lining_carries_the_thrust_at_which_the_curves_meet() {
    let read = read_by_stage(&load("tunnel_lining"));
    let of = |stage: &str, name: &str| read[stage][name];
    let (stiffness, ring) = (3.0e9, 1.54);
    let r = 0.999 * ring * (PI / 24.0).sin();
    let thrust = ["right", "top", "left", "bottom"]
        .map(|side| 2.0 * r * of("rest", &format!("thrust_{side}_pa")))
        .iter()
        .sum::<f64>()
        / 4.0;
    let before = of("part", "closure_m");
    let load = 2.0 * of("still", "support_pa");
    let line = 2.0 * stiffness * r / ring;
    let meet = line * before / (1.0 + 2.0 * line * before / load);
    assert_relative(thrust, meet, 0.15);
    let left = load * (1.0 - of("rest", "closure_m") / (2.0 * before));
    assert_relative(thrust, left, 0.15);
    // Disks that come into the hole and bonds across gaps move nothing.
    assert_relative(of("24", "closure_m"), before, 1e-6);
}

/// The wall of a hole in an infinite elastic plane under the pressure p closes by `p a / 2G` as p is released
/// (Kirsch); in a ring up to the radius b under a constant pressure (Lamé) by a little more. E and nu are those
/// of the same ground, and a is the radius at which the tractions are those of p.
#[test]
fn a_tunnel_closes_as_kirsch_says() {
    let read = read_by_stage(&load("tunnel"));
    let of = |stage: &str, name: &str| read[stage][name];
    let change = |name: &str| of("load", name) - of("stand", name);
    let (yy, xx) = (of("load", "yy"), of("load", "xx"));
    let shear = (change("yy_pa") - change("xx_pa")) / (2.0 * (yy - xx));
    let bulk = (change("yy_pa") + change("xx_pa")) / (2.0 * (yy + xx));
    let nu = (bulk - shear) / (bulk + shear);
    let pressure = 0.5 * (of("stand", "yy_pa") + of("stand", "xx_pa"));
    let a = 2.0 * of("still", "support_pa") / pressure;
    let (width, height) = (15.965, 15.6);
    let b = (width * height / PI).sqrt();
    for (name, r) in [("closure_m", 2.2), ("outer_closure_m", 3.5)] {
        let closure = of("release", name) - of("still", name);
        let kirsch = pressure * a * a / (2.0 * shear * r);
        let ring = ((1.0 - nu) / (1.0 + nu) * (r / b).powi(2) + 1.0) / (1.0 - (a / b).powi(2));
        assert_relative(closure, kirsch * ring, 0.1);
        assert!(of("still", name).abs() < 1e-3 * closure);
    }
    assert!(of("release", "support_pa").abs() < 1e-9 * pressure);
}
