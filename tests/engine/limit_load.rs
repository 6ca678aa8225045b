//! Specimens under force and stress control carry what they can and then collapse, wherever walls
//! and grains would come to rest later; and what is stress controlled has its stress in every
//! increment.

use std::path::Path;

use clastic::components::attempt::IncrementStatus;
use clastic::components::contact::BodyTable;
use clastic::components::observation::Observation;
use clastic::cone::certificate::{certificate, proves};
use clastic::cone::program::{ConeProgram, ConeSolution};
use clastic::run::{Outcome, Simulation, Step};
use clastic::scene;

/// Runs a scene of `scenes/` with other settings.
fn run(name: &str, settings: &[&str]) -> (Vec<Observation>, Outcome) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let settings: Vec<String> = settings.iter().map(|s| (*s).to_owned()).collect();
    let loaded = scene::load(&path, &settings).unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let mut records = Vec::new();
    loop {
        match simulation.step() {
            Step::Increment => records.push(simulation.world().resource::<Observation>().clone()),
            Step::Finished(outcome) => return (records, outcome),
        }
    }
}

/// Maximum axial stress of the increments that were solved, Pa, and the strain that they reach.
fn limit(records: &[Observation]) -> (f64, f64) {
    let solved = records.iter().filter(|o| o.status == IncrementStatus::Solved);
    solved.fold((0.0, 0.0), |(stress, strain), o| {
        (o.axial_stress.map_or(stress, |s| s.max(stress)), o.axial_strain.unwrap_or(strain))
    })
}

fn assert_collapses(outcome: &Outcome) {
    assert!(matches!(outcome, Outcome::Collapsed(c) if c.stage == "load"), "{outcome:?}");
}

#[test]
fn rigid_specimen_under_stress_collapses_at_the_limit_load() {
    // Driven by displacement the first increment carries it: the optimum of the program.
    let (driven, _) = run("uniaxial_rigid_small.ron", &[]);
    let expected = driven[0].axial_stress.unwrap();
    let settings = ["stages.load.walls.top=Stress(stress: 1.2e9)", "stages.load.increments=12"];
    let (records, outcome) = run("uniaxial_rigid_small.ron", &settings);
    assert_collapses(&outcome);
    // It is between the last load that was carried and the first one that was not: an increment of
    // 100 MPa, or a part of it.
    let (carried, _) = limit(&records);
    assert!(carried <= expected && expected <= carried + 100e6, "{carried} and {expected}");
}

#[test]
fn elastic_specimen_under_stress_collapses_near_its_peak() {
    let (driven, _) = run("uniaxial_small.ron", &["stages.load.increments=80"]);
    let (peak, _) = limit(&driven);
    let settings = ["stages.load.walls.top=Stress(stress: 250.0e6)", "stages.load.increments=250"];
    let (records, outcome) = run("uniaxial_small.ron", &settings);
    assert_collapses(&outcome);
    // Bonds break in one round an increment and damage goes on under a given load, so that here,
    // with 1 MPa more each time, it lags behind.
    let (carried, strain) = limit(&records);
    assert!((carried / peak - 1.0).abs() < 0.1, "{carried} and {peak}");
    assert!(strain < 0.01, "{strain}");
}

#[test]
fn stress_on_a_wall_is_exact_where_grains_settle() {
    let settings = ["acceptance.turn=0.05", "stages.load.increments=60"];
    let (records, _) = run("biaxial_small.ron", &settings);
    let load = || records.iter().filter(|o| o.stage == "load");
    assert!(load().any(|o| o.motion_steps > 0), "no motion was followed");
    for o in load() {
        let stress = o.lateral_stress.unwrap();
        assert!((stress / 200e3 - 1.0).abs() < 1e-7, "increment {}: {stress}", o.increment);
    }
}

