//! Saved states: written by a run, started from by another, read by numpy.

use std::fs;
use std::path::Path;
use std::process::Command;

use clastic::saved::SavedState;
use clastic::tables::Tables;

use crate::call::{ROOT, clastic, edited, json, read, rows, run, stderr, stdout};

/// `biaxial_small` up to its confinement of 3 increments, with a state that is kept.
const SHORT: [&str; 3] = [
    "--set",
    r#"stages=[Cement(name: "cement", length: 2.0e-3), Load(name: "confine", increments: 3, walls: {
        "bottom": Stress(stress: 200.0e3, between: ("left", "right")),
        "top": Stress(stress: 200.0e3, between: ("left", "right")),
        "left": Stress(stress: 200.0e3, between: ("bottom", "top")),
        "right": Stress(stress: 200.0e3, between: ("bottom", "top")) }), Save(name: "kept at 200 kPa")]"#,
    "--quiet",
];

fn tables(path: &Path) -> Tables {
    Tables::decode(&fs::read(path).unwrap()).unwrap()
}

/// A scene that starts from the state in a directory, with materials and further fields.
fn from_state(directory: &Path, materials: &str, fields: &str, state: &str) -> String {
    let text = format!(
        r#"(version: 1, title: "from a state", materials: {{ {materials} }},
            specimen: State(path: "state_kept_at_200_kPa.npz"{state}), {fields})"#
    );
    let path = directory.join("from.ron");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

const SAND: &str =
    "contact: (normal_stiffness: 60.0e6, tangential_stiffness: 30.0e6, friction: 0.3)";

