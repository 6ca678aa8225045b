//! The language of scenes: measures with names, conditions on them, repeated stages and
//! values with names.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use clastic::components::measure::Readings;
use clastic::components::observation::Observation;
use clastic::output::{self, OutputPlugin, RunOptions};
use clastic::run::measures::reading;
use clastic::run::stages::Script;
use clastic::run::{EndedBy, Outcome, Simulation, Step};
use clastic::scene::format::{Scene, Stop};
use clastic::scene::{LoadedScene, from_str};

fn read(text: &str, sets: &[&str]) -> LoadedScene {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    from_str(text, &scenes.join("s.ron"), &scenes, &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// `history.csv` of a run.
fn history(loaded: &LoadedScene) -> String {
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { directory: out.path().to_owned(), ..Default::default() };
    let mut loaded = loaded.clone();
    loaded.scene.output.plots = false;
    let specimen = loaded.specimen.as_ref();
    let mut simulation =
        Simulation::in_app(clastic::run::app(OutputPlugin), &loaded.scene, specimen);
    output::begin(simulation.world_mut(), options, &loaded).unwrap();
    let outcome = simulation.run();
    output::finish(simulation.world_mut(), Some(&outcome)).unwrap();
    fs::read_to_string(out.path().join("history.csv")).unwrap()
}

fn shipped(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.ron"));
    fs::read_to_string(path).unwrap()
}

fn near(found: Option<f64>, expected: f64, tolerance: f64) {
    let found = found.unwrap_or(f64::NAN);
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} for {expected}");
}

/// A lid presses a row of disks against a floor: two disks touch both, a third touches the floor
/// only.
const ROW: &str = r#"(
    version: 1, title: "row", thickness: 0.5,
    let: { "k": 1.0e6, "down": 1.0e-4 },
    materials: { "m": (contact: (normal_stiffness: k)) },
    specimen: Particles([
        (position: (1.5, 1.0), radius: 1.0), (position: (4.0, 1.0), radius: 1.0),
        (position: (7.0, 0.5), radius: 0.5),
    ]),
    walls: [
        (name: "floor", start: (0.0, 0.0), end: (8.0, 0.0), contact: (normal_stiffness: k)),
        (name: "lid", start: (8.0, 2.0), end: (0.0, 2.0), contact: (normal_stiffness: k)),
        (name: "left", start: (0.0, 2.0), end: (0.0, 0.0)),
        (name: "right", start: (8.0, 0.0), end: (8.0, 2.0)),
    ],
    stages: [Load(name: "press", increments: 10, walls: { "lid": Displacement(0.0, -down) },
        stop: [Above("push", 140.0)])],
    measures: [
        (name: "axial_strain", of: Strain(Walls("floor", "lid"))),
        (name: "push", of: WallForce(wall: "lid")),
        (name: "push_y", of: WallForce(wall: "lid", along: Y)),
        (name: "push_t", of: WallForce(wall: "lid", along: Tangent)),
        (name: "s", of: Stress(Walls(walls: ["floor", "lid"], length: Between("left", "right")))),
        (name: "all", of: Stress(Average(component: Yy, area: Fixed(16.0)))),
        (name: "region", of: Stress(Region(component: Yy, min: (-1.0, -1.0), max: (7.0, 3.0)))),
        (name: "lower", of: Stress(Region(component: Yy, min: (0.0, 0.0), max: (8.0, 1.0)))),
        (name: "closer", of: Strain(Particles(0, 1))),
        (name: "n", of: Porosity(Box(("floor", "lid"), ("left", "right")))),
        (name: "z", of: Coordination()),
        (name: "z_m", of: Coordination(rattlers: false)),
        (name: "elastic", of: ElasticEnergy),
        (name: "ratio", of: KineticOverElastic),
        (name: "broken", of: Broken(All)),
        (name: "share", of: BrokenShare(All)),
        (name: "t", of: Time),
    ],
)"#;

