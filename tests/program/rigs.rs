//! What the program says of a rig: walls that never touch, forces of rigid groups, heights of
//! compactions, porosity of cells.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::path::PathBuf;

use clastic::frames::Frame;
use tempfile::TempDir;

use crate::call::{clastic, edited, json, rows, run, stderr, stdout};

/// A scene in a directory of its own.
fn scene(text: &str) -> (PathBuf, TempDir) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("rig.ron");
    fs::write(&path, text).unwrap();
    (path, directory)
}

/// A disk on a floor, and a press of 20 mm 1 mm above it: a contact is a spring of 1e7 N/m.
fn press(more: &str, stages: &str) -> String {
    format!(
        r#"(version: 1, title: "press", {more}
        materials: {{ "m": (contact: (normal_stiffness: 2.0e7)) }},
        specimen: Particles([(position: (0.0, 0.01), radius: 0.01)]),
        walls: [
            (name: "floor", start: (-0.1, 0.0), end: (0.1, 0.0), contact: (normal_stiffness: 1.0e7)),
            (name: "press", shape: Segment, start: (0.01, 0.021), end: (-0.01, 0.021),
                contact: (normal_stiffness: 1.0e7)),
        ],
        stages: [{stages}], reference_stage: "down")"#
    )
}

const NEVER: &str =
    r#"Load(name: "down", increments: 9, walls: { "press": Displacement(0.0, -1.0e-4) })"#;
const MORE: &str =
    r#", Load(name: "on", increments: 9, walls: { "press": Displacement(0.0, -1.0e-4) })"#;

fn warnings(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.contains("is moved and")).collect()
}

#[test]
fn a_press_that_never_touches_is_said_by_check_and_run() {
    for law in ["", "friction_law: Coulomb(),"] {
        let (path, _keep) = scene(&press(law, NEVER));
        let path = path.to_str().unwrap();
        let checked = stdout(&clastic(&["check", path]).code(0));
        assert_eq!(warnings(&checked).len(), 1, "{checked}");
        assert!(
            checked.contains("WARNING: stage down: press is moved and does not reach"),
            "{checked}"
        );
        let (done, out) = run(path, &["--quiet"]);
        let said = stdout(&done.code(0));
        assert_eq!(warnings(&said).len(), 1, "{said}");
        assert!(said.contains("press is moved and carries no force in the whole stage"), "{said}");
        let sanity = &json(out.path(), "run.json")["sanity"]["warnings"];
        assert!(sanity[0].as_str().unwrap().starts_with("stage down: press is moved"), "{sanity}");
    }
}

/// The second stage presses the disk by 0.8 mm. Of the first one the run still says that it carries
/// no force.
#[test]
fn a_press_that_touches_in_a_later_stage_is_said_of_the_first_alone() {
    let (path, _keep) = scene(&press("", &format!("{NEVER}{MORE}")));
    let (done, out) = run(path.to_str().unwrap(), &["--quiet"]);
    let said = stdout(&done.code(0));
    assert_eq!(warnings(&said).len(), 1, "{said}");
    assert!(warnings(&said)[0].contains("stage down"), "{said}");

    // The run of the first stage alone, extended by the second, says the same.
    let (first, _keep) = scene(&press("", NEVER));
    let (done, extended) = run(first.to_str().unwrap(), &["--quiet"]);
    done.code(0);
    let [at, longer] = [extended.path(), path.as_path()].map(|path| path.to_str().unwrap());
    let resumed = clastic(&["resume", at, "--scene", longer, "--quiet"]).code(0);
    assert_eq!(warnings(&stdout(&resumed)), warnings(&said));
    let of =
        |directory: &std::path::Path| json(directory, "run.json")["sanity"]["warnings"].clone();
    assert_eq!(of(extended.path()), of(out.path()));
}

