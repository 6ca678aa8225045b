//! A run in two pieces, the second from the state that the first has saved, leaves the rows of a
//! run in one piece, byte for byte.

use std::fs;
use std::path::Path;

use clastic::output::directory;
use clastic::scene::{self, LoadedScene};
use clastic::tables::Tables;

use crate::common::files;
use crate::resumed::{COULOMB, rolling_elastically, run, same_from_anywhere};
use crate::same_bytes_of_rigs::{EXCAVATION, HINGED, POURED, THIN, TURNING};

const MEASURES: &str = r#"measures=[
    (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
    (name: "lateral_strain", of: Strain(Particles(0, 5))),
    (name: "axial_stress", of: Stress(Average(component: Yy, area: Fixed(3.6e-3)))),
]"#;

/// A scene of `scenes/`, or a text, under settings.
fn scene_of(rig: &str, sets: &[String]) -> LoadedScene {
    let path = format!("{}/scenes/{rig}.ron", env!("CARGO_MANIFEST_DIR"));
    let loaded = match rig {
        "COULOMB" => scene::from_str(COULOMB, Path::new("rig.ron"), Path::new(""), sets),
        "ROLLING" => {
            scene::from_str(&rolling_elastically(), Path::new("rig.ron"), Path::new(""), sets)
        }
        "THIN" => scene::from_str(THIN, Path::new("rig.ron"), Path::new(""), sets),
        "HINGED" => scene::from_str(HINGED, Path::new("rig.ron"), Path::new(""), sets),
        "TURNING" => scene::from_str(TURNING, Path::new("rig.ron"), Path::new(""), sets),
        "POURED" => scene::from_str(POURED, Path::new("rig.ron"), Path::new(""), sets),
        "RIGID" => scene::from_str(RIGID, Path::new("rig.ron"), Path::new(""), sets),
        "BIN" => scene::from_str(BIN, Path::new("rig.ron"), Path::new(""), sets),
        "CELL" => scene::from_str(CELL, Path::new("rig.ron"), Path::new(""), sets),
        "CELL_OF_A_STATE" => {
            let text = CELL.replace("    cell: (size: (0.0808, 0.0808)),\n", "");
            scene::from_str(&text, Path::new("rig.ron"), Path::new(""), sets)
        }
        "EXCAVATION" => scene::from_str(EXCAVATION, Path::new("rig.ron"), Path::new(""), sets),
        _ => scene::load(Path::new(&path), sets),
    };
    loaded.unwrap_or_else(|e| panic!("{e}"))
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap()
}