#[test]
fn measures_agree_with_a_calculation_by_hand() {
    let mut simulation = Simulation::new(&read(ROW, &[]).scene, None);
    assert_eq!(simulation.step(), Step::Increment);
    let value = |name| reading(simulation.world(), name);
    // Two disks, each with two springs of k in a row: f = k/2 * down each.
    let f = 0.5e6 * 1.0e-4;
    near(value("push"), 2.0 * f, 1e-6);
    near(value("push_y"), -2.0 * f, 1e-6);
    assert!(value("push_t").unwrap().abs() < 1e-6);
    let stress = 2.0 * f / (8.0 * 0.5);
    for name in ["s", "all", "lower"] {
        near(value(name), stress, 1e-3);
    }
    // The region has half the area of `all`, twice, and every branch lies in it.
    near(value("region"), value("all").unwrap() * 16.0 / 32.0, 1e-12);
    near(value("axial_strain"), 0.5e-4, 1e-9);
    assert!(value("closer").unwrap().abs() < 1e-6);
    near(value("n"), 1.0 - PI * 2.25 / (8.0 * (2.0 - 1.0e-4)), 1e-9);
    // Four contacts of three disks; the third disk carries nothing.
    near(value("z"), 4.0 / 3.0, 1e-12);
    assert_eq!(value("z_m"), Some(2.0));
    near(value("elastic"), 4.0 * 0.5 * f * f / 1.0e6, 1e-6);
    assert_eq!((value("ratio"), value("t")), (Some(0.0), Some(0.0)));
    assert_eq!((value("broken"), value("share")), (Some(0.0), None));
    assert_eq!(value("no such measure"), None);
}

#[test]
fn a_stage_stops_at_any_measure_and_the_history_has_a_column_of_each() {
    let loaded = read(ROW, &[]);
    let mut simulation = Simulation::new(&loaded.scene, None);
    assert_eq!(simulation.run(), Outcome::Completed);
    let end = simulation.world().resource::<Script>().ends[0].clone();
    // 100 N in the first increment, 200 N in the second.
    assert_eq!((end.increments, end.ended_by), (2, Some(EndedBy::Stop)));
    assert_eq!(end.stop, Some(Stop::Above("push".to_owned(), 140.0)));
    let history = history(&loaded);
    let mut lines = history.lines();
    let header = lines.next().unwrap();
    let tail =
        ",caps,push,push_y,push_t,s,all,region,lower,closer,n,z,z_m,elastic,ratio,broken,share,t";
    assert!(header.ends_with(tail), "{header}");
    assert!(lines.all(|line| line.split(',').count() == header.split(',').count()), "{history}");
}