/// What a wall is meant to do: it moves away, turns against the disk, or reaches it. In dynamics a
/// disk may come to a wall, so that `check` says nothing.
#[test]
fn walls_that_touch_or_move_away_are_not_said() {
    for (more, stage) in [
        ("", NEVER.replace("-1.0e-4", "1.0e-4")),
        ("", NEVER.replace("-1.0e-4", "-1.2e-4")),
        ("", NEVER.replace("Displacement(0.0, -1.0e-4)", "Force(100.0)")),
        (
            "",
            NEVER.replace(
                "Displacement(0.0, -1.0e-4)",
                "Rotation(about: (0.5, 0.021), angle: 1.0e-3) }, particles: [(select: All, x: Held)], rigid: {",
            ),
        ),
        ("analysis: Dynamic(dt: 1.0e-3), gravity: (0.0, 9.81),", NEVER.replace("9", "40")),
    ] {
        let (path, _keep) = scene(&press(more, &stage));
        let path = path.to_str().unwrap();
        let checked = stdout(&clastic(&["check", path]).code(0));
        let (done, _out) = run(path, &["--quiet"]);
        let said = stdout(&done.code(0));
        assert_eq!((warnings(&checked), warnings(&said)), (vec![], vec![]), "{more}{stage}");
    }
}

/// A rigid group presses the disk by 0.5 mm: 2 springs of 1e7 N/m in a row make 2500 N. The history
/// has the force of the disk on the group, and the peak is the force that pushes the group.
#[test]
fn the_peak_force_of_a_rigid_group_resists_its_motion() {
    let stage = r#"Load(name: "down", increments: 15, rigid: { "punch": (walls: ["press"],
        about: (0.0, 0.021), x: Held, y: Displacement(-1.0e-4), rotation: Held) })"#;
    let (path, _keep) = scene(&press("", stage));
    let (done, out) = run(path.to_str().unwrap(), &["--quiet"]);
    let said = stdout(&done.code(0));
    assert!(
        said.contains("peak force 2.5000e3 N at a displacement of 1.5000e-3 m (punch, -y)"),
        "{said}"
    );
    let record = json(out.path(), "run.json");
    assert_eq!(record["settings"]["rigid_groups"][0], "punch");
    let peak = record["peak_force"]["force_n"].as_f64().unwrap();
    assert!((peak - 2500.0).abs() < 1e-3, "{peak}");
    let last = rows(out.path(), "history.csv").pop().unwrap();
    let force: f64 = last["punch.force_y_n"].parse().unwrap();
    assert!((force - 2500.0).abs() < 1e-3, "{force}");
}

#[test]
fn a_rigid_group_that_never_touches_is_said() {
    let stage = r#"Load(name: "down", increments: 5, rigid: { "punch": (walls: ["press"],
        about: (0.0, 0.021), x: Held, y: Displacement(-1.0e-4), rotation: Held) })"#;
    let (path, _keep) = scene(&press("", stage));
    let (done, _out) = run(path.to_str().unwrap(), &["--quiet"]);
    let said = stdout(&done.code(0));
    assert!(
        warnings(&said)[0].contains("stage down: punch is moved and carries no force"),
        "{said}"
    );
}

/// The compaction of 200 disks ends where `check` says.
#[test]
fn check_says_how_high_a_compaction_ends() {
    let sets = [
        "stages=[Compact(name: \"compact\", wall: \"lid\", base: \"bottom\", target: Porosity(0.25), \
         step: 2.0e-3, agitation: 0.1, seed: 1)]",
        "reference_stage=\"compact\"",
    ];
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<&str> = ["check", "oedometer"].into_iter().chain(sets.clone()).collect();
    let said = stdout(&clastic(&arguments).code(0));
    let line = said.lines().find(|line| line.contains("ends with lid")).unwrap_or_default();
    let height: f64 = line.split(' ').find_map(|word| word.parse().ok()).unwrap();
    let (done, out) = run("oedometer", &sets.chain(["--quiet"]).collect::<Vec<_>>());
    done.code(0);
    let disks = rows(out.path(), "final_particles.csv");
    let of = |disk: &BTreeMap<String, String>, name: &str| disk[name].parse::<f64>().unwrap();
    let area: f64 = disks.iter().map(|disk| PI * of(disk, "radius_m").powi(2)).sum();
    let tops = disks.iter().map(|disk| of(disk, "y_m") + of(disk, "radius_m"));
    let highest = tops.fold(0.0, f64::max);
    assert!((area / (0.75 * 0.204) / height - 1.0).abs() < 1e-4, "{line}");
    assert!(highest <= 1.0001 * height && highest > 0.95 * height, "{highest} {line}");
}