/// A stage of wall stress that is committed in many fractions seemed to end at 192.8 of 200 kPa.
#[test]
fn a_stress_that_is_reached_in_many_fractions_is_that_of_its_target() {
    let settings = [
        "stages.load.walls.top=Stress(stress: 500.0e3, between: (\"left\", \"right\"))",
        "stages.load.walls.bottom=Stress(stress: 500.0e3, between: (\"left\", \"right\"))",
        "stages.load.increments=3",
        "rupture.order=Events",
        "rupture.density=30.0",
        "rupture.brittleness=0.0",
    ];
    let (records, outcome) = run("biaxial_small.ron", &settings);
    assert_eq!(outcome, Outcome::Completed);
    let load: Vec<_> = records.iter().filter(|o| o.stage == "load").collect();
    assert!(load.len() > 10, "{} fractions", load.len());
    let done: f64 = load.iter().map(|o| o.fraction).sum();
    assert!((done - 3.0).abs() < 1e-9, "{done} of 3 increments");
    let stress = load.last().unwrap().axial_stress.unwrap();
    assert!((stress / 500e3 - 1.0).abs() < 1e-7, "{stress} Pa");
}

#[test]
fn confined_specimen_under_stress_collapses_and_does_not_strain_on() {
    let settings = [
        "stages.load.walls.top=Stress(stress: 1000.0e3, between: (\"left\", \"right\"))",
        "stages.load.increments=40",
    ];
    let (records, outcome) = run("biaxial_small.ron", &settings);
    assert_collapses(&outcome);
    let (carried, strain) = limit(&records);
    assert!((700e3..1000e3).contains(&carried), "{carried}");
    assert!(strain < 0.05, "{strain}");
}

/// A heap of `n` by `n` disks that carries 1 kN between platens, and then loses a side.
fn heap(n: usize, contact: &str) -> String {
    let (width, height) = (0.01 * n as f64 + 0.005, 0.01 + 0.01 * 0.75_f64.sqrt() * (n - 1) as f64);
    format!(
        "(
            version: 1,
            title: \"heap\",
            materials: {{ \"stone\": (contact: ({contact})) }},
            specimen: Lattice(columns: {n}, rows: {n}, radius: 5.0e-3, origin: (5.0e-3, 5.0e-3)),
            walls: [
                (name: \"bottom\", start: (-1.0, 0.0), end: (2.0, 0.0), contact: ({contact})),
                (name: \"top\", start: (2.0, {height}), end: (-1.0, {height}), contact: ({contact})),
                (name: \"left\", start: (0.0, 1.0), end: (0.0, 0.0), contact: ({contact})),
                (name: \"right\", start: ({width}, 0.0), end: ({width}, 1.0), contact: ({contact})),
            ],
            stages: [
                Load(name: \"press\", increments: 2, walls: {{ \"top\": Force(1000.0) }}),
                Load(
                    name: \"load\",
                    increments: 2,
                    remove_walls: [\"right\"],
                    walls: {{ \"top\": Force(1000.0) }},
                ),
            ],
        )"
    )
}

/// In large specimens, and in rigid ones that settled before, a collapse was reported without a
/// mechanism that proves it.
#[test]
fn collapse_of_a_heap_is_proved_however_large() {
    let elastic = "normal_stiffness: 6.0e7, tangential_stiffness: 6.0e7, friction: 0.2";
    for (n, contact) in [(12, elastic), (12, "friction: 0.2"), (20, elastic)] {
        let text = heap(n, contact);
        let loaded = scene::from_str(&text, Path::new("heap.ron"), Path::new(""), &[]).unwrap();
        let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
        let outcome = loop {
            if let Step::Finished(outcome) = simulation.step() {
                break outcome;
            }
        };
        assert_collapses(&outcome);
        let Outcome::Collapsed(collapse) = outcome else { unreachable!() };
        let program = simulation.world().resource::<ConeProgram>();
        let found = simulation.world().resource::<ConeSolution>().certificate.clone().unwrap();
        let again = certificate(program, &found.mechanism).filter(proves);
        assert!(again.is_some_and(|c| c.margin > 0.9), "{n}: {found:?}");
        // The reason names the body that moves most. Walls stand still, and no body has gone.
        let far = |i: &usize| found.mechanism[*i][0].hypot(found.mechanism[*i][1]);
        let particles = 0..simulation.world().resource::<BodyTable>().particles;
        let most = particles.max_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
        let named = format!("a mechanism proves it, in which particle {most} near (");
        assert!(collapse.reason.contains(&named), "{n}: {named} and not {}", collapse.reason);
    }
}