/// A bonded lattice under a platen that comes down by 40 um in every increment, without a stop: the
/// readings of a measure. A stage that stops by a value between two of them ends with the first row
/// beyond, and its rows up to there are the same. In time steps the kinetic energy counts.
#[test]
fn a_stage_stops_by_every_kind_of_measure() {
    let stop = |law: &str, analysis: &str, kind: &str, stop: &str| {
        let text = format!(
            r#"(version: 1, title: "stops", friction_law: {law}, analysis: {analysis},
            materials: {{ "m": (density: 2000.0,
                contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.3),
                bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.3,
                    cohesion: 2.0e3, tensile_strength: 1.0e3)) }},
            rupture: (order: OneRound),
            specimen: Lattice(columns: 4, rows: 5, radius: 0.01, origin: (0.01, 0.01)),
            groups: {{ "low": Layer(normal: (0.0, 1.0), from: 0.0, to: 0.02) }},
            walls: [
                (name: "floor", start: (-0.1, 0.0), end: (0.2, 0.0), contact: (normal_stiffness: 1.0e6)),
                (name: "lid", start: (0.2, 0.0892820), end: (-0.1, 0.0892820),
                    contact: (normal_stiffness: 1.0e6)),
            ],
            stages: [Cement(name: "cement", length: 1.0e-4),
                Load(name: "press", increments: 12, walls: {{ "lid": Displacement(0.0, -4.0e-5) }},
                    stop: [{stop}])],
            measures: [(name: "m", of: {kind})])"#
        );
        let rows = readings(&read(&text, &[]).scene, "m");
        rows.into_iter().map(|(_, _, reading)| reading).collect::<Vec<_>>()
    };
    let kinds = [
        "Stress(Walls(walls: [\"floor\", \"lid\"], length: Fixed(0.08)))",
        "Stress(Average(component: Mean, area: Fixed(7.0e-3)))",
        "Stress(Region(component: Yy, min: (0.0, 0.02), max: (0.08, 0.06)))",
        "Strain(Walls(\"floor\", \"lid\"))",
        "Strain(Particles(0, 3))",
        "Strain(Region(component: Xx, min: (0.0, 0.0), max: (0.08, 0.09)))",
        "WallForce(wall: \"lid\")",
        "GroupForce(select: Group(\"low\"), along: Y)",
        "Broken(All)",
        "BrokenShare(All)",
        "Coordination(rattlers: false)",
        "ElasticEnergy",
        "Fabric(component: Yy, network: All)",
        "Cracks(part: Length)",
        "Time",
        "KineticEnergy",
        "KineticOverElastic",
    ];
    for law in ["Associated", "Coulomb()"] {
        for analysis in ["Static", "Dynamic(dt: 2.0e-3)"] {
            for kind in kinds {
                let whole = stop(law, analysis, kind, "");
                assert_eq!(whole.len(), 12, "{law} {analysis} {kind}");
                // The first change by which a stop can tell two rows apart.
                let values: Vec<f64> = whole.iter().map(|m| m.unwrap_or(f64::NAN)).collect();
                let scale = values.iter().fold(1e-6, |a: f64, b| a.max(b.abs()));
                let changes = |k: &usize| (values[*k] - values[*k - 1]).abs() > 1e-3 * scale;
                let of_time = kind.starts_with("Kinetic") || kind == "Time";
                let Some(k) = (1..12).find(changes) else {
                    assert!(of_time && analysis == "Static", "{law} {analysis} {kind}: {values:?}");
                    continue;
                };
                let between = 0.5 * (values[k] + values[k - 1]);
                let rises = values[k] > values[k - 1];
                let all_before = |side: &dyn Fn(f64) -> bool| values[..k].iter().all(|v| side(*v));
                assert!(all_before(&|v| (v < between) == rises), "{kind}: {values:?}");
                let condition = if rises { "Above" } else { "Below" };
                let said = format!("{condition}(\"m\", {between:?})");
                let stopped = stop(law, analysis, kind, &said);
                assert_eq!(stopped, whole[..=k], "{law} {analysis} {kind} {said}");
            }
        }
    }
}

#[test]
fn bonds_that_break_are_counted_by_mode() {
    let text = r#"(
        version: 1, title: "pulled apart",
        materials: { "m": (bond: (normal_stiffness: 8.0e6, cohesion: 4.0e3, tensile_strength: 2.0e3)) },
        specimen: Particles([
            (position: (0.0, 0.0), radius: 6.0e-3), (position: (12.0e-3, 0.0), radius: 6.0e-3),
            (position: (24.0e-3, 0.0), radius: 6.0e-3),
        ]),
        bonds: [(a: 0, b: 1), (a: 1, b: 2)],
        stages: [Load(name: "pull", increments: 9, stop: [Above("cracks", 1.0)], particles: [
            (select: Index([0, 1]), x: Held, y: Held, rotation: Held),
            (select: Index([2]), x: Displacement(1.0e-6), y: Held, rotation: Held),
        ])],
        measures: [
            (name: "cracks", of: Broken(Tension)), (name: "sheared", of: Broken(Shear)),
            (name: "share", of: BrokenShare(All)),
        ],
    )"#;
    let mut simulation = Simulation::new(&read(text, &[]).scene, None);
    assert_eq!(simulation.run(), Outcome::Completed);
    let value = |name| reading(simulation.world(), name);
    assert_eq!(
        (value("cracks"), value("sheared"), value("share")),
        (Some(1.0), Some(0.0), Some(0.5))
    );
    assert!(simulation.world().resource::<Observation>().increment < 9);
}

