//! Bodies at rest are left out of the program that is solved, and wake when a force on them or a
//! neighbour changes.

use clastic::components::contact_history::ContactHistory;
use clastic::cone::condensed::{Condensed, sleeping};
use clastic::cone::program::{ConeProgram, ConeSolution, SolveStatus};
use clastic::cone::residuals::{displacement_scale, force_scale};
use clastic::cone::solver::ConeSolver;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::{
    Analysis, FrictionLaw, Load, Motion, ParticleControl, Scene, Select, Stage, WallControl,
};

use crate::common::{next, parse, run, states};

/// Three disks upon each other, and one that falls at x with a velocity v.
fn stack(contact: &str, solver: &str, [x, v]: [f64; 2]) -> Scene {
    parse(&format!(
        "(
            version: 1,
            title: \"stack and falling disk\",
            analysis: Dynamic(dt: 1.0e-3, theta: 1.0),
            gravity: (0.0, -9.81),
            solver: {solver},
            materials: {{ \"stone\": (density: 2650.0, contact: ({contact})) }},
            specimen: Particles([
                (position: (0.0, 0.01), radius: 0.01),
                (position: (0.0, 0.03), radius: 0.01),
                (position: (0.0, 0.05), radius: 0.01),
                (position: ({x}, 0.09), radius: 0.01, velocity: ({v}, 0.0)),
            ]),
            walls: [(name: \"floor\", start: (-0.5, 0.0), end: (0.5, 0.0), contact: ({contact}))],
            stages: [Load(name: \"fall\", increments: 300)],
        )"
    ))
}

const RIGID: &str = "friction: 0.5, rolling_friction: 0.1";
const ELASTIC: &str =
    "normal_stiffness: 1.0e7, tangential_stiffness: 1.0e7, friction: 0.5, rolling_friction: 0.1";

const BESIDE: [f64; 2] = [0.1, 0.3];
const UPON: [f64; 2] = [0.008, 0.0];

/// Bodies that were left out of the increment that was just solved; `moved` are the displacements
/// of the one before, and become those of this one.
fn asleep(simulation: &Simulation, moved: &mut Vec<[f64; 3]>) -> Vec<usize> {
    let program = simulation.world().resource::<ConeProgram>();
    moved.resize(program.bodies.len(), [0.0; 3]);
    let found = sleeping::find(program, moved).unwrap_or_default();
    moved.clone_from(&simulation.world().resource::<ConeSolution>().displacements);
    (0..found.len()).filter(|i| found[*i]).collect()
}

/// Runs a scene with the engine's solver and with Clarabel, which lets no body sleep. The places
/// must agree, and disk 3 must never sleep. Returns the number of increments in which all of
/// `stack` sleeps.
fn sleeps(scene: impl Fn(&str) -> Scene, stack: &[usize]) -> u32 {
    let mut own = Simulation::new(&scene("Condensed"), None);
    let mut oracle = Simulation::new(&scene("Clarabel()"), None);
    let (mut slept, mut last) = (0, Vec::new());
    while let Some(record) = next(&mut own) {
        next(&mut oracle).unwrap();
        let asleep = asleep(&own, &mut last);
        assert!(asleep.is_empty() || asleep == stack, "{asleep:?} in {record:?}");
        slept += u32::from(!asleep.is_empty());
        for (a, b) in states(&mut own).iter().zip(states(&mut oracle)) {
            assert!(a.position.distance(b.position) <= 1e-9, "{a:?}\n{b:?}");
        }
    }
    slept
}

#[test]
fn a_stack_sleeps_while_a_disk_falls_beside_it() {
    for contact in [RIGID, ELASTIC] {
        let slept = sleeps(|solver| stack(contact, solver, BESIDE), &[0, 1, 2]);
        assert!(slept >= 150, "{contact}: {slept} of 300");
    }
}

#[test]
fn a_stack_sleeps_with_coulombs_law_and_with_every_theta() {
    for theta in [0.5, 0.75, 1.0] {
        let coulomb = |solver: &str| {
            let mut scene = stack(RIGID, solver, BESIDE);
            scene.friction_law = FrictionLaw::COULOMB;
            scene.analysis = Analysis::Dynamic { dt: 1.0e-3, theta };
            scene
        };
        let slept = sleeps(coulomb, &[0, 1, 2]);
        // What theta = 1/2 leaves of the first fall of the stack takes longer to end.
        assert!(slept >= 100, "theta {theta}: {slept} of 300");
    }
}

/// A wall that presses on the stack sleeps with it while its force does not change, and wakes it
/// where it does. In between the stack wakes by itself: what is left of its motion, 1e-14 m an
/// increment, adds up in its gaps.
#[test]
fn a_stack_sleeps_under_a_loaded_wall_until_its_load_changes() {
    let pressed = |solver: &str, force: f64| {
        let mut scene = parse(&format!(
            "(
                version: 1,
                title: \"stack under a lid and sliding disk\",
                analysis: Dynamic(dt: 1.0e-3, theta: 1.0),
                gravity: (0.0, -9.81),
                solver: {solver},
                materials: {{ \"stone\": (density: 2650.0, contact: ({ELASTIC})) }},
                specimen: Particles([
                    (position: (0.0, 0.01), radius: 0.01),
                    (position: (0.0, 0.03), radius: 0.01),
                    (position: (0.0, 0.05), radius: 0.01),
                    (position: (0.1, 0.01), radius: 0.01, velocity: (0.3, 0.0)),
                ]),
                walls: [
                    (name: \"floor\", start: (-0.5, 0.0), end: (0.5, 0.0), contact: ({ELASTIC})),
                    (name: \"lid\", start: (0.5, 0.06), end: (-0.5, 0.06), contact: ({ELASTIC})),
                ],
                stages: [
                    Load(name: \"press\", increments: 10, walls: {{ \"lid\": Force(100.0) }}),
                    Load(name: \"wait\", increments: 150),
                ],
            )"
        ));
        let Some(Stage::Load(wait)) = scene.stages.last() else { panic!("no load") };
        let mut more = Load { name: "more".to_owned(), increments: 20, ..wait.clone() };
        more.walls.insert("lid".to_owned(), WallControl::Force(force));
        scene.stages.push(Stage::Load(more));
        scene
    };
    // Floor and lid follow the four disks.
    let lid = 5;
    let waiting = sleeps(|solver| pressed(solver, 100.0), &[0, 1, 2, lid]);
    assert!(waiting >= 40, "{waiting} of 180");
    let mut simulation = Simulation::new(&pressed("Condensed", 200.0), None);
    let (mut last, mut slept, mut awake) = (Vec::new(), 0, 0);
    while let Some(record) = next(&mut simulation) {
        let asleep = asleep(&simulation, &mut last);
        match record.stage.as_str() {
            "wait" => slept += u32::from(!asleep.is_empty()),
            "more" => awake += u32::from(asleep.is_empty()),
            _ => {}
        }
    }
    assert!(slept >= 40, "{slept} of 150");
    assert_eq!(awake, 20, "slept while its load changed");
}

/// Sleeping bodies are part of the state: a run that is resumed in the middle has the same bits.
#[test]
fn a_run_that_is_resumed_sleeps_on() {
    let scene = stack(RIGID, "Condensed", BESIDE);
    let mut whole = Simulation::new(&scene, None);
    for _ in 0..80 {
        next(&mut whole).unwrap();
    }
    let moved = whole.world().resource::<ConeSolution>().displacements.clone();
    let mut resumed = Simulation::resume(&scene, &whole.state().unwrap()).unwrap();
    let (mut last, mut also) = (moved.clone(), moved);
    for _ in 0..30 {
        assert_eq!(next(&mut whole), next(&mut resumed));
        assert_eq!(asleep(&whole, &mut last), [0, 1, 2]);
        assert_eq!(asleep(&resumed, &mut also), [0, 1, 2]);
        let states = [states(&mut whole), states(&mut resumed)];
        assert_eq!(format!("{:?}", states[0]), format!("{:?}", states[1]));
    }
}

#[test]
fn a_stack_wakes_when_a_disk_falls_on_it() {
    for contact in [RIGID, ELASTIC] {
        let mut own = Simulation::new(&stack(contact, "Condensed", UPON), None);
        let (mut slept, mut moved, mut last) = (false, false, Vec::new());
        let before = states(&mut own);
        while next(&mut own).is_some() {
            slept |= !asleep(&own, &mut last).is_empty();
            let now = states(&mut own);
            moved |= (0..3).any(|i| now[i].position.distance(before[i].position) > 1e-4);
        }
        assert!(slept && moved, "{contact}: {slept} {moved}");
    }
}

/// Without sleep all bodies are solved, with the same solution.
#[test]
fn what_is_at_rest_is_what_would_be_solved() {
    let mut scene = stack(ELASTIC, "Condensed", BESIDE);
    // The other solver has the associated law.
    scene.friction_law = FrictionLaw::Associated;
    let mut simulation = Simulation::new(&scene, None);
    let (mut compared, mut last) = (0, Vec::new());
    while next(&mut simulation).is_some() {
        if asleep(&simulation, &mut last).is_empty() {
            continue;
        }
        let mut program = simulation.world().resource::<ConeProgram>().clone();
        let with = simulation.world().resource::<ConeSolution>().clone();
        program.last_forces.clear();
        let without = Condensed::default().solve(&program, 0.0).unwrap();
        assert_eq!(without.status, SolveStatus::Solved);
        let force = force_scale(&program, &without.forces);
        let far = displacement_scale(&program, &without.displacements);
        for (a, b) in with.forces.iter().zip(&without.forces) {
            for k in 0..2 {
                assert!((a[k] - b[k]).abs() <= 1e-6 * force, "{a:?} {b:?}");
            }
        }
        for (a, b) in with.displacements.iter().zip(&without.displacements) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) <= 1e-7 * far, "{a:?} {b:?}");
        }
        compared += 1;
    }
    assert!(compared >= 150, "{compared}");
}

/// A floor that creeps sideways shears the stack by an imposed slip that is negligible beside the
/// motion of the fast disk, and that changes no gap and no velocity.
#[test]
fn imposed_slip_keeps_a_stack_awake() {
    let mut scene = stack(ELASTIC, "Condensed", BESIDE);
    for stage in &mut scene.stages {
        if let Stage::Load(load) = stage {
            load.walls.insert("floor".to_owned(), WallControl::Displacement(1e-15, 0.0));
        }
    }
    let mut simulation = Simulation::new(&scene, None);
    let mut last = Vec::new();
    while let Some(record) = next(&mut simulation) {
        let asleep = asleep(&simulation, &mut last);
        assert!(asleep.is_empty(), "{asleep:?} in increment {}", record.increment);
    }
}

/// Where the fast disk stops, the scale of motion falls at once. Bodies that slept by the larger
/// scale must not count as solved for the solver and as unconverged for the engine.
#[test]
fn a_stack_sleeps_on_or_is_solved_when_what_is_fast_stops() {
    let mut scene = stack(RIGID, "Condensed", BESIDE);
    let Some(Stage::Load(mut hold)) = scene.stages.pop() else { panic!("no load") };
    scene.stages.push(Stage::Load(Load { increments: 40, ..hold.clone() }));
    hold.name = "hold".to_owned();
    hold.particles = vec![ParticleControl {
        select: Select::Index(vec![3]),
        x: Motion::Held,
        y: Motion::Held,
        rotation: Motion::Held,
        affine: None,
        force: None,
        moment: None,
        remains: None,
    }];
    scene.stages.push(Stage::Load(hold));
    let (records, outcome) = run(&scene);
    assert_eq!(outcome, Outcome::Completed);
    assert!(records.iter().all(|r| r.solves == 1), "an increment was solved again");
}

/// Pyramids of fifteen disks, the disks of a row a hundred thousandth of a metre apart, on one
/// floor.
fn pyramids(count: usize) -> Scene {
    const R: f64 = 0.01;
    const GAP: f64 = 1e-5;
    let mut disks = String::new();
    for pyramid in 0..count {
        for (row, disks_of_row) in (1..=5).rev().enumerate() {
            for k in 0..disks_of_row {
                let x = 13.0 * R * pyramid as f64 + (2.0 * R + GAP) * (k as f64 + 0.5 * row as f64);
                let y = R + row as f64 * (4.0 * R * R - (R + 0.5 * GAP).powi(2)).sqrt();
                disks += &format!("(position: ({x:?}, {y:?}), radius: {R}),");
            }
        }
    }
    let floor = 13.0 * R * count as f64;
    parse(&format!(
        "(
            version: 1,
            title: \"pyramids\",
            analysis: Dynamic(dt: 2.0e-3, theta: 1.0),
            gravity: (0.0, -9.81),
            materials: {{ \"stone\": (density: 2650.0, contact: ({RIGID})) }},
            specimen: Particles([{disks}]),
            walls: [(name: \"floor\", start: (-1.0, 0.0), end: ({floor}, 0.0), contact: ({RIGID}))],
            stages: [Load(name: \"rest\", increments: 6)],
        )"
    ))
}

/// The solver ended a large scene at the accepted product of force and gap, and every pair with a
/// gap of 10 um counted as a contact: all 35 of a pyramid.
#[test]
fn contacts_of_a_large_scene_touch() {
    let mut alone = 0;
    for count in [1, 80] {
        let mut simulation = Simulation::new(&pyramids(count), None);
        let mut contacts = 0;
        while let Some(record) = next(&mut simulation) {
            contacts = record.contacts;
        }
        let x: Vec<_> = states(&mut simulation).iter().map(|s| s.position).collect();
        let history = &simulation.world().resource::<ContactHistory>().0;
        assert_eq!(contacts, history.len());
        // Five on the floor and two under each of ten, but for those that the arches above leave
        // open.
        assert!((18 * count..=25 * count).contains(&contacts), "{contacts} of {count} pyramids");
        alone = if count == 1 { contacts } else { alone };
        assert_eq!(contacts, count * alone);
        for m in history.iter().filter(|m| (m.b as usize) < x.len()) {
            let gap = x[m.a as usize].distance(x[m.b as usize]) - 0.02;
            assert!(gap.abs() < 1e-8, "a gap of {gap:e} m in {count} pyramids");
        }
    }
}
