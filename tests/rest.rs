//! What is at rest is left out of the program that is solved, and wakes when something happens to it.

mod common;

use clastic::components::program::{ConeProgram, ConeSolution, SolveStatus};
use clastic::run::Simulation;
use clastic::scene::format::Scene;
use clastic::systems::solve_program::ConeSolver;
use clastic::systems::solve_program::condensed::{Condensed, rest};
use clastic::systems::solve_program::residuals::{displacement_scale, force_scale};

use common::{next, parse, states};

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

/// Bodies that were found at rest in the increment that was just solved.
fn asleep(simulation: &Simulation) -> Vec<usize> {
    let program = simulation.world().resource::<ConeProgram>();
    let solution = simulation.world().resource::<ConeSolution>();
    let found = rest::find(program, &solution.displacements).unwrap_or_default();
    (0..found.len()).filter(|i| found[*i]).collect()
}

#[test]
fn a_stack_sleeps_while_a_disk_falls_beside_it() {
    for contact in [RIGID, ELASTIC] {
        let mut own = Simulation::new(&stack(contact, "Condensed", BESIDE), None);
        let mut oracle = Simulation::new(&stack(contact, "Clarabel()", BESIDE), None);
        let (mut slept, mut woke) = (0, 0);
        while let Some(record) = next(&mut own) {
            next(&mut oracle).unwrap();
            let asleep = asleep(&own);
            assert!(!asleep.contains(&3), "{record:?}");
            assert!(asleep.is_empty() || asleep == [0, 1, 2], "half of a stack: {asleep:?}");
            slept += u32::from(!asleep.is_empty());
            woke += u32::from(asleep.is_empty());
            for (a, b) in states(&mut own).iter().zip(states(&mut oracle)) {
                assert!(a.position.distance(b.position) <= 1e-9, "{a:?}\n{b:?}");
            }
        }
        println!("{contact}: {slept} increments at rest, {woke} not");
        assert!(slept >= 150, "{contact}: {slept} of {}", slept + woke);
    }
}

#[test]
fn a_stack_wakes_when_a_disk_falls_on_it() {
    for contact in [RIGID, ELASTIC] {
        let mut own = Simulation::new(&stack(contact, "Condensed", UPON), None);
        let (mut slept, mut moved) = (false, false);
        let before = states(&mut own);
        while next(&mut own).is_some() {
            slept |= !asleep(&own).is_empty();
            let now = states(&mut own);
            moved |= (0..3).any(|i| now[i].position.distance(before[i].position) > 1e-4);
        }
        assert!(slept && moved, "{contact}: {slept} {moved}");
    }
}

/// Without the guess everything is solved: the same solution, so that sleep changes nothing.
#[test]
fn what_is_at_rest_is_what_would_be_solved() {
    let mut simulation = Simulation::new(&stack(ELASTIC, "Condensed", BESIDE), None);
    let mut compared = 0;
    while next(&mut simulation).is_some() {
        if asleep(&simulation).is_empty() {
            continue;
        }
        let mut program = simulation.world().resource::<ConeProgram>().clone();
        let with = simulation.world().resource::<ConeSolution>().clone();
        program.last_forces.clear();
        let without = Condensed::default().solve(&program).unwrap();
        assert_eq!(without.status, SolveStatus::Solved);
        let force = force_scale(&program, &without.forces);
        let far = displacement_scale(&program, &without.displacements);
        for (a, b) in with.forces.iter().zip(&without.forces) {
            assert!((a[0] - b[0]).abs() <= 1e-6 * force, "{a:?} {b:?}");
        }
        for (a, b) in with.displacements.iter().zip(&without.displacements) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) <= 1e-7 * far, "{a:?} {b:?}");
        }
        compared += 1;
    }
    assert!(compared >= 150, "{compared}");
}
