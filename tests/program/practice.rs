//! Answers that would look right to a practitioner and are wrong.

use std::fs;

use clastic::output::marks::marks;
use clastic::run::key_results::{KeyResults, Phase};
use clastic_components::attempt::IncrementStatus;
use clastic_components::observation::Observation;
use serde_json::{Value, json};

use crate::call::{clastic, json as read_json, rows, run, stderr, stdout};

/// Axial strain and stress of an increment, under a lateral stress of 1 kPa.
fn increment(n: u64, strain: f64, stress: f64) -> Observation {
    Observation {
        increment: n,
        status: IncrementStatus::Solved,
        axial_strain: Some(strain),
        axial_stress: Some(stress),
        lateral_stress: Some(1.0e3),
        ..Observation::default()
    }
}

/// The stress under a plate that lifts off came down to that of a grain which clings to it, and the specimen had a
/// friction angle of 86 degrees.
#[test]
fn a_plate_that_lifts_off_gives_no_friction_angle() {
    let angle = |least: f64| {
        let mut results = KeyResults::new(false);
        results.observe(&increment(1, 0.0, 1.0e3), Phase::Loading);
        for (n, stress) in [(2, 0.5e3), (3, least), (4, 0.5e3)] {
            results.observe(&increment(n, -1e-3 * n as f64, stress), Phase::Reference);
        }
        results.results().friction_angle_rad
    };
    assert_eq!(angle(1.0), None);
    assert!((angle(1.0e3 / 3.0).unwrap() - 0.5_f64.asin()).abs() < 1e-12);
}

/// Stress over strain between fixed side walls is no E: it had a value where the stress of the sides was not measured.
#[test]
fn an_oedometer_has_no_modulus_whether_or_not_its_lateral_stress_is_measured() {
    let measures = "measures=[(name: \"axial_strain\", of: Strain(Walls(\"bottom\", \"lid\"))), \
                    (name: \"axial_stress\", of: Stress(Walls(walls: [\"bottom\", \"lid\"], length: Fixed(0.204))))]";
    for set in [measures, "let.seed=1"] {
        let (done, out) =
            run("oedometer", &["--quiet", "--set", set, "--set", "output.plots=false"]);
        done.code(0);
        let results = &read_json(out.path(), "run.json")["results"];
        for name in ["youngs_modulus_pa", "youngs_modulus_secant_half_peak_pa"] {
            let reason = results["not_defined"][name].as_str();
            assert_eq!(reason, Some("the lateral stress changes during the test"), "{name}");
        }
    }
}

/// An area of 1 m^2 gave friction angles of 82 and 71 degrees for 23, and E of 0.2 MPa for 18.
#[test]
fn wrong_lengths_and_areas_of_stresses_give_neither_modulus_nor_friction_angle() {
    let of = |measure: &str| {
        let (done, out) = run("prepare_and_branch_50kPa", &["--quiet", "--set", measure]);
        let said = stdout(&done.code(0));
        (said, read_json(out.path(), "run.json")["results"].clone())
    };
    let (area, unit) = ("is not the area of the specimen", "no modulus and no peak stress");
    for (wrong, reason) in [
        (
            "measures.lateral_stress.of=Stress(Walls(walls: [\"left\", \"right\"], length: Fixed(0.05)))",
            area,
        ),
        ("measures.lateral_stress.of=Stress(Average(component: Xx, area: Fixed(1.0)))", area),
        ("measures.axial_stress.of=Stress(Average(component: Yy, area: Fixed(0.02)))", area),
        ("measures.axial_stress.of=Stress(Average(component: Yy, area: Fixed(1.0)))", unit),
    ] {
        let (said, results) = of(wrong);
        assert!(said.contains(reason), "{wrong}: {said}");
        for name in ["youngs_modulus_pa", "friction_angle_rad"] {
            assert!(results[name].is_null(), "{wrong}: {results}");
        }
    }
    let right = "measures.axial_stress.of=Stress(Walls(walls: [\"top\"], length: Fixed(0.1)))";
    assert!(of(right).1["youngs_modulus_pa"].is_number());
}