/// Without strains of the cell the porosity was that of the box around the disks.
#[test]
fn the_porosity_of_a_periodic_cell_is_that_of_the_cell() {
    let sets = ["measures=[(name: \"porosity\", of: Porosity(Cell))]", "stages.shear.increments=1"];
    for reference in ["reference_stage=\"shear\"", "reference_stage=\"confine\""] {
        let arguments: Vec<&str> = sets
            .iter()
            .chain([&reference])
            .flat_map(|set| ["--set", set])
            .chain(["--quiet"])
            .collect();
        let (done, out) = run("simple_shear_periodic", &arguments);
        done.code(0);
        let stage = if reference.contains("shear") { "confine" } else { "compact" };
        let before = rows(out.path(), "history.csv").into_iter().rfind(|row| row["stage"] == stage);
        let expected: f64 = before.unwrap()["porosity"].parse().unwrap();
        let found = json(out.path(), "run.json")["results"]["porosity"].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-12, "{reference}: {found} {expected}");
    }
}

/// Pairs of a text of `uniaxial_small` and another, and what is said of it.
const MISTAKES: [(&str, &str, &str); 4] = [
    ("friction: 0.8,", "friction: 45,", "bond.friction is 45.0, which looks like degrees"),
    ("195.0e6,", "195.0,", "materials.rock.bond: at its strength a bond stretches by"),
    (
        "0.06e-3)",
        "0.06e-3, bond: (friction: 30, cohesion: 1e6, tensile_strength: 1e6))",
        "stages.cement.bond.friction is 30.0",
    ),
    ("friction: 0.8,", "friction: 0.8,", ""),
];

#[test]
fn likely_mistakes_are_said_by_check_and_at_the_start_of_a_run() {
    for (from, to, said) in MISTAKES {
        let (path, _keep) = edited("uniaxial_small.ron", from, to);
        let text = fs::read_to_string(&path).unwrap();
        let weak = if said.contains("stretches") { "144.0" } else { "144.0e6" };
        fs::write(&path, text.replace("144.0e6", weak).replace("increments: 120", "increments: 1"))
            .unwrap();
        let path = path.to_str().unwrap();
        let checked = stdout(&clastic(&["check", path]).code(0));
        let is_said = ["degrees", "stretches"].iter().any(|what| checked.contains(what));
        assert_eq!(is_said, !said.is_empty(), "{checked}");
        assert!(checked.contains(said), "{checked}");
        let (done, _out) = run(path, &["--quiet"]);
        assert!(stderr(&done).contains(said), "{}", stderr(&done));
    }
    // Lengths in mm, a stress in kPa, disks in each other, and sides under no load.
    let text = |radius: f64, stress: &str, apart: f64| {
        format!(
            r#"(version: 1, title: "t", materials: {{"m": (contact: (normal_stiffness: 1e9))}},
            specimen: Particles([(position: (0.0, {radius:?}), radius: {radius:?}),
                (position: (0.0, {:?}), radius: {radius:?})]),
            walls: [
                (name: "bottom", start: ({:?}, 0.0), end: ({radius:?}, 0.0)),
                (name: "top", start: ({radius:?}, {:?}), end: ({:?}, {:?})),
                (name: "left", start: ({:?}, {radius:?}), end: ({:?}, 0.0)),
                (name: "right", start: ({radius:?}, 0.0), end: ({radius:?}, {radius:?})),
            ],
            stages: [Load(name: "load", increments: 1, walls: {{
                "left": Stress(stress: {stress}), "right": Stress(stress: {stress}) }})],
            measures: [(name: "axial_strain", of: Strain(Walls("bottom", "top"))),
                (name: "lateral_strain", of: Strain(Walls("left", "right"))),
                (name: "axial_stress", of: Stress(Walls(walls: ["top"], length: Fixed(1.0))))])"#,
            radius + apart * radius,
            -radius,
            2.0 * radius + apart * radius,
            -radius,
            2.0 * radius + apart * radius,
            -radius,
            -radius,
        )
    };
    for (text, said) in [
        (text(0.01, "1e5", 1.9), "particle 0 and particle 1 overlap by 10 % of a radius"),
        (text(5.0, "1e5", 2.0), "the grains of the test are 10.00 m in diameter"),
        (text(0.01, "50.0", 2.0), "a stress of 50.0 Pa is small beside the grains"),
        (text(0.01, "0.0", 2.0), "measured from wall left, which carries no load"),
    ] {
        let (path, _keep) = scene(&text);
        let checked = stdout(&clastic(&["check", path.to_str().unwrap()]).code(0));
        assert!(checked.contains(said), "no `{said}` in {checked}");
    }
}