/// Runs a rig with the stages `first` and `second` in one piece and in two. All rows, frames and
/// files of the end must be equal. Returns the second scene and the rows of its history.
fn same_in_two(
    rig: &str,
    common: &[&str],
    [first, second]: [&str; 2],
    parent: &Path,
) -> (LoadedScene, Vec<String>) {
    let of = |rig: &str, more: &[String]| {
        let common = common.iter().map(|set| (*set).to_owned());
        scene_of(rig, &common.chain(more.iter().cloned()).collect::<Vec<_>>())
    };
    let with = |more: &[String]| of(rig, more);
    let [one, a, b] = ["one", "a", "b"].map(|name| parent.join(name));
    let whole = with(&[format!("stages=[{first}, {second}]")]);
    run(&whole, &one, 0, |_| {});
    run(&with(&[format!("stages=[{first}, Save(name: \"kept\")]")]), &a, 0, |_| {});
    let kept = a.join("state_kept.npz");
    // A state that is saved at the end is that of the end, and both name the last stage.
    assert_eq!(fs::read(&kept).unwrap(), fs::read(a.join(directory::FINAL_STATE)).unwrap());
    // The cell is that of the state.
    let from = of(
        if rig == "CELL" { "CELL_OF_A_STATE" } else { rig },
        &[
            format!("specimen=State(path: {:?})", kept.display().to_string()),
            "walls=[]".to_owned(),
            format!("stages=[{second}]"),
        ],
    );
    run(&from, &b, 0, |_| {});

    let mut rows = Vec::new();
    for name in [directory::HISTORY, directory::EVENTS, directory::AVALANCHES] {
        let (whole, part) = (text(&one.join(name)), text(&b.join(name)));
        let (mut whole, mut part) = (whole.lines(), part.lines());
        assert_eq!(whole.next(), part.next(), "header of {name}");
        let (whole, part): (Vec<_>, Vec<_>) = (whole.collect(), part.collect());
        let tail = &whole[whole.len() - part.len()..];
        for (expected, found) in tail.iter().zip(&part) {
            assert_eq!(found, expected, "{name}");
        }
        let stages = |rows: &[&str]| rows.iter().filter_map(|r| r.split(',').nth(1)).count();
        assert_eq!(stages(tail), stages(&part), "{name}");
        if name == directory::HISTORY {
            assert!(whole.len() > part.len() && !part.is_empty(), "{name}");
            rows = part.iter().map(|row| (*row).to_owned()).collect();
        }
    }
    let (whole, part) = (files(&one), files(&b));
    for name in [directory::FINAL_PARTICLES, directory::FINAL_STATE] {
        assert!(whole[Path::new(name)] == part[Path::new(name)], "{name} differs");
    }
    let frames = part.iter().filter(|(name, _)| name.starts_with(directory::FRAMES));
    for (name, bytes) in frames.filter(|(name, _)| name.extension() == Some("csv".as_ref())) {
        assert!(whole[name] == *bytes, "{} differs", name.display());
    }
    (from, rows)
}

/// A membrane goes on with its pressure, changes it in the second piece, and is measured there.
#[test]
fn membrane_under_a_pressure_that_changes() {
    let first = format!(
        r#"{CEMENT}, {CONFINE}, Load(name: "wrap", increments: 2, remove_walls: ["left", "right"],
            walls: {{ "bottom": Fixed, "top": Fixed }},
            membranes: {{ "sides": (pressure: 150e3, between: ("bottom", "top")) }})"#
    );
    let second = r#"Load(name: "load", increments: 4, walls: { "top": Displacement(0.0, -0.3e-3) },
        membranes: { "sides": (pressure: 180e3) })"#;
    let parent = tempfile::tempdir().unwrap();
    let common = [
        r#"let={ "stiffness": 60.0e6, "shear": 30.0e6, "strength": 50.0e3 }"#,
        "output=(frames_every: 2)",
    ];
    let (from, rows) =
        same_in_two("biaxial_membrane_small", &common, [&first, second], parent.path());
    assert_eq!(rows.len(), 4);
    same_from_anywhere(&from, |_| true);
}

const CEMENT: &str = "Cement(name: \"cement\", length: 2.0e-3)";

/// Confinement of `biaxial_small`.
const CONFINE: &str = r#"Load(name: "confine", increments: 3, walls: {
    "bottom": Stress(stress: 200.0e3, between: ("left", "right")),
    "top": Stress(stress: 200.0e3, between: ("left", "right")),
    "left": Stress(stress: 200.0e3, between: ("bottom", "top")),
    "right": Stress(stress: 200.0e3, between: ("bottom", "top")),
})"#;

/// Shear of `biaxial_small`: a stage of this name with some increments.
fn shear(name: &str, increments: u32) -> String {
    format!(
        r#"Load(name: "{name}", increments: {increments}, walls: {{
            "bottom": Displacement(0.0, 0.16e-3), "top": Displacement(0.0, -0.16e-3) }})"#
    )
}

#[test]
fn bonded_static() {
    for order in ["rupture.order=OneRound", "rupture.order=Events"] {
        let parent = tempfile::tempdir().unwrap();
        let first = format!("{CEMENT}, {CONFINE}, {}", shear("a", 2));
        let common = [order, "output=(frames_every: 3, energy: true)"];
        let (_, rows) =
            same_in_two("biaxial_small", &common, [&first, &shear("b", 3)], parent.path());
        let events = text(&parent.path().join("b").join(directory::EVENTS));
        assert!(events.lines().count() > 1, "{order}: no bond broke");
        assert!(rows.len() >= 3);
    }
}