/// A length of 11.64 m for one of 11.64 mm left a strength of 0.2 MPa for 200, in Pa.
#[test]
fn a_stress_in_another_unit_gives_no_strength() {
    let length =
        "measures.axial_stress.of=Stress(Walls(walls: [\"bottom\", \"top\"], length: Fixed(";
    for wrong in ["11.64", "11.64e-6"] {
        let set = format!("{length}{wrong})))");
        let (done, out) = run("uniaxial_small", &["--quiet", "--set", &set]);
        let done = done.code(0);
        assert!(stderr(&done).contains("measures.axial_stress: `Fixed("), "{wrong}");
        assert!(stdout(&done).contains("no modulus and no peak stress"), "{}", stdout(&done));
        let results = &read_json(out.path(), "run.json")["results"];
        for (name, value) in results.as_object().unwrap() {
            assert!(!name.ends_with("_pa") || value.is_null(), "{wrong}: {name} is {value}");
        }
    }
    let area = |value: &str| {
        let set = format!("measures=[(name: \"n\", of: Porosity(Fixed({value})))]");
        stdout(&clastic(&["check", "uniaxial_small", "--set", &set]).code(0))
    };
    assert!(area("338.0").contains("measures.n: `Fixed(338.0)` for a specimen of"));
    assert!(!area("338.0e-6").contains("Fixed"));
}

/// Bonds that are fewer than the stop asks for were only told at the end of the run.
#[test]
fn a_stop_at_more_broken_bonds_than_there_are_is_refused() {
    let measure = "measures[2]=(name: \"broken\", of: Broken(All))";
    let stop = "stages.load.stop=[Above(\"broken\", 5000.0)]";
    let (refused, _out) = run("uniaxial_small", &["--quiet", "--set", measure, "--set", stop]);
    let said = stderr(&refused.code(3));
    assert!(said.contains("stop[0] can never hold: it is at 5000.0 broken bonds"), "{said}");
}

#[test]
fn a_stage_that_ended_before_its_stop_marks_its_run() {
    let marks_of = |ended_by: &str, stop: Value| {
        let stage = json!({ "stage": "shear", "ended_by": ended_by, "stop": stop });
        marks(&json!({ "outcome": { "status": "completed" }, "stages": [stage] }))
    };
    let stop = json!({ "Above": ["axial_strain", 0.1] });
    assert!(marks_of("stop", stop.clone()).is_empty());
    assert!(marks_of("all_increments", Value::Null).is_empty());
    assert_eq!(marks_of("all_increments", stop), ["stage shear ended before its stop"]);
}

#[test]
fn likely_mistakes_of_time_weight_and_density_are_told_before_the_run() {
    for (setting, told) in [
        ("analysis.dt=2.0", "in a time step of 2.0 s weight or a wall moves grains by"),
        (
            "materials.stone.density=2.65",
            "materials.stone: a density of 2.65 under a gravity of 9.81 is a weight of",
        ),
        ("gravity=(0.0, -9810.0)", "under a gravity of 9810.0 is a weight of 2.6e7 N/m^3"),
        ("gravity=(0.0, 9.81)", "gravity points up"),
        (
            "stages.release.walls={\"floor\": Follow(Displacement([(0.0, 0.0, 0.0), (0.1, 0.0, 50.0)]))}",
            "stages.release: in a time step",
        ),
    ] {
        let said = stdout(&clastic(&["check", "column_collapse_small", "--set", setting]).code(0));
        assert!(said.contains("WARNING: ") && said.contains(told), "{setting}: {said}");
    }
    // A centrifuge at 100 g.
    let centrifuge = ["check", "column_collapse_small", "--set", "gravity=(0.0, -981.0)"];
    let said = stdout(&clastic(&centrifuge).code(0));
    assert!(!said.contains("WARNING"), "{said}");
}