#[test]
fn another_scene_has_its_own_materials_walls_and_stages() {
    let (done, first) = run("biaxial_small", &SHORT);
    done.code(0);
    let kept = tables(&first.path().join("state_kept_at_200_kPa.npz"));
    // Half the density, twice the thickness; and the material has another name.
    let materials = format!("\"light sand\": (density: 1325.0, {SAND})");
    let stages = r#"stages: [Load(name: "hold", increments: 1)], thickness: 2.0"#;
    let scene =
        from_state(first.path(), &materials, stages, r#", materials: {"sand": "light sand"}"#);
    let (done, out) = run(&scene, &["--quiet"]);
    done.code(0);
    let held = tables(&out.path().join("final_state.npz"));
    let n = kept.rows("particles.id").unwrap();
    assert_eq!(held.values::<String>("materials.name", &[1]).unwrap(), ["light sand"]);
    let column = |of: &Tables, name: &str| of.values::<f64>(name, &[n]).unwrap().to_vec();
    let radii = column(&held, "particles.radius_m");
    assert_eq!(radii, column(&kept, "particles.radius_m"));
    for (mass, r) in column(&held, "particles.mass_kg").iter().zip(radii) {
        let expected = 1325.0 * std::f64::consts::PI * r * r * 2.0;
        assert!((mass - expected).abs() < 1e-14 * expected);
    }
    // Walls, bonds and loads are those of the state: the walls still carry 200 kPa, times the
    // distance of the others and the thickness.
    let row = &rows(out.path(), "history.csv")[0];
    assert_eq!((row["increment"].as_str(), row["status"].as_str()), ("4", "solved"));
    let wall = |of: &Tables, name: &str| {
        let w = of.rows("walls.name").unwrap();
        let names = of.values::<String>("walls.name", &[w]).unwrap();
        (w, names.iter().position(|n| n == name).unwrap())
    };
    let load = |of: &Tables, name: &str| {
        let (w, k) = wall(of, name);
        let force = of.vectors::<3>("walls.external_force", w).unwrap()[k];
        force[0].hypot(force[1])
    };
    let place = |of: &Tables, name: &str| {
        let (w, k) = wall(of, name);
        of.vectors::<2>("walls.middle_m", w).unwrap()[k][0]
    };
    let width = place(&kept, "right") - place(&kept, "left");
    let expected = 200.0e3 * width * 2.0;
    assert!((load(&held, "top") - expected).abs() < 1e-6 * expected);
    let states = |of: &Tables| {
        of.values::<u8>("bonds.state", &[of.rows("bonds.id").unwrap()]).unwrap().to_vec()
    };
    assert_eq!(states(&held).len(), states(&kept).len());

    // Walls of its own: none of the state, no force on them yet.
    let walls = r#"walls: [(name: "floor", start: (-1.0, -0.5), end: (1.0, -0.5), probe: "floor")],
        stages: [Load(name: "hold", increments: 1, particles: [(select: All, x: Held, y: Held, rotation: Held)])]"#;
    let scene = from_state(first.path(), &format!("\"sand\": ({SAND})"), walls, "");
    let (done, out) = run(&scene, &["--quiet"]);
    done.code(0);
    let held = tables(&out.path().join("final_state.npz"));
    assert_eq!(held.values::<String>("walls.name", &[1]).unwrap(), ["floor"]);
    assert_eq!(
        held.values::<f64>("particles.position_m", &[n, 2]).unwrap(),
        kept.values::<f64>("particles.position_m", &[n, 2]).unwrap()
    );
    assert_eq!(rows(out.path(), "history.csv")[0]["floor.force_y_n"], "0.0");
}

#[test]
fn a_state_that_is_cut_short_or_damaged_is_refused_with_its_name() {
    let (done, first) = run("biaxial_small", &SHORT);
    done.code(0);
    let stages = "stages: [Load(name: \"hold\", increments: 1)]";
    let scene = from_state(first.path(), &format!("\"sand\": ({SAND})"), stages, "");
    clastic(&["check", &scene]).code(0);
    let state = first.path().join("state_kept_at_200_kPa.npz");
    let whole = fs::read(&state).unwrap();
    for length in [0, 10, whole.len() / 2, whole.len() - 1] {
        fs::write(&state, &whole[..length]).unwrap();
        let said = stderr(&clastic(&["check", &scene]).code(3));
        assert!(said.contains("state_kept_at_200_kPa.npz`: not a .npz archive"), "{said}");
        assert!(said.contains("from.ron:2:"), "{said}");
    }
    // A changed byte is refused, unless it lies in a part that is not read.
    let read = |bytes: &[u8]| SavedState::read(&Tables::decode(bytes)?);
    let sound = read(&whole).unwrap();
    let mut refused = 0;
    for k in 0..97 {
        let mut damaged = whole.clone();
        damaged[k * whole.len() / 97] ^= 0x40;
        match read(&damaged) {
            Ok(same) => assert!(same == sound, "byte {}", k * whole.len() / 97),
            Err(_) => {
                refused += 1;
                fs::write(&state, damaged).unwrap();
            }
        }
    }
    assert!(refused > 60, "{refused}");
    let said = stderr(&clastic(&["check", &scene]).code(3));
    assert!(said.contains("specimen.path: cannot read"), "{said}");
}

#[test]
fn a_run_that_has_ended_is_extended_on_the_command_line() {
    let few =
        ["--quiet", "--set", "stages.confine.increments=2", "--set", "stages.load.increments=3"];
    let (done, out) = run("biaxial_small", &few);
    done.code(0);
    let made = rows(out.path(), "history.csv").len();
    let more = [&few[..4], &["stages.load.increments=5"]].concat();
    let (done, whole) = run("biaxial_small", &more);
    done.code(0);
    let all = rows(whole.path(), "history.csv").len();
    let directory = out.path().to_str().unwrap();
    let set = ["resume", directory, "--quiet", "--set", "stages.load.increments=5"];
    clastic(&set).code(0);
    for name in ["history.csv", "events.csv", "scene.ron", "final_particles.csv"] {
        assert_eq!(read(out.path(), name), read(whole.path(), name), "{name}");
    }
    let states = [&out, &whole].map(|run| fs::read(run.path().join("final_state.npz")).unwrap());
    assert!(states[0] == states[1]);
    let record = json(out.path(), "run.json");
    assert_eq!(record["resumed"][0]["after_increment"], made);
    assert_eq!(record["increments"], all);
    // Once more, by a scene with one more stage, which is edited outside of the directory.
    let edited = out.path().join("../longer.ron");
    let stage = "    Load(name: \"hold\", increments: 2),\n    ],\n    reference_stage: \"load\", measures: [";
    let text = read(out.path(), "scene.ron").replacen("    ],\n    measures: [", stage, 1);
    fs::write(&edited, text).unwrap();
    clastic(&["resume", directory, "--quiet", "--scene", edited.to_str().unwrap()]).code(0);
    fs::remove_file(&edited).unwrap();
    let history = rows(out.path(), "history.csv");
    assert_eq!(history.len(), all + 2);
    assert_eq!(history[all + 1]["stage"], "hold");
    // The run is at its end, and the message says how it can be extended.
    let done = clastic(&["resume", directory]).code(0);
    assert!(stdout(&done).contains("nothing to resume"), "{}", stdout(&done));
    let refused = clastic(&["resume", directory, "--set", "stages.load.increments=9"]).code(2);
    assert!(stderr(&refused).contains("`stages.load` cannot change: it has ended"));
}

#[test]
fn the_state_of_the_end_is_told_apart_from_what_is_not_written() {
    let (path, _directory) = edited("tension.ron", "stages: [", "stages: [Save(name: \"first\"), ");
    let (done, out) = run(path.to_str().unwrap(), &["--quiet"]);
    done.code(0);
    let first = tables(&out.path().join("state_first.npz"));
    assert_eq!(first.values::<u64>("increment", &[]).unwrap(), [0]);
    assert_eq!(first.values::<String>("stage", &[]).unwrap(), ["first"]);
    let last = tables(&out.path().join("final_state.npz"));
    let made = rows(out.path(), "history.csv").len() as u64;
    assert_eq!(last.values::<u64>("increment", &[]).unwrap(), [made]);
}

/// The script of `docs/outputs.md`, as it stands there.
#[test]
fn the_script_of_the_docs_reads_state_and_history_with_numpy_alone() {
    let numpy = Command::new("python3").args(["-c", "import numpy"]).output();
    if !numpy.is_ok_and(|done| done.status.success()) {
        eprintln!("SKIPPED: python3 with numpy is not there");
        return;
    }
    let page = fs::read_to_string(Path::new(ROOT).join("docs/outputs.md")).unwrap();
    let script = page.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    let (done, out) = run("biaxial_small", &SHORT);
    done.code(0);
    let mut python = Command::new("python3");
    let done = python.current_dir(out.path()).args(["-c", script]).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    let lines: Vec<_> = said.lines().collect();
    // What it prints is what the engine has: three lines a state, then one of the tables.
    let history = rows(out.path(), "history.csv");
    let last = history.last().unwrap();
    let mut particles = 0;
    for (of_state, name) in lines.chunks(3).zip(["final_state", "state_kept_at_200_kPa"]) {
        let state = tables(&out.path().join(format!("{name}.npz")));
        let n = state.rows("particles.id").unwrap();
        let weight =
            9.81 * state.values::<f64>("particles.mass_kg", &[n]).unwrap().iter().sum::<f64>();
        let bonds = &last["bonds"];
        let first = format!("{name}: {n} disks of {weight:.1} N, {bonds} of {bonds} bonds hold");
        assert_eq!(of_state[0], first);
        let c = state.rows("contacts.p_n").unwrap();
        let b = state.values::<u32>("contacts.b", &[c]).unwrap();
        let normals = state.vectors::<2>("contacts.normal", c).unwrap();
        let inner: Vec<_> =
            normals.iter().zip(b).filter(|(_, b)| (**b as usize) < n).map(|(x, _)| x).collect();
        let expected = inner.iter().map(|n| n[0] * n[0]).sum::<f64>() / inner.len() as f64;
        let fabric: Vec<f64> =
            of_state[1].split(' ').skip(2).take(4).map(|word| word.parse().unwrap()).collect();
        assert!((fabric[0] - expected).abs() < 1e-4 && (fabric[0] + fabric[3] - 1.0).abs() < 1e-3);
        let forces = state.values::<f64>("contacts.p_n", &[c]).unwrap();
        let largest = forces.iter().fold(0.0_f64, |a, b| a.max(*b));
        let (said, increment) = of_state[2].split_once(" N, after increment ").unwrap();
        let said: f64 = said.rsplit(' ').next().unwrap().parse().unwrap();
        assert!((said - largest).abs() < 1e-5 * largest, "{}", of_state[2]);
        assert_eq!(increment, "3");
        particles = n;
    }
    let contacts = &last["contacts"];
    assert_eq!(
        lines[6..],
        [format!("{contacts} contacts, 0 bonds broke; {particles} particles at the end")]
    );
}

/// The fields of a biaxial test that begins with the load.
const TEST: &str = r#"stages: [Load(name: "load", increments: 12, walls: {
        "bottom": Displacement(0.0, 0.08e-3), "top": Displacement(0.0, -0.08e-3) })],
    rupture: (rolling: Yields, order: OneRound), measures: [
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "lateral_strain", of: Strain(Walls("left", "right"))),
        (name: "axial_stress", of: Stress(Walls(walls: ["bottom", "top"], length: Between("left", "right")))),
        (name: "lateral_stress", of: Stress(Walls(walls: ["left", "right"], length: Between("bottom", "top"))))]"#;