#[test]
fn the_second_piece_is_resumed_without_the_state() {
    let parent = tempfile::tempdir().unwrap();
    let first = format!("{CEMENT}, {CONFINE}");
    let (from, _) = same_in_two("biaxial_small", &[], [&first, &shear("b", 4)], parent.path());
    let records = same_from_anywhere(&from, |_| true);
    assert_eq!(records.len(), 4);
    assert_eq!(records[0].increment, 4);
}

#[test]
fn uncemented_static_under_both_friction_laws() {
    for law in ["friction_law=Associated", "friction_law=Coulomb()"] {
        let parent = tempfile::tempdir().unwrap();
        let first = format!("{CONFINE}, {}", shear("a", 3));
        same_in_two("biaxial_small", &[law], [&first, &shear("b", 3)], parent.path());
        // Contacts between particles carry shear, or the history would not matter.
        let state = fs::read(parent.path().join("a/state_kept.npz")).unwrap();
        let tables = Tables::decode(&state).unwrap();
        let n = tables.rows("contacts.q_n").unwrap();
        let shear = tables.values::<f64>("contacts.q_n", &[n]).unwrap();
        assert!(shear.iter().filter(|q| q.abs() > 1.0).count() > 300, "{law}");
    }
}

/// The second piece begins with an `Until`, which reads its measure at the start of the stage.
#[test]
fn a_stage_that_lands_on_a_stress_begins_the_same_in_both() {
    for law in ["friction_law=Associated", "friction_law=Coulomb()"] {
        let parent = tempfile::tempdir().unwrap();
        let second = r#"Load(name: "up", increments: 9, walls: { "bottom": Fixed, "top": Displacement(0.0, -20.0e-6) },
                stop: [Until("axial_stress", 215.0e3)]),
            Load(name: "down", increments: 9, walls: { "top": Displacement(0.0, 20.0e-6) },
                stop: [Until("axial_stress", 205.0e3)])"#;
        let common = [
            law,
            r#"let={ "stiffness": 60.0e6, "shear": 30.0e6, "strength": 50.0e3 }"#,
            r#"measures=[(name: "axial_stress",
                of: Stress(Walls(walls: ["bottom", "top"], length: Between("left", "right"))))]"#,
        ];
        let (_, rows) =
            same_in_two("biaxial_membrane_small", &common, [CONFINE, second], parent.path());
        let json = text(&parent.path().join("b").join(directory::RUN));
        assert_eq!(json.matches("\"Until\"").count(), 2, "{law}: {json}");
        assert!(rows.len() > 3, "{law}: {rows:?}");
    }
}

/// A dynamic stage with an `Until` read the last time step before it, which a saved state does not
/// have: the second piece read a quarter of a time step, passed the value in it, and did not land.
#[test]
fn a_dynamic_stage_with_an_until_begins_the_same_from_a_saved_state() {
    let second = r#"
        Load(name: "fall", increments: 40, remove_walls: ["gate"],
            stop: [Until("kinetic_j", 0.0972)]),
        Load(name: "shake", increments: 20, walls: { "back": Velocity(0.05, 0.0) },
            stop: [Until("pushed_n", 2.0)])"#;
    let first = r#"Load(name: "rest", increments: 60)"#;
    let measures = r#"measures=[(name: "kinetic_j", of: KineticEnergy),
        (name: "pushed_n", of: WallForce(wall: "back", along: Normal))]"#;
    for law in ["friction_law=Associated", "friction_law=Coulomb()"] {
        let parent = tempfile::tempdir().unwrap();
        let (from, rows) = same_in_two("BIN", &[law, measures], [first, second], parent.path());
        let json = text(&parent.path().join("b").join(directory::RUN));
        assert_eq!(json.matches("\"Until\"").count(), 2, "{law}: {json}");
        assert!(rows.len() > 3, "{law}: {rows:?}");
        same_from_anywhere(&from, |n| n % 4 == 0);
    }
}