/// Time steps of 2 ms made a zigzag of a vibration of 100 Hz, and rest of one of 500 Hz.
#[test]
fn a_vibration_that_time_steps_do_not_resolve_is_told() {
    let said = |frequency: u32| {
        let names = format!("let={{\"f\": {frequency}.0, \"a\": 1e-4}}");
        let floor =
            "stages.release.walls={\"floor\": Follow(Displacement(0.0, a * sin(2 * pi * f * t)))}";
        let check = ["check", "column_collapse_small", "--set", &names, "--set", floor];
        stdout(&clastic(&check).code(0))
    };
    assert!(!said(50).contains("WARNING"), "{}", said(50));
    assert!(
        said(100).contains("walls.floor turns back and forth in 5.0 time steps"),
        "{}",
        said(100)
    );
    assert!(said(500).contains("walls.floor turns back and forth"), "{}", said(500));
}

/// Without a gravity a column stood, and the run was completed without a word.
#[test]
fn what_nothing_moves_and_what_is_pulled_away_is_told_before_the_run() {
    let said = |scene: &str, set: &str| stdout(&clastic(&["check", scene, "--set", set]).code(0));
    let still = said("column_collapse_small", "gravity=(0.0, 0.0)");
    assert!(still.contains("stages.settle: nothing moves or loads a particle"), "{still}");
    let pulled = said("biaxial_small", "stages.confine.walls.left.stress=-200e3");
    assert!(pulled.contains("walls.left: a load of -200000.0 pulls the wall away"), "{pulled}");
    let empty = said("column_collapse_small", "specimen=Particles([])");
    assert!(empty.contains("specimen: no particles; list some"), "{empty}");
}

/// Such a compaction made no increment, and its run went on with the packing as it was.
#[test]
fn a_compaction_to_a_looser_packing_is_refused() {
    for target in ["Porosity(0.75)", "Height(0.5)"] {
        let set = format!("stages.compact.target={target}");
        let (refused, _out) = run("oedometer", &["--quiet", "--set", &set]);
        let said = stderr(&refused.code(3));
        assert!(said.contains("as it begins, and its target is"), "{target}: {said}");
    }
}

#[test]
fn a_stop_that_held_when_its_stage_began_is_told() {
    let stop = "stages.load.stop=[Above(\"axial_stress\", 100.0e3)]";
    let (done, out) = run("biaxial_small", &["--quiet", "--set", stop]);
    let said = stdout(&done.code(0));
    assert!(said.contains("WARNING: stage load ended with its first increment: Above"), "{said}");
    assert_eq!(rows(out.path(), "history.csv").last().unwrap()["stage"], "load");
}

/// Two walls that a table drives through each other: exit code 3, with the place of their stage.
#[test]
fn walls_that_would_pass_each_other_have_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("meet.ron");
    let text = r#"(version: 1, title: "t",
        materials: { "m": (contact: (normal_stiffness: 1e6)) },
        specimen: Particles([(position: (0.5, 0.5), radius: 0.5)]),
        walls: [
            (name: "bottom", start: (0.0, 0.0), end: (1.0, 0.0), contact: (normal_stiffness: 1e3)),
            (name: "top", start: (1.0, 1.0), end: (0.0, 1.0), contact: (normal_stiffness: 1e3)),
        ],
        stages: [
            Load(name: "rest", increments: 1),
            Load(name: "meet", increments: 2, walls: { "top": Follow(Displacement([(0.0, 0.0, 0.0), (1.0, 0.0, -3.0)])) }),
        ])"#;
    fs::write(&path, text).unwrap();
    let (stopped, out) = run(path.to_str().unwrap(), &["--quiet"]);
    let said = stderr(&stopped.code(3));
    let place = out.path().join("scene.ron");
    let place = format!("{}:10:13: stages[1]: in stage `meet`: ", place.display());
    assert!(said.contains(&place) && said.contains("would meet or pass each other"), "{said}");
}