/// Key results of a run whose first stage is the reference stage were null, because the stress of the
/// state was not known.
#[test]
fn key_results_count_from_the_stress_of_the_state() {
    let (done, first) = run("biaxial_small", &SHORT);
    done.code(0);
    let kept = tables(&first.path().join("state_kept_at_200_kPa.npz"));
    let sand = SAND.replace("friction: 0.3", "friction: 0.3, rolling_friction: 0.05");
    let sand = format!("\"sand\": ({sand})");
    let scene = from_state(first.path(), &sand, TEST, "");
    let (done, out) = run(&scene, &["--quiet"]);
    done.code(0);
    let results = &json(out.path(), "run.json")["results"];
    let history = rows(out.path(), "history.csv");
    let value = |row: usize, name: &str| history[row][name].parse::<f64>().unwrap();

    // By hand: force of bottom and top over the distance of the sides where the last increment began.
    let w = kept.rows("walls.name").unwrap();
    let names = kept.values::<String>("walls.name", &[w]).unwrap();
    let wall = |name: &str| names.iter().position(|n| n == name).unwrap();
    let forces = kept.vectors::<3>("walls.external_force", w).unwrap();
    let places = kept.vectors::<2>("walls.middle_m", w).unwrap();
    let motions = kept.vectors::<3>("walls.last_motion", w).unwrap();
    let x = |name: &str| places[wall(name)][0] - motions[wall(name)][0];
    let width = x("right") - x("left");
    let start = 0.5 * (forces[wall("bottom")][1] - forces[wall("top")][1]) / width;
    assert!((start - 200.0e3).abs() < 0.1, "{start}");
    let modulus = (value(0, "axial_stress_pa") - start) / value(0, "axial_strain");
    let found = results["youngs_modulus_pa"].as_f64().unwrap();
    assert!((found - modulus).abs() < 1e-9 * modulus, "{found} {modulus}");

    // They are those of the test in one piece.
    let stages = SHORT[1].replace(
        r#"Save(name: "kept at 200 kPa")"#,
        TEST.split_once('[').unwrap().1.split_once("],").unwrap().0,
    );
    let (done, out) = run("biaxial_small", &["--quiet", "--set", &stages]);
    done.code(0);
    let whole = &json(out.path(), "run.json")["results"];
    for name in ["youngs_modulus_pa", "poissons_ratio", "peak_stress_pa", "strain_at_peak"] {
        let [found, expected] = [results, whole].map(|of| of[name].as_f64().unwrap());
        assert!((found - expected).abs() < 1e-8 * expected.abs(), "{name}: {found} {expected}");
    }
    assert_eq!(results["bonds_created"], whole["bonds_created"]);

    // Other walls carry nothing yet.
    let walls = r#"walls: [
        (name: "bottom", start: (0.0, -1.0e-4), end: (0.2, -1.0e-4)),
        (name: "top", start: (0.2, 0.3), end: (0.0, 0.3)),
        (name: "left", start: (-1.0e-2, 0.3), end: (-1.0e-2, 0.0)),
        (name: "right", start: (0.2, 0.0), end: (0.2, 0.3))], "#;
    let held = r#"increments: 2,
        particles: [(select: All, x: Held, y: Held, rotation: Held)]"#;
    let fields = TEST.replace("increments: 12", held);
    let scene = from_state(first.path(), &sand, &(walls.to_owned() + &fields), "");
    let (done, out) = run(&scene, &["--quiet"]);
    done.code(0);
    let results = &json(out.path(), "run.json")["results"];
    assert!(results["youngs_modulus_pa"].is_null());
    let reason = results["not_defined"]["youngs_modulus_pa"].as_str().unwrap();
    assert!(reason.contains("other walls than its own"), "{reason}");
}