/// Elastic disks in a bin, of which one side can be taken away.
const BIN: &str = r#"(
    version: 1,
    title: "Bin",
    analysis: Dynamic(dt: 2.0e-3),
    gravity: (0.0, -9.81),
    materials: { "m": (density: 2000.0,
        contact: (normal_stiffness: 1.0e5, tangential_stiffness: 1.0e5, friction: 0.4)) },
    specimen: Packing(count: 24, columns: 4, spacing: 20.1e-3, sizes: Uniform(radius: (7.0e-3, 10.0e-3)), seed: 3),
    walls: [
        (name: "floor", start: (0.0, 0.0), end: (0.0804, 0.0), contact: (normal_stiffness: 1.0e5, friction: 0.4)),
        (name: "back", start: (0.0, 0.2), end: (0.0, 0.0), contact: (normal_stiffness: 1.0e5)),
        (name: "gate", start: (0.0804, 0.0), end: (0.0804, 0.2), contact: (normal_stiffness: 1.0e5)),
    ],
    stages: [],
)"#;

#[test]
fn dynamic_with_velocities_under_both_friction_laws() {
    let common = [
        "specimen.count=60",
        "specimen.columns=5",
        "walls.floor.end=(70.0e-3, 0.0)",
        "walls.back.start=(0.0, 0.2)",
        "walls.gate.start=(70.0e-3, 0.0)",
        "walls.gate.end=(70.0e-3, 0.2)",
        "walls.lid.start=(70.0e-3, 0.16)",
        "walls.lid.end=(0.0, 0.16)",
    ];
    let first = r#"
        Compact(name: "compact", wall: "lid", base: "floor", target: Porosity(0.35), step: 10.0e-3,
            agitation: 0.1, seed: 1),
        Load(name: "settle", increments: 5, remove_walls: ["lid"]),
        Load(name: "release", increments: 12, remove_walls: ["gate"])"#;
    let second = r#"Load(name: "later", increments: 12)"#;
    for law in ["friction_law=Associated", "friction_law=Coulomb()"] {
        for theta in ["1.0", "0.6"] {
            let parent = tempfile::tempdir().unwrap();
            let analysis = format!("analysis=Dynamic(dt: 2.0e-3, theta: {theta})");
            // Elastic contacts too, whose shear has a history.
            let elastic = "materials.stone.contact=(normal_stiffness: 1.0e5, \
                           tangential_stiffness: 5.0e4, friction: 0.5)";
            let mut common = common.to_vec();
            common.extend([law, &analysis]);
            if theta == "0.6" {
                common.push(elastic);
            }
            let (_, rows) =
                same_in_two("column_collapse_small", &common, [first, second], parent.path());
            // Time goes on, and the column is moving.
            let field =
                |row: &str, k: usize| -> f64 { row.split(',').nth(k).unwrap().parse().unwrap() };
            assert!((field(&rows[0], 2) - 0.036).abs() < 1e-12, "{}", rows[0]);
            assert!(field(&rows[0], 23) > 1e-3, "{}", rows[0]);
        }
    }
}