/// The press stops in front of the disk or moves away from it, and neither condition holds.
#[test]
fn a_stop_that_never_held_and_a_platen_that_moves_away_are_said_at_the_end() {
    let measures = r#"], measures: [(name: "axial_strain", of: Strain(Walls("floor", "press")))], reference_stage"#;
    for step in ["-1.0e-5", "1.0e-5"] {
        let stages = format!(
            r#"Load(name: "down", increments: 3, walls: {{ "press": Displacement(0.0, {step}) }},
                stop: [Above("axial_strain", 0.5)])"#
        );
        let (path, _keep) = scene(&press("", &stages).replace("], reference_stage", measures));
        let (done, out) = run(path.to_str().unwrap(), &["--quiet"]);
        let said = stdout(&done.code(0));
        assert!(said.contains("did not reach Above(\"axial_strain\", 0.5)"), "{said}");
        assert!(
            said.contains("press is moved and carries no force") && said.contains("the other way")
        );
        assert!(json(out.path(), "run.json")["stages"][0]["stop"]["Above"].is_array());
    }
}

/// A rigid disk between two rigid fingers that is pushed down collapses: nothing of it is kept.
#[test]
fn the_state_of_a_collapsed_stage_is_not_saved() {
    let (path, _keep) = scene(
        r#"(version: 1, title: "t", materials: {"m": ()},
        specimen: Particles([(position: (0.0, 0.01), radius: 0.01)]),
        walls: [(name: "floor", start: (-0.1, 0.0), end: (0.1, 0.0))],
        stages: [
            Load(name: "push", increments: 1, particles: [(select: All, force: (1.0, -1.0))]),
            Save(name: "after"),
        ])"#,
    );
    let (done, out) = run(path.to_str().unwrap(), &["--quiet"]);
    let said = stderr(&done.code(3));
    assert!(said.contains("the specimen collapsed in stage push"), "{said}");
    assert!(!out.path().join("state_after.npz").exists());
    assert!(out.path().join("final_state.npz").exists());
}

/// Particles that were taken away and bonds that were made without an increment.
#[test]
fn the_start_has_what_stages_without_increments_did() {
    let (path, _keep) = scene(
        r#"(version: 1, title: "t", gravity: (0.0, -9.81),
        materials: {"m": (contact: (normal_stiffness: 1.0e7), bond: (normal_stiffness: 1.0e7, cohesion: 1e6, tensile_strength: 1e6))},
        specimen: Particles([(position: (0.005, 0.005), radius: 0.005), (position: (0.015, 0.005), radius: 0.005),
            (position: (0.025, 0.005), radius: 0.005)]),
        walls: [(name: "floor", start: (-0.1, 0.0), end: (0.1, 0.0), contact: (normal_stiffness: 1.0e7))],
        stages: [
            Cement(name: "cement", length: 0.1e-3),
            Remove(name: "dig", select: Index([2])),
            Load(name: "load", increments: 2),
        ])"#,
    );
    let (done, out) = run(path.to_str().unwrap(), &["--quiet"]);
    done.code(0);
    let start = Frame::read(&out.path().join("frames/start.npz")).unwrap();
    assert_eq!((start.bodies.id.as_slice(), start.increment), (&[0, 1][..], 0));
    assert_eq!(start.pairs.state, [1]);
    assert_eq!(rows(out.path(), "specimen.csv").len(), 2);
}