/// `check` of a scene from a state took the law of the material for bonds, and no stress that the
/// walls of the state keep.
#[test]
fn estimates_of_check_know_the_bonds_and_the_stress_of_the_state() {
    for cemented in [true, false] {
        let stages = if cemented {
            SHORT[1].to_owned()
        } else {
            SHORT[1].replace(r#"Cement(name: "cement", length: 2.0e-3),"#, "")
        };
        let law = "materials.sand.bond.cohesion=1.0e6";
        let (done, first) = run("biaxial_small", &["--quiet", "--set", law, "--set", &stages]);
        done.code(0);
        // The law of the material here bonds nothing.
        let sand = format!(
            "\"sand\": ({SAND}, bond: (normal_stiffness: 60.0e6, friction: 0.5, cohesion: 9.0e6, tensile_strength: 1.0e6))"
        );
        let scene = from_state(first.path(), &sand, TEST, "");
        let said = stdout(&clastic(&["check", &scene]).code(0));
        // 60e6 / (200e3 x 1 m).
        assert!(said.contains("k/(p h) 300"), "{said}");
        let state = tables(&first.path().join("state_kept_at_200_kPa.npz"));
        let w = state.rows("walls.name").unwrap();
        let names = state.values::<String>("walls.name", &[w]).unwrap();
        let places = state.vectors::<2>("walls.middle_m", w).unwrap();
        let y = |name: &str| places[names.iter().position(|n| n == name).unwrap()][1];
        // The strain of an increment over that at which 200 kPa, or the bonds, are reached.
        let strain = 0.16e-3 / (y("top") - y("bottom"));
        let expected = strain * 60.0e6 / if cemented { 1.0e6 } else { 200.0e3 };
        let ratio = said.split("increment/elastic strain ").nth(1).unwrap();
        let ratio: f64 = ratio.split([';', '\n']).next().unwrap().trim().parse().unwrap();
        assert!((ratio - expected).abs() < 0.01 * expected, "{ratio} {expected}: {said}");
        assert_eq!(said.contains("WARNING: k/(p h)"), !cemented, "{said}");
    }
}