/// Walls that come, go and come back, ramps that a stop cuts short, loads on particles, a probe and
/// energies.
#[test]
fn walls_that_are_away_and_loads_that_were_cut_short() {
    let first = r#"
        Cement(name: "cement", length: 0.1e-3),
        Load(name: "confine", increments: 3, walls: {
            "top": Stress(stress: 20.0e3, between: ("left", "right")),
            "left": Stress(stress: 20.0e3, between: ("bottom", "top")),
            "right": Stress(stress: 20.0e3, between: ("bottom", "top")),
        }),
        Load(name: "unload", increments: 8, walls: {
            "top": Stress(stress: 5.0e3, between: ("left", "right")),
            "right": Stress(stress: 16.0e3, between: ("bottom", "top")),
        }, particles: [(select: Group("boundary"), force: (0.0, 1.0))],
        stop: [StressDrop(0.8)]),
        Load(name: "release", increments: 3, remove_walls: ["left"], walls: {
            "top": Force(500.0), "right": Fixed })"#;
    let second = r#"
        Load(name: "compress", increments: 6, walls: { "top": Displacement(0.0, -30.0e-6) },
            particles: [(select: Group("boundary"), moment: 1.0e-3)]),
        Load(name: "hold", increments: 2, add_walls: ["left"], gravity: (0.0, -9.81))"#;
    let common =
        ["reference_stage=None", MEASURES, "probes={\"corner\": 5}", "output=(energy: true)"];
    let parent = tempfile::tempdir().unwrap();
    same_in_two("COULOMB", &common, [first, second], parent.path());
    let record = text(&parent.path().join("a").join(directory::RUN));
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    assert_eq!(record["stages"][2]["ended_by"], "stop");
    assert!(record["stages"][2]["increments"].as_u64().unwrap() < 8);
}

/// Elastic moments go on from those of the state, with the compliances of its bonds and walls.
#[test]
fn rolling_moments_are_those_of_the_state() {
    let parent = tempfile::tempdir().unwrap();
    let first = r#"Cement(name: "cement", length: 0.1e-3),
        Load(name: "confine", increments: 3, walls: {
            "top": Stress(stress: 20.0e3, between: ("left", "right")),
            "left": Stress(stress: 20.0e3, between: ("bottom", "top")),
            "right": Stress(stress: 20.0e3, between: ("bottom", "top")) }),
        Load(name: "shear", increments: 3, walls: { "top": Displacement(10.0e-6, -10.0e-6) })"#;
    let second = r#"Load(name: "compress", increments: 6, walls: { "top": Displacement(5.0e-6, -30.0e-6) })"#;
    let common = ["reference_stage=None", MEASURES, "output=(energy: true)"];
    same_in_two("ROLLING", &common, [first, second], parent.path());
    let state = fs::read(parent.path().join("a/state_kept.npz")).unwrap();
    let state = Tables::decode(&state).unwrap();
    let moments =
        state.values::<f64>("contacts.tau_nm", &[state.rows("contacts.tau_nm").unwrap()]).unwrap();
    assert!(moments.iter().any(|moment| moment.abs() > 1e-6), "{moments:?}");
}

/// Segments, polylines, an arc, a lid and a table: their shapes, pieces and drives are in the
/// state.
#[test]
fn thin_walls_of_every_shape() {
    let parent = tempfile::tempdir().unwrap();
    let first = r#"
        Load(name: "settle", increments: 60, walls: { "bowl": Follow(Displacement([
            (0.0, 0.0, 0.0), (0.02, 0.0, 2.0e-3), (0.06, 0.0, -1.0e-3)])) }),
        Load(name: "press", increments: 6, analysis: Static, add_walls: ["lid"],
            walls: { "lid": Follow(Stress(stress: [(0.0, 0.0), (0.5, 300.0), (1.0, 200.0)])) }),
        Load(name: "shear", increments: 5, analysis: Static,
            walls: { "lid": Lid(load: Stress(stress: 200.0), slide: Displacement(1.0e-5)) }),
        Load(name: "cycle", increments: 3, analysis: Static, walls: { "lid": Stress(stress: 300.0) },
            scale: (loads: [(0.0, 0.0), (0.5, 1.0), (1.0, 0.5)]))"#;
    let second = r#"
        Load(name: "shear_on", increments: 5, analysis: Static,
            walls: { "lid": Lid(load: Stress(stress: 200.0), slide: Displacement(1.0e-5)) }),
        Load(name: "flow", increments: 20, remove_walls: ["gate", "lid"])"#;
    same_in_two("THIN", &["output=(energy: true)"], [first, second], parent.path());
}