#[test]
fn a_falling_disk_has_its_kinetic_energy_and_stops_by_time() {
    let text = r#"(
        version: 1, title: "falls", gravity: (0.0, -10.0), friction_law: Coulomb(),
        let: { "dt": 1.0e-3 },
        analysis: Dynamic(dt: dt, theta: 1.0),
        materials: { "m": (density: 1000.0) },
        specimen: Particles([(position: (0.0, 1.0), radius: 0.1)]),
        stages: [Load(name: "fall", increments: 100, stop: [Above("clock", 0.05)])],
        measures: [(name: "clock", of: Time), (name: "work", of: KineticEnergy),
            (name: "ratio", of: KineticOverElastic)],
    )"#;
    let mut simulation = Simulation::new(&read(text, &[]).scene, None);
    assert_eq!(simulation.run(), Outcome::Completed);
    let value = |name| reading(simulation.world(), name);
    near(value("clock"), 0.05, 1e-12);
    // m v^2 / 2 with v = g t, exact for a constant force.
    near(value("work"), 0.5 * 1000.0 * PI * 0.01 * 0.25, 1e-9);
    assert_eq!(value("ratio"), None);
}

#[test]
fn a_resumed_run_reads_the_same_measures() {
    for (name, steps) in [("unload_reload", 17), ("unload_reload", 31)] {
        let loaded = read(&shipped(name), &[]);
        let mut whole = Simulation::new(&loaded.scene, None);
        for _ in 0..steps {
            assert_eq!(whole.step(), Step::Increment);
        }
        let state = whole.state().unwrap();
        let mut resumed = Simulation::resume(&loaded.scene, &state).unwrap();
        let readings = |s: &Simulation| s.world().resource::<Readings>().clone();
        assert!(readings(&resumed).0.iter().all(Option::is_some));
        assert_eq!(readings(&resumed), readings(&whole));
        assert_eq!(resumed.run(), whole.run());
        assert_eq!(readings(&resumed), readings(&whole));
        assert_eq!(resumed.state().unwrap(), whole.state().unwrap());
    }
}

#[test]
fn repeated_stages_have_names_of_their_own() {
    let text = shipped("unload_reload");
    let names = |sets: &[&str]| -> Vec<String> {
        let loaded = read(&text, sets);
        loaded.scene.stages.iter().map(|stage| stage.name().to_owned()).collect()
    };
    let expected = ["load.1", "unload.1", "load.2", "unload.2", "load.3", "unload.3"];
    assert_eq!(names(&[]), expected);
    assert_eq!(names(&["stages[0].times=1"]), expected[..2]);
    let nested = text.replace("Repeat(times: 3", "Repeat(times: 2, stages: [Repeat(times: 2");
    let nested = nested.replace("        ]),\n    ],\n    ref", "        ])]),\n    ],\n    ref");
    let nested = read(&nested.replace("\"load.1\"", "\"load.1.1\""), &[]);
    assert_eq!(nested.scene.stages[4].name(), "load.2.1");
    // A setting holds for every repetition.
    let loaded = read(&text, &["stages[0].stages.load.increments=7"]);
    let clastic::scene::format::Stage::Load(third) = &loaded.scene.stages[4] else { panic!() };
    assert_eq!((third.name.as_str(), third.increments), ("load.3", 7));
}

#[test]
fn unloading_and_reloading_an_elastic_layer_loses_nothing() {
    let mut simulation = Simulation::new(&read(&shipped("unload_reload"), &[]).scene, None);
    let mut last = f64::NAN;
    while simulation.step() == Step::Increment {
        let record = simulation.world().resource::<Observation>().clone();
        let [strain, stress] = [record.axial_strain, record.axial_stress].map(Option::unwrap);
        assert!((stress - 8.0e6 * strain).abs() < 2e-3, "{stress} at {strain}");
        last = stress;
    }
    assert!(last.abs() < 2e-3, "{last}");
    let ends = &simulation.world().resource::<Script>().ends;
    assert!(
        ends.iter().all(|end| (end.increments, end.ended_by) == (10, Some(EndedBy::Stop))),
        "{ends:?}"
    );
}

