//! From stage to stage: loads, walls and bonds that a stage leaves to the next one, and the ends of
//! stages.

use crate::common::*;
use clastic::components::bond::Bond;
use clastic::components::observation::Observation;
use clastic::run::EndedBy;
use clastic::run::stages::Script;
use clastic::run::state::StateView;
use clastic::run::{Outcome, Simulation, StageEnd, changes};
use clastic::scene::format::{FrictionLaw, Scene};

/// A disk between a floor and a lid; the rest is the stages and, if any, measures.
fn pressed(rest: &str) -> String {
    format!(
        r#"(
            version: 1, title: "pressed",
            materials: {{ "stone": (contact: (normal_stiffness: 1.0e6)) }},
            specimen: Particles([(position: (0.0, 0.5), radius: 0.5, probe: "disk")]),
            walls: [
                (name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), probe: "floor",
                    contact: (normal_stiffness: 1.0e6)),
                (name: "lid", start: (1.0, 1.0), end: (-1.0, 1.0), probe: "lid",
                    contact: (normal_stiffness: 1.0e6)),
            ],
            {rest}
        )"#
    )
}

fn records(text: &str) -> Vec<Observation> {
    run(&parse(text)).0
}

/// After a compaction, of which the check of a scene knows no distance, elastic walls went on through
/// each other.
#[test]
fn walls_do_not_pass_each_other_after_a_compaction() {
    let text = pressed(
        r#"stages: [
            Compact(name: "compact", wall: "lid", base: "floor", target: Height(1.0), step: 0.1),
            Load(name: "lower", increments: 2, walls: { "lid": Displacement(0.0, -0.3) }),
            Load(name: "on", increments: 3, walls: { "lid": Displacement(0.0, -0.3) }),
        ],"#,
    );
    let mut scene = parse(&text);
    let lid = &mut scene.walls[1];
    (lid.start.1, lid.end.1) = (2.0, 2.0);
    let Outcome::Halted(message) = Simulation::new(&scene, None).run() else { panic!() };
    let said = "in stage `on`: wall `floor` and wall `lid` would meet or pass each other";
    assert!(message.contains(said), "{message}");
}

#[test]
fn loads_of_a_stage_that_ends_early_go_on_from_where_they_were() {
    let records = records(&pressed(
        r#"
        stages: [
            // One newton more on lid and disk in every increment; the floor yields by F/k.
            Load(name: "ramp", increments: 10, walls: { "lid": Force(10.0) },
                particles: [(select: Probe("disk"), x: Held, rotation: Held, force: (0.0, -10.0))],
                stop: [Above("axial_strain", 8.5e-6)]),
            Load(name: "hold", increments: 2,
                particles: [(select: Probe("disk"), x: Held, rotation: Held)]),
            Load(name: "more", increments: 3, walls: { "lid": Force(6.0) },
                particles: [(select: Probe("disk"), x: Held, rotation: Held, force: (0.0, -9.0))]),
        ],
        reference_stage: "ramp",
        measures: [(name: "axial_strain", of: Strain(Walls("floor", "lid")))],
        "#,
    ));
    let forces = |name: &str| -> Vec<f64> {
        let readings = records.iter().map(|o| probe(o, name).force[1]);
        readings.collect()
    };
    // After three increments the lid has come down by 3 N/k and the 6 N/k of the floor.
    let lid = [-1.0, -2.0, -3.0, -3.0, -3.0, -4.0, -5.0, -6.0];
    let floor = [2.0, 4.0, 6.0, 6.0, 6.0, 9.0, 12.0, 15.0];
    for (found, expected) in [(forces("lid"), lid), (forces("floor"), floor)] {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert_relative(*found, expected, 1e-8);
        }
    }
}