/// Identities have gaps where particles were taken away before the state was saved, and bonds that
/// broke before name bodies that are gone.
#[test]
fn particles_that_were_taken_away() {
    let first = r#"Cement(name: "cement", length: 1.0e-4), Load(name: "stand", increments: 3),
        Remove(name: "dig", select: Box(min: (0.03, 0.03), max: (1.0, 1.0))),
        Load(name: "stand again", increments: 3),
        Remove(name: "more", select: Union([Index([3, 6]), Box(min: (-1.0, 0.06), max: (1.0, 1.0))]))"#;
    let second = r#"Load(name: "fall", increments: 12, analysis: Dynamic(dt: 2.0e-3))"#;
    let parent = tempfile::tempdir().unwrap();
    same_in_two("EXCAVATION", &["probes={}"], [first, second], parent.path());
    let events = text(&parent.path().join("a").join(directory::EVENTS));
    assert!(events.contains(",6,11,"), "no bond of particle 6 broke: {events}");
}

/// The tractions of an excavation are loads of the state, and their release goes on under the same bytes.
#[test]
fn tractions_that_are_released_in_two_stages() {
    let first = r#"Cement(name: "cement", length: 1.0e-4), Load(name: "stand", increments: 3),
        Remove(name: "dig", select: Circle(centre: (0.06, 0.02), radius: 0.012), keep_tractions: true),
        Load(name: "part", increments: 3, particles: [(select: All, remains: 0.4)])"#;
    let second = r#"Remove(name: "scale", select: Loose(2), keep_tractions: true),
        Load(name: "rest", increments: 4, particles: [(select: All, remains: 0.0)])"#;
    let measures = r#"measures=[
        (name: "closure", of: Ring(centre: (0.06, 0.02), radii: (0.012, 0.03), value: Closure)),
        (name: "support", of: Ring(centre: (0.06, 0.02), radii: (0.012, 0.03), value: Support))]"#;
    let parent = tempfile::tempdir().unwrap();
    let [cohesion, tension] =
        ["cohesion", "tensile_strength"].map(|limit| format!("materials.stone.bond.{limit}=1.0e5"));
    let common = ["probes={}", measures, &cohesion, &tension];
    let (from, rows) = same_in_two("EXCAVATION", &common, [first, second], parent.path());
    assert!(rows.len() >= 4, "{rows:?}");
    same_from_anywhere(&from, |_| true);
}

/// A wall that has turned, its shape and its rotation are in the state.
#[test]
fn walls_that_have_turned() {
    let first = r#"Cement(name: "cement", length: 1.0e-4, walls: true),
        Load(name: "tilt", increments: 4,
            walls: { "plate": Rotation(about: (-0.05, -0.01), angle: 2.0e-3) }),
        Load(name: "spin", increments: 10, analysis: Dynamic(dt: 2.0e-3), walls: {
            "flap": Spin(about: (0.125, 0.06), angular_velocity: 1.0),
            "drum": Spin(about: (0.0, 0.0), angular_velocity: 3.0) })"#;
    let second = r#"Load(name: "on", increments: 10, analysis: Dynamic(dt: 2.0e-3), walls: {
            "plate": Spin(about: (0.05, 0.0), angular_velocity: -2.0),
            "drum": Spin(about: (0.0, 0.0), angular_velocity: 3.0) })"#;
    let parent = tempfile::tempdir().unwrap();
    same_in_two("TURNING", &[], [first, second], parent.path());
}

/// Walls that belong to rigid groups do so in the state, with the moment on them.
#[test]
fn walls_in_rigid_groups() {
    let first = r#"Cement(name: "cement", length: 1.0e-4),
        Load(name: "lean", increments: 5, rigid: {
            "gate": (walls: ["gate"], about: (0.11, -0.01), x: Held, y: Held, moment: 0.5),
            "cap": (walls: ["vane"], select: Index([20, 21]), about: (0.04, 0.052), moment: 0.01) })"#;
    let second = r#"Load(name: "swing", increments: 10, analysis: Dynamic(dt: 2.0e-3), release: ["cap"], rigid: {
            "gate": (x: Held, y: Held, moment: 0.2) }),
        Load(name: "without", increments: 2, release: ["gate"])"#;
    for law in ["friction_law=Associated", "friction_law=Coulomb()"] {
        let parent = tempfile::tempdir().unwrap();
        let (from, rows) = same_in_two("HINGED", &[law], [first, second], parent.path());
        assert!(rows.len() >= 12, "{law}: {}", rows.len());
        assert_eq!(from.scene.rigid_at_start, ["cap", "gate"]);
    }
}