#[test]
fn a_value_with_a_name_is_set_once() {
    let loaded = read(ROW, &["let.k=2.0e6", "let.down=-3.0e-4"]);
    assert_eq!(loaded.scene.materials["m"].contact.normal_stiffness, Some(2.0e6));
    assert_eq!(loaded.scene.walls[1].contact.normal_stiffness, Some(2.0e6));
    let clastic::scene::format::Stage::Load(stage) = &loaded.scene.stages[0] else { panic!() };
    let down = clastic::scene::format::WallControl::Displacement(0.0, 3.0e-4);
    assert_eq!(stage.walls["lid"], down);
    // The stored scene keeps the names.
    assert!(loaded.text.contains("\"k\": 2.0e6") && loaded.text.contains("normal_stiffness: k"));
    let other = read(ROW, &["thickness=down"]);
    assert_eq!(other.scene.thickness, 1.0e-4);
}

#[test]
fn expressions_stand_for_numbers() {
    let text =
        ROW.replace("\"down\": 1.0e-4", "\"gap\": 1.0, \"down\": gap / 1e4, \"turns\": 2 + 1");
    let text =
        text.replace("normal_stiffness: k)", "normal_stiffness: 2 * k, friction: tan(pi / 6))");
    let text = text.replace("increments: 10,", "increments: turns * 2,");
    let loaded = read(&text, &["thickness=sqrt(0.25) * 3", "let.k=4.0e6 / 4"]);
    let contact = &loaded.scene.materials["m"].contact;
    assert_eq!(contact.normal_stiffness, Some(2.0e6));
    assert!((contact.friction - 1.0 / 3.0_f64.sqrt()).abs() < 1e-15);
    assert_eq!(loaded.scene.thickness, 1.5);
    let clastic::scene::format::Stage::Load(stage) = &loaded.scene.stages[0] else { panic!() };
    assert_eq!(stage.increments, 6);
    let down = clastic::scene::format::WallControl::Displacement(0.0, -1.0e-4);
    assert_eq!(stage.walls["lid"], down);
    // The stored scene keeps the expressions.
    assert!(loaded.text.contains("normal_stiffness: 2 * k") && loaded.text.contains("4.0e6 / 4"));
}

#[test]
fn a_mistake_in_a_value_is_placed_where_its_name_stands() {
    let sets = ["let.k=-1.0".to_owned()];
    let error = from_str(ROW, Path::new("s.ron"), Path::new(""), &sets).unwrap_err().to_string();
    let first = error.lines().next().unwrap();
    let expected = "s.ron:4:52: materials.m.contact.normal_stiffness: negative (-1.0); \
                    give a stiffness in N/m greater than 0, or leave it out for a rigid law";
    assert_eq!(first, expected);
}

/// Readings of a measure, and fractions, of all increments of a scene.
fn readings(scene: &Scene, name: &str) -> Vec<(String, f64, Option<f64>)> {
    let mut simulation = Simulation::new(scene, None);
    let mut rows = Vec::new();
    while simulation.step() == Step::Increment {
        let record = simulation.world().resource::<Observation>();
        assert!(record.residuals.worst() <= 1e-8);
        rows.push((record.stage.clone(), record.fraction, reading(simulation.world(), name)));
    }
    rows
}