/// Walls that follow loads, and walls that are removed, do not block others.
#[test]
fn a_wall_may_move_far_where_the_opposite_one_gives_way_or_is_gone() {
    let stage = |rest: &str| {
        let lid = r#""lid": Displacement(0.0, -0.2)"#;
        pressed(&format!(r#"stages: [Load(name: "move", increments: 10, {rest})],"#))
            .replace("LID", lid)
    };
    parse(&stage(r#"walls: { LID, "floor": Force(1.0) }"#));
    parse(&stage(r#"walls: { LID }, remove_walls: ["floor"]"#));
    parse(&stage(r#"walls: { LID, "floor": Displacement(0.0, -0.2) }"#));
    let refused = std::panic::catch_unwind(|| parse(&stage("walls: { LID }")));
    assert!(refused.is_err(), "the lid passes through the floor");
}

#[test]
fn particles_of_a_packing_can_be_probes() {
    let text = r#"(
        version: 1, title: "marked",
        materials: { "stone": () },
        specimen: Lattice(columns: 3, rows: 3, radius: 0.5, origin: (0.0, 0.0)),
        probes: { "seventh": 7, "first": 0 },
        stages: [Load(name: "move", increments: 1, particles: [
            (select: All, x: Held, y: Held, rotation: Held),
            (select: Probe("seventh"), x: Displacement(1.0e-3), y: Held, rotation: Held),
        ])],
    )"#;
    let records = records(text);
    let names: Vec<_> = records[0].probes.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["first", "seventh"]);
    for (probe, expected) in records[0].probes.iter().zip([0.0, 1e-3]) {
        assert_within(probe.motion[0], expected, 1e-12);
    }
}

#[test]
fn stress_drop_ends_a_tension_test() {
    let text = r#"(
        version: 1, title: "pulled",
        materials: { "cemented": (
            contact: (normal_stiffness: 1.0e6),
            bond: (normal_stiffness: 1.0e6, tensile_strength: 10.0, cohesion: 100.0),
        ) },
        specimen: Particles([
            (position: (0.0, 0.0), radius: 0.5), (position: (1.0, 0.0), radius: 0.5),
        ]),
        bonds: [(a: 0, b: 1)],
        stages: [Load(name: "pull", increments: 30, stop: [StressDrop(0.5)], particles: [
            (select: Index([0]), x: Held, y: Held, rotation: Held),
            (select: Index([1]), x: Displacement(1.0e-6), y: Held, rotation: Held),
        ])],
        measures: [
            (name: "axial_strain", of: Strain(Particles(0, 1))),
            (name: "axial_stress", of: Stress(Average(component: Xx, area: Fixed(1.0)))),
        ],
    )"#;
    let mut simulation = Simulation::new(&parse(text), None);
    let mut last = None;
    let mut maximum = 0.0_f64;
    while let Some(record) = next(&mut simulation) {
        maximum = maximum.min(record.axial_stress.unwrap());
        last = Some(record);
    }
    let script = simulation.world().resource::<Script>();
    let [StageEnd { ended_by, .. }] = script.ends.as_slice() else { panic!("{:?}", script.ends) };
    assert_eq!(*ended_by, Some(EndedBy::Stop));
    // It stopped in the increment after the break, long before the last.
    assert!(maximum < 0.0 && last.unwrap().increment < 30, "{maximum}");
}

/// Two stages: the disk of [`pressed`] is moved to the right by 1 mm, then held in a box.
fn moved_and_held(min: f64, max: f64) -> String {
    pressed(&format!(
        r#"stages: [
            Load(name: "move", increments: 2, particles: [
                (select: Probe("disk"), x: Displacement(0.5e-3), y: Held, rotation: Held),
            ]),
            Load(name: "hold", increments: 1, particles: [
                (select: All, x: Held, y: Held, rotation: Held),
                (select: Box(min: ({min:?}, 0.0), max: ({max:?}, 1.0)), x: Held),
            ]),
        ],"#
    ))
}

#[test]
fn a_stage_that_selects_no_particle_is_refused_as_it_begins() {
    // The disk is in this box before it is moved, so that the scene itself is sound.
    let scene = parse(&moved_and_held(-0.5e-3, 0.5e-3));
    let mut simulation = Simulation::new(&scene, None);
    while next(&mut simulation).is_some() {}
    let outcome = simulation.run();
    let Outcome::Refused { stage, message } = outcome else { panic!("{outcome:?}") };
    assert_eq!(stage, "hold");
    for what in ["`hold`", "particles[1].select", "no particle", "-0.0005", "0.0005"] {
        assert!(message.contains(what), "no `{what}` in: {message}");
    }
    // The two increments before it are committed, and the stage has not begun.
    assert_eq!(simulation.world().resource::<Observation>().increment, 2);
    assert_eq!(simulation.world().resource::<Script>().ends.len(), 1);

    // From there the run goes on with another box.
    let state = simulation.state().unwrap();
    let view = StateView::of(&state).unwrap();
    let mended = parse(&moved_and_held(0.5e-3, 1.5e-3));
    assert!(changes::refused(&scene, &mended, &view).is_empty());
    let mut simulation = Simulation::resume(&mended, &state).unwrap();
    changes::apply(simulation.world_mut(), &scene, &mended, &view);
    assert_eq!(simulation.run(), Outcome::Completed);
    assert_eq!(simulation.world().resource::<Observation>().increment, 3);
}

/// A disk cemented to a lid that pulls at it, goes and comes back.
fn cemented_lid(last: &str) -> String {
    format!(
        r#"(
            version: 1, title: "cemented lid",
            materials: {{ "stone": (contact: (normal_stiffness: 1.0e6)) }},
            specimen: Particles([(position: (0.0, 0.5), radius: 0.5, probe: "disk")]),
            walls: [
                (name: "lid", start: (1.0, 1.0), end: (-1.0, 1.0), probe: "lid",
                    contact: (normal_stiffness: 1.0e6),
                    bond: (normal_stiffness: 1.0e6, cohesion: 1.0e3, tensile_strength: 1.0e3)),
            ],
            stages: [
                Cement(name: "cement", length: 1.0e-3, walls: true),
                Load(name: "pull", increments: 2, walls: {{ "lid": Displacement(0.0, 1.0e-6) }},
                    particles: [(select: All, x: Held, y: Held, rotation: Held)]),
                Load(name: "without", increments: 1, remove_walls: ["lid"],
                    particles: [(select: All, x: Held, y: Held, rotation: Held)]),
                {last}
                Load(name: "again", increments: 2, add_walls: ["lid"],
                    walls: {{ "lid": Displacement(0.0, 1.0e-6) }},
                    particles: [(select: All, x: Held, y: Held, rotation: Held)]),
            ],
        )"#
    )
}

/// Whether a world has a bond in any state.
fn bonds(simulation: &mut Simulation) -> usize {
    let world = simulation.world_mut();
    world.query::<&Bond>().iter(world).count()
}

#[test]
fn the_bonds_of_a_wall_end_when_it_is_taken_away() {
    let scene = parse(&cemented_lid(""));
    let mut simulation = Simulation::new(&scene, None);
    let mut resumed: Option<Simulation> = None;
    // 1 N more in every increment of the first pull; then the lid is gone, and what comes back is
    // bare.
    for (k, (count, force)) in
        [(1, 1.0), (1, 2.0), (0, 0.0), (0, 0.0), (0, 0.0)].into_iter().enumerate()
    {
        let record = next(&mut simulation).unwrap();
        assert_eq!((record.bonds, bonds(&mut simulation)), (count, count), "increment {k}");
        assert_eq!(record.broken, [0; 3]);
        assert_within(probe(&record, "disk").force[1], -force, 1e-8);
        if let Some(resumed) = &mut resumed {
            assert_eq!(next(resumed).unwrap(), record, "increment {k}");
        }
        if k == 2 {
            // A checkpoint of the time without the lid does not bring them back either.
            let state = simulation.state().unwrap();
            resumed = Some(Simulation::resume(&scene, &state).unwrap());
        }
    }
}

#[test]
fn a_wall_that_comes_back_can_be_cemented_anew() {
    let again = r#"Load(name: "bring", increments: 1, add_walls: ["lid"],
        particles: [(select: All, x: Held, y: Held, rotation: Held)]),
        Cement(name: "anew", length: 1.0e-3, walls: true),"#;
    let text =
        cemented_lid(again).replace(r#"increments: 2, add_walls: ["lid"],"#, "increments: 2,");
    let (records, _) = run(&parse(&text));
    let found: Vec<_> = records.iter().map(|record| record.bonds).collect();
    assert_eq!(found, [1, 1, 0, 0, 1, 1]);
    // Free of stress where it was made: 1 N per increment again.
    let force = |k: usize| probe(&records[k], "disk").force[1];
    assert_within(force(4), -1.0, 1e-8);
    assert_within(force(5), -2.0, 1e-8);
}

#[test]
fn stress_drop_waits_for_a_stress_that_is_no_round_off() {
    // Two disks that touch are moved together: only the round-off of their distance presses them,
    // in some increments. After 30 increments they come to a third one.
    let text = r#"(
        version: 1, title: "pushed against a disk",
        materials: { "stone": (contact: (normal_stiffness: 1.0e9)) },
        specimen: Particles([
            (position: (0.0235, 0.0), radius: 0.04), (position: (0.1035, 0.0), radius: 0.04),
            (position: (0.18523, 0.0), radius: 0.04),
        ]),
        stages: [Load(name: "push", increments: 40, stop: [StressDrop(0.5)], particles: [
            (select: Index([0, 1]), x: Displacement(5.771e-5), y: Held, rotation: Held),
            (select: Index([2]), x: Held, y: Held, rotation: Held),
        ])],
        measures: [
            (name: "axial_strain", of: Strain(Particles(0, 2))),
            (name: "axial_stress", of: Stress(Average(component: Xx, area: Fixed(0.01)))),
        ],
    )"#;
    let records = records(text);
    let stresses: Vec<_> = records.iter().map(|record| record.axial_stress.unwrap()).collect();
    let drops = (1..25).any(|k| {
        let peak = stresses[..k].iter().copied().fold(0.0, f64::max);
        stresses[k] < 0.5 * peak
    });
    assert!(drops, "without round-off this shows nothing: {stresses:?}");
    assert_eq!(records.len(), 40);
    // The overlap of the last two at k = 1 GN/m, over a branch of 0.08 m and an area of 0.01 m^2.
    let overlap = 40.0 * 5.771e-5 - 1.73e-3;
    assert_relative(stresses[39], 1.0e9 * overlap * 0.08 / 0.01, 0.02);
}

#[test]
fn the_default_friction_law_is_associated_in_statics_and_coulombs_in_dynamics() {
    let under = |law: FrictionLaw, mut scene: Scene| {
        scene.friction_law = law;
        run(&scene).0
    };
    // Sliding tells the laws apart in both scenes.
    let at_rest = || small_cell(ROUGH, ROUGH);
    let [default, associated, coulomb] =
        [FrictionLaw::default(), FrictionLaw::Associated, FrictionLaw::COULOMB]
            .map(|law| under(law, at_rest()));
    assert_eq!(default, associated);
    assert_ne!(default, coulomb);
    let moving = || swarm("Associated", RIGID, 1e-3, 1.0, 40);
    let [default, associated, coulomb] =
        [FrictionLaw::default(), FrictionLaw::Associated, FrictionLaw::COULOMB]
            .map(|law| under(law, moving()));
    assert_eq!(default, coulomb);
    assert_ne!(default, associated);
}

/// A lid that was drawn from its end to its start pushed all disks through itself: the specimen
/// "collapsed".
#[test]
fn a_wall_that_comes_with_particles_behind_it_is_refused() {
    let scene = |lid: &str| {
        parse(&format!(
            r#"(version: 1, title: "lid", gravity: (0.0, -9.81), analysis: Dynamic(dt: 5.0e-3),
            materials: {{ "m": (density: 2650.0, contact: (friction: 0.5)) }},
            specimen: Particles([(position: (0.0, 0.01), radius: 0.01), (position: (0.0, 0.05), radius: 0.01)]),
            walls: [
                (name: "floor", start: (-0.1, 0.0), end: (0.1, 0.0)),
                (name: "left", start: (-0.01, 0.1), end: (-0.01, 0.0)),
                (name: "right", start: (0.01, 0.0), end: (0.01, 0.1)),
                (name: "lid", {lid}, present: false),
            ],
            stages: [
                Load(name: "fall", increments: 40),
                Load(name: "cover", increments: 2, add_walls: ["lid"]),
            ])"#
        ))
    };
    // At first the upper disk is above this lid; then it has fallen.
    let cover = |lid: &str| Simulation::new(&scene(lid), None).run();
    assert_eq!(cover("start: (0.1, 0.041), end: (-0.1, 0.041)"), Outcome::Completed);
    let refused = |lid: &str, behind: &str| {
        let Outcome::Refused { stage, message } = cover(lid) else { panic!("{lid}") };
        assert_eq!(stage, "cover");
        let wanted = format!("wall `lid` of add_walls comes with {behind} behind it");
        assert!(message.contains(&wanted), "{message}");
    };
    refused("start: (0.1, 0.02), end: (-0.1, 0.02)", "a particle");
    refused("start: (-0.1, 0.02), end: (0.1, 0.02)", "a particle");
    // Both disks were in front of it at the start, one before the other after it.
    refused("start: (-0.1, 0.04), end: (0.1, 0.04)", "2 particles");
}