/// What was poured is in the state, and the next pour goes on after it: with its sizes and places.
#[test]
fn grains_that_are_poured_in_before_and_after() {
    let pour = |name: &str| {
        format!(
            r#"Pour(name: "{name}", increments: 20,
                through: Segment(start: (-0.06, 0.15), end: (0.06, 0.15)), rate: Number(250.0),
                sizes: Uniform(radius: (0.005, 0.01)), seed: 2, material: "a", minerals: {{ "b": 0.4 }},
                velocity: (0.0, -1.0), group: "new", stop: [Above("kg", 100.0)])"#
        )
    };
    for law in ["friction_law=Associated", "friction_law=Coulomb()"] {
        let parent = tempfile::tempdir().unwrap();
        let (from, rows) = same_in_two("POURED", &[law], [&pour("a"), &pour("b")], parent.path());
        assert_eq!(rows.len(), 20, "{law}");
        same_from_anywhere(&from, |n| n % 3 == 0);
    }
}

/// Bonded disks on a floor.
pub const RIGID: &str = r#"(
    version: 1,
    title: "Rigid groups",
    gravity: (0.0, -9.81),
    materials: { "m": (density: 2000.0,
        contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4),
        bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, cohesion: 1.0e7, tensile_strength: 1.0e7)) },
    specimen: Lattice(columns: 5, rows: 6, radius: 0.01),
    walls: [(name: "floor", start: (-1.0, -0.01), end: (1.0, -0.01), probe: "floor",
        contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4))],
    stages: [],
    measures: [(name: "on_upper", of: GroupForce(select: Box(min: (-1.0, 0.05), max: (1.0, 1.0)), along: Y))],
    output: (energy: true, frames_every: 2),
)"#;

/// Rigid groups are in the state: who belongs to them, where they are, what they carry and how they
/// move. The second piece controls one, releases one, and leaves one as it is.
#[test]
fn rigid_groups_in_both_analyses_under_both_laws() {
    let first = r#"Cement(name: "cement", length: 1.0e-4),
        Load(name: "press", increments: 4, rigid: {
            "lower": (select: Box(min: (-1.0, -1.0), max: (1.0, 0.02)), x: Held, rotation: Held),
            "middle": (select: Index([9, 10])),
            "upper": (select: Box(min: (-1.0, 0.07), max: (1.0, 1.0)),
                stress: (value: (0.0, -2.0e3), length: 0.1)) }),
        Load(name: "turn", increments: 3, rigid: {
            "upper": (x: Displacement(1.0e-6), rotation: Displacement(2.0e-5)) })"#;
    let second = r#"Load(name: "on", increments: 3, rigid: { "upper": (x: Displacement(-1.0e-6), moment: 0.01) }),
        Load(name: "apart", increments: 3, release: ["upper"]),
        Load(name: "again", increments: 2, rigid: {
            "upper": (select: Box(min: (-1.0, 0.07), max: (1.0, 1.0)), x: Held, y: Held) })"#;
    for common in [
        ["friction_law=Associated", "analysis=Static"],
        ["friction_law=Coulomb()", "analysis=Static"],
        ["friction_law=Associated", "analysis=Dynamic(dt: 1.0e-3, theta: 0.6)"],
        ["friction_law=Coulomb()", "analysis=Dynamic(dt: 1.0e-3)"],
    ] {
        let parent = tempfile::tempdir().unwrap();
        let (from, rows) = same_in_two("RIGID", &common, [first, second], parent.path());
        assert!(rows.len() >= 8, "{common:?}: {}", rows.len());
        assert_eq!(from.scene.rigid_at_start, ["lower", "middle", "upper"]);
        // Resumed from anywhere, also where `upper` is gone and where it is there again.
        same_from_anywhere(&from, |_| true);
    }
}