#[test]
fn until_lands_on_a_stress_by_displacement_and_by_load() {
    let text = shipped("unload_reload");
    let text = text.replace("Above(\"axial_stress\", top)", "Until(\"axial_stress\", top)");
    let text = text.replace("Below(\"axial_stress\", 0.0)", "Until(\"axial_stress\", 0.0)");
    // 10.35 increments up.
    let loaded = read(&text, &["let.top=20.7e3"]);
    let rows = readings(&loaded.scene, "axial_stress");
    for (k, (stage, _, stress)) in rows.iter().enumerate() {
        if rows.get(k + 1).is_none_or(|next| next.0 != *stage) {
            let (stress, target) =
                (stress.unwrap(), if stage.starts_with("load") { 20.7e3 } else { 0.0 });
            assert!((stress - target).abs() <= 1e-6 * 20.7e3, "{stage}: {stress}");
        }
    }
    let per_stage = |name: &str| rows.iter().filter(|row| row.0 == name).count();
    // Ten whole ones and 0.35.
    assert_eq!(per_stage("load.1"), 11, "{rows:?}");
    let sum = |name: &str| rows.iter().filter(|row| row.0 == name).map(|row| row.1).sum::<f64>();
    assert!((sum("load.1") - 10.35).abs() < 1e-4 && (sum("unload.1") - 10.35).abs() < 1e-4);

    // A load on its way to 40 kPa stops at 25.3 kPa, and the next stage keeps it.
    let control = "Stress(stress: 40.0e3)";
    let text = shipped("unload_reload").replace("Displacement(0.0, -step)", control);
    let text = text.replace("Displacement(0.0, step)", "Stress(stress: 0.0)");
    let text = text.replace("Above(\"axial_stress\", top)", "Until(\"axial_stress\", 25.3e3)");
    let text =
        text.replace(", \"step\": 1.0e-5", "").replace("\"top\": 20.0e3", "\"stiffness\": 1.0e7");
    let text =
        text.replace("{ \"stiffness\": 1.0e7, \"stiffness\": 1.0e7 }", "{ \"stiffness\": 1.0e7 }");
    let text = text.replace("increments: 20, walls: { \"lid\": Stress(stress: 0.0) },\n                stop: [Below(\"axial_stress\", 0.0)]", "increments: 3, walls: { \"lid\": Stress(stress: 0.0) }");
    let rows = readings(&read(&text, &["stages[0].times=1"]).scene, "axial_stress");
    let last = rows.iter().rev().find(|row| row.0 == "load.1").unwrap().2.unwrap();
    assert!((last - 25.3e3).abs() <= 1e-6 * 25.3e3, "{last}");
    let first = rows.iter().find(|row| row.0 == "unload.1").unwrap().2.unwrap();
    // A third of the way back to zero.
    assert!((first - 25.3e3 * 2.0 / 3.0).abs() <= 1e-4 * 25.3e3, "{first}");
}

#[test]
fn until_lands_on_an_energy_in_dynamics() {
    for law in ["Associated", "Coulomb()"] {
        let text = r#"(
            version: 1, title: "falls", gravity: (0.0, -10.0), friction_law: LAW,
            analysis: Dynamic(dt: 1.0e-3, theta: 0.5),
            materials: { "m": (density: 1000.0) },
            specimen: Particles([(position: (0.0, 1.0), radius: 0.1)]),
            stages: [Load(name: "fall", increments: 100, stop: [Until("work", 1.0)])],
            measures: [(name: "work", of: KineticEnergy), (name: "clock", of: Time)],
        )"#;
        let loaded = read(&text.replace("LAW", law), &[]);
        let work = readings(&loaded.scene, "work").last().unwrap().2;
        near(work, 1.0, 2e-6);
        // m (g t)^2 / 2 = 1 J.
        let time = (2.0 / (1000.0 * PI * 0.01) / 100.0_f64).sqrt();
        near(readings(&loaded.scene, "clock").last().unwrap().2, time, 2e-6);
    }
}

#[test]
fn a_run_resumed_on_the_way_to_a_value_lands_the_same() {
    let text = shipped("unload_reload")
        .replace("Above(\"axial_stress\", top)", "Until(\"axial_stress\", 20.7e3)");
    let loaded = read(&text.replace("\"top\": 20.0e3, ", ""), &[]);
    for steps in [1, 2, 9, 11, 14] {
        let mut whole = Simulation::new(&loaded.scene, None);
        for _ in 0..steps {
            assert_eq!(whole.step(), Step::Increment);
        }
        let state = whole.state().unwrap();
        let mut resumed = Simulation::resume(&loaded.scene, &state).unwrap();
        assert_eq!(resumed.run(), whole.run());
        assert_eq!(resumed.state().unwrap(), whole.state().unwrap(), "{steps}");
    }
}