/// Bonded and unbonded disks in a periodic cell.
pub const CELL: &str = r#"(
    version: 1,
    title: "Periodic cell",
    materials: { "sand": (density: 2650.0,
        contact: (normal_stiffness: 2.0e7, tangential_stiffness: 2.0e7, friction: 0.4),
        bond: (normal_stiffness: 2.0e7, tangential_stiffness: 1.0e7, friction: 0.4, cohesion: 2.0e4,
            tensile_strength: 2.0e4)) },
    specimen: Packing(count: 64, columns: 8, spacing: 10.1e-3, sizes: Uniform(radius: (3.0e-3, 5.0e-3)), seed: 11),
    cell: (size: (0.0808, 0.0808)),
    stages: [],
    measures: [
        (name: "axial_strain", of: Strain(Cell(Height))),
        (name: "axial_stress", of: Stress(Average(component: Yy, area: Cell))),
        (name: "shear_strain", of: Strain(Cell(Shear))),
        (name: "shear_stress_pa", of: Stress(Average(component: Shear, area: Cell))),
        (name: "porosity", of: Porosity(Cell)),
    ],
    output: (frames_every: 2),
)"#;

/// A periodic cell is in the state: its size, tilt and shear, its stresses, and those that it keeps.
/// The second piece takes over a stress, changes to the mean stress and back, and moves.
#[test]
fn periodic_cells_in_both_analyses_under_both_laws() {
    let prepare = r#"Compact(name: "compact", target: Porosity(0.2), step: 2.0e-3, agitation: 0.1, seed: 11),
        Load(name: "confine", increments: 3, cell: (xx: Stress(50.0e3), yy: Stress(50.0e3), shear: Stress(0.0))),
        Load(name: "shear", increments: 4, cell: (shear: Strain(0.008)))"#;
    let by_mean = format!(
        r#"{prepare}, Cement(name: "cement", length: 1.0e-4),
        Load(name: "mean", increments: 3, cell: (mean: Stress(40.0e3), difference: Strain(0.001)))"#
    );
    let second = r#"Load(name: "keep", increments: 2),
        Load(name: "on", increments: 4, cell: (shear: Strain(0.008), mean: Stress(30.0e3))),
        Load(name: "apart", increments: 3, cell: (xx: Fixed, yy: Stress(60.0e3), shear: Stress(0.0)))"#;
    for law in ["friction_law=Associated", "friction_law=Coulomb()"] {
        for (first, analysis) in [
            (prepare, "analysis=Static"),
            (by_mean.as_str(), "analysis=Static"),
            (prepare, "analysis=Dynamic(dt: 1.0e-4)"),
        ] {
            let parent = tempfile::tempdir().unwrap();
            let common = [law, analysis];
            let (from, rows) = same_in_two("CELL", &common, [first, second], parent.path());
            assert!(rows.len() >= 9, "{common:?}: {}", rows.len());
            let sets = [
                format!("specimen=State(path: {:?})", parent.path().join("a/state_kept.npz")),
                format!("stages=[{second}]"),
            ];
            let error = scene::from_str(CELL, Path::new("rig.ron"), Path::new(""), &sets);
            let error = error.unwrap_err().to_string();
            assert!(error.contains("cell: the state has a periodic cell already"), "{error}");
            let state = fs::read(parent.path().join("a/state_kept.npz")).unwrap();
            let tables = Tables::decode(&state).unwrap();
            let size = tables.values::<f64>("cell.size_m", &[3]).unwrap();
            assert!(size[0] < 0.08 && size[1] < 0.08 && size[2] > 1e-4, "{size:?}");
            same_from_anywhere(&from, |n| n % 2 == 1);
        }
    }
}