#[test]
fn isotropic_compression_balances_solid_fraction_and_energy() {
    let loaded = read(&shipped("isotropic_compression"), &[]);
    let mut simulation = Simulation::new(&loaded.scene, None);
    let (mut before, mut work, mut start) = (None, 0.0, None);
    while simulation.step() == Step::Increment {
        let record = simulation.world().resource::<Observation>().clone();
        let value = |name| reading(simulation.world(), name).unwrap_or(f64::NAN);
        let energy = value("elastic_energy_j");
        if record.stage == "confine" {
            start = Some((value("porosity"), energy));
        }
        let Some((porosity, stored)) = start.filter(|_| record.stage == "compress") else {
            continue;
        };
        let [axial, lateral] = [record.axial_strain, record.lateral_strain].map(Option::unwrap);
        let [s, t] = [record.axial_stress, record.lateral_stress].map(Option::unwrap);
        assert!((s - t).abs() < 1e-8 * s, "{s} {t}");
        let solid = (1.0 - porosity) / ((1.0 - axial) * (1.0 - lateral));
        near(Some(1.0 - value("porosity")), solid, 1e-9);
        // Forces follow the springs: work per area, by the trapezium rule, against energy.
        let (s0, a0, l0) = before.unwrap_or((10.0e3, 0.0, 0.0));
        work += 0.5 * (s + s0) * ((axial - a0) + (lateral - l0));
        before = Some((s, axial, lateral));
        let area = PI * disks(&simulation) / (1.0 - porosity);
        let share = (energy - stored) / (work * area);
        // Friction takes the rest; the trapezium rule has an error below 1 %.
        assert!(share > 0.0 && share < 1.01, "{share}");
    }
    let (s, ..) = before.unwrap();
    let ends = &simulation.world().resource::<Script>().ends;
    assert_eq!(ends[2].stop, Some(Stop::Until("axial_stress".to_owned(), 80.0e3)));
    assert_eq!((ends[2].passed, ends[2].warning()), (None, None));
    assert!((s - 80.0e3).abs() <= 80.0e3 * 1e-6, "{s}");
}

/// Sum of the squared radii, m^2.
fn disks(simulation: &Simulation) -> f64 {
    let bodies = simulation.world().resource::<clastic::components::contact::BodyTable>();
    bodies.radii.iter().map(|r| r * r).sum()
}

/// The number of broken bonds jumps from 0 to 1: no fraction of an increment lands on a half. The
/// stage ends there, and says so.
#[test]
fn a_measure_that_jumps_over_its_value_is_said_to_have_passed_it() {
    let text = r#"(
        version: 1, title: "pull", rupture: (order: OneRound),
        materials: { "m": (density: 2000.0, bond: (normal_stiffness: 1.0e6,
            tangential_stiffness: 1.0e6, cohesion: 1.0e6, tensile_strength: 1.0e3)) },
        specimen: Particles([(position: (0.0, 0.0), radius: 0.01), (position: (0.02, 0.0), radius: 0.01)]),
        bonds: [(a: 0, b: 1)],
        stages: [Load(name: "pull", increments: 20, particles: [
            (select: Index([0]), x: Held, y: Held, rotation: Held),
            (select: Index([1]), x: Displacement(2.0e-6), y: Held, rotation: Held),
        ], stop: [Until("broken", 0.5)])],
        measures: [(name: "broken", of: Broken(All))],
    )"#;
    let mut simulation = Simulation::new(&read(text, &[]).scene, None);
    while simulation.step() == Step::Increment {}
    let end = simulation.world().resource::<Script>().ends[0].clone();
    assert_eq!(end.stop, Some(Stop::Until("broken".to_owned(), 0.5)));
    assert_eq!(end.passed, Some(1.0));
    let said = end.warning().unwrap();
    assert!(said.contains("ends at broken = 1.0, beyond 0.5"), "{said}");
}
