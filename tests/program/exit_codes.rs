//! Exit codes of failures, and the files of a run that fails.

use std::fs;

use assert_cmd::Command;

use crate::call::{PROGRAM, assert_complete, clastic, edited, json, rows, run, stderr};

#[test]
fn exit_1_files() {
    let missing = stderr(&clastic(&["run", "no_such_place/no_such_scene.ron"]).code(1));
    assert!(missing.contains("no_such_place/no_such_scene.ron"), "{missing}");
    let misspelt = stderr(&clastic(&["check", "tenison"]).code(1));
    assert!(misspelt.contains("did you mean `tension`?"), "{misspelt}");

    // A directory is no scene.
    let folder = tempfile::tempdir().unwrap();
    let said = stderr(&clastic(&["check", folder.path().to_str().unwrap()]).code(1));
    assert!(said.contains("no scene"), "{said}");

    // A file in place of a directory of scenes.
    let empty = tempfile::tempdir().unwrap();
    fs::write(empty.path().join("scenes"), "").unwrap();
    let list = Command::new(PROGRAM).current_dir(empty.path()).arg("list").assert().code(1);
    assert!(stderr(&list).contains("./scenes"), "{}", stderr(&list));

    // A file where a directory should be.
    let file = empty.path().join("file");
    fs::write(&file, "").unwrap();
    let out = file.join("out");
    let blocked = clastic(&["run", "tension", "--out", out.to_str().unwrap()]).code(1);
    assert!(stderr(&blocked).contains("file"), "{}", stderr(&blocked));
}

#[test]
fn exit_2_usage() {
    clastic(&["fly"]).code(2);
    clastic(&["run"]).code(2);
    clastic(&["run", "tension", "--threads", "0"]).code(2);
    let nowhere =
        stderr(&clastic(&["check", "tension", "--set", "stages.push.increments=1"]).code(2));
    assert!(nowhere.contains("stages.push.increments") && nowhere.contains("pull"), "{nowhere}");
    let no_value = stderr(&clastic(&["check", "tension", "--set", "thickness"]).code(2));
    assert!(no_value.contains("thickness"), "{no_value}");
}

#[test]
fn a_setting_that_does_not_fit_is_a_wrong_scene_and_is_named() {
    let set = "materials.cemented.contact.friction=-0.5";
    let said = stderr(&clastic(&["check", "tension", "--set", set]).code(3));
    assert!(said.contains("friction") && said.contains(set), "{said}");
}

/// `clastic check` of a misspelt radius: names file, line, column, the field and what is right.
fn misspelt_radius(name: &str, field: &str) {
    let wrong = field.replace("radius", "raduis");
    let (path, _directory) = edited(name, field, &wrong);
    let text = fs::read_to_string(&path).unwrap();
    let at = text.find("raduis").unwrap();
    let line = text[..at].lines().count();
    let column = at - text[..at].rfind('\n').unwrap();
    let path = path.to_str().unwrap();
    for command in ["check", "run"] {
        let said = stderr(&clastic(&[command, path]).code(3));
        let place = format!("{path}:{line}:{column}");
        for what in [place.as_str(), "raduis", "`radius`"] {
            assert!(said.contains(what), "no `{what}` in\n{said}");
        }
    }
}

#[test]
fn exit_3_misspelt_radius_of_a_particle() {
    misspelt_radius("tension.ron", "position: (12.0e-3, 0.0), radius: 6.0e-3");
}

#[test]
fn exit_3_misspelt_radius_of_a_size_distribution() {
    misspelt_radius("uniaxial_small.ron", "sizes: Uniform(radius: (0.3e-3, 0.6e-3))");
}

/// A rigid disk between rigid walls that close in on it: no motion is feasible.
const SQUEEZED: &str = r#"// A rigid disk in a rigid vice.
(
    version: 1,
    title: "vice",
    materials: { "steel": (contact: ()) },
    specimen: Particles([(position: (0.0, 5.0e-3), radius: 4.0e-3, probe: "disk")]),
    walls: [
        (name: "bottom", start: (-0.01, 0.0), end: (0.01, 0.0)),
        (name: "top", start: (0.01, 0.01), end: (-0.01, 0.01)),
    ],
    stages: [
        // Touches the disk after two increments.
        Load(name: "close", increments: 9, walls: { "top": Displacement(0.0, -1.0e-3) }),
    ],
)"#;

#[test]
fn exit_4_leaves_everything_up_to_there() {
    let directory = tempfile::tempdir().unwrap();
    let scene = directory.path().join("vice.ron");
    fs::write(&scene, SQUEEZED).unwrap();
    let (stalled, out) = run(scene.to_str().unwrap(), &[]);
    let said = stderr(&stalled.code(4));
    for what in ["increment 3", "`close`", "locked", "try:"] {
        assert!(said.contains(what), "no `{what}` in\n{said}");
    }
    assert_complete(out.path(), "undecided");
    let history = rows(out.path(), "history.csv");
    let statuses: Vec<_> = history.iter().map(|row| row["status"].as_str()).collect();
    assert_eq!(statuses, ["solved", "solved", "undecided"]);
    let record = json(out.path(), "run.json");
    assert!(said.contains(record["outcome"]["message"].as_str().unwrap()));
    // The failed increment is not committed.
    let last = rows(out.path(), "final_particles.csv");
    assert_eq!(last[0]["y_m"].parse(), Ok(0.004));
}

#[test]
fn exit_3_a_wall_that_is_left_to_a_program_of_its_own() {
    let directory = tempfile::tempdir().unwrap();
    let scene = directory.path().join("vice.ron");
    fs::write(&scene, SQUEEZED.replace("Displacement(0.0, -1.0e-3)", "Custom")).unwrap();
    let path = scene.to_str().unwrap();
    let out = directory.path().join("out");
    for arguments in [vec!["check", path], vec!["run", path, "--out", out.to_str().unwrap()]] {
        let said = stderr(&clastic(&arguments).code(3));
        let place = format!("{path}:13:60: stages[0].walls.top: `Custom`");
        for what in [place.as_str(), "embedding program", "`Displacement`"] {
            assert!(said.contains(what), "no `{what}` in\n{said}");
        }
    }
    assert!(!out.exists());
    // A program of one's own takes the same scene.
    clastic::scene::load(&scene, &[]).unwrap_or_else(|e| panic!("{e}"));

    // A setting is named instead of a line.
    fs::write(&scene, SQUEEZED).unwrap();
    let set = "stages.close.walls.top=Custom";
    let said = stderr(&clastic(&["check", path, "--set", set]).code(3));
    assert!(said.starts_with(&format!("--set {set}: ")), "{said}");
    let (stalled, out) = run(path, &[]);
    stalled.code(4);
    let resumed = clastic(&["resume", out.path().to_str().unwrap(), "--set", set]).code(3);
    assert!(stderr(&resumed).contains("stages[0].walls.top: `Custom`"), "{}", stderr(&resumed));
}

/// A disk that the first stage moves out of the box of the second.
const MOVED: &str = r#"(
    version: 1,
    title: "moved out of a box",
    materials: { "steel": (contact: (normal_stiffness: 1.0e6)) },
    specimen: Particles([(position: (0.0, 0.0), radius: 1.0e-3)]),
    stages: [
        Load(name: "move", increments: 2, particles: [(select: All, x: Displacement(1.0e-3), y: Held)]),
        Load(name: "hold", increments: 1, particles: [
            (select: Box(min: (-1.0e-3, -1.0), max: (1.0e-3, 1.0)), x: Held),
        ]),
    ],
)"#;

#[test]
fn exit_3_a_stage_that_selects_nothing_leaves_everything_up_to_there() {
    let directory = tempfile::tempdir().unwrap();
    let scene = directory.path().join("moved.ron");
    fs::write(&scene, MOVED).unwrap();
    let (refused, out) = run(scene.to_str().unwrap(), &[]);
    let said = stderr(&refused.code(3));
    for what in ["stage `hold`", "particles[0].select", "no particle", "clastic resume"] {
        assert!(said.contains(what), "no `{what}` in\n{said}");
    }
    assert_complete(out.path(), "refused");
    let record = json(out.path(), "run.json");
    assert!(said.contains(record["outcome"]["message"].as_str().unwrap()));
    assert_eq!((&record["outcome"]["stage"], &record["increments"]), (&"hold".into(), &2.into()));

    let again = out.path().to_str().unwrap();
    clastic(&["resume", again]).code(3);
    let set = "stages.hold.particles[0].select.max=(3.0e-3, 1.0)";
    clastic(&["resume", again, "--set", set]).code(0);
    assert_complete(out.path(), "completed");
    assert_eq!(rows(out.path(), "history.csv").len(), 3);
}

/// Every remedy that the message on the vice proposes helps.
#[test]
fn rigid_bodies_that_lock_are_named_with_remedies_that_help() {
    let directory = tempfile::tempdir().unwrap();
    let scene = directory.path().join("vice.ron");
    fs::write(&scene, SQUEEZED).unwrap();
    let (stalled, _out) = run(scene.to_str().unwrap(), &[]);
    let said = stderr(&stalled.code(4));
    for what in ["particle 0 and wall `bottom` near (", "a stiffness", "gives way under a force"] {
        assert!(said.contains(what), "no `{what}` in\n{said}");
    }
    let contact = "contact: (normal_stiffness: 1.0e8)";
    let stiff = SQUEEZED
        .replace("end: (0.01, 0.0)", &format!("end: (0.01, 0.0), {contact}"))
        .replace("end: (-0.01, 0.01)", &format!("end: (-0.01, 0.01), {contact}"));
    let gives = SQUEEZED.replace("walls: { ", "walls: { \"bottom\": Force(10.0), ");
    for remedy in [stiff, gives] {
        assert_ne!(remedy, SQUEEZED);
        fs::write(&scene, remedy).unwrap();
        let (done, _out) = run(scene.to_str().unwrap(), &[]);
        done.code(0);
    }
}

#[test]
fn a_stall_for_want_of_digits_says_so() {
    let (stalled, _out) = run("lattice", &["--set", "acceptance.residual=1e-25"]);
    let said = stderr(&stalled.code(4));
    assert!(said.contains("try: a greater `acceptance.residual`"), "{said}");
}

#[test]
fn exit_3_a_stage_of_a_kind_that_no_plugin_provides() {
    let directory = tempfile::tempdir().unwrap();
    let scene = directory.path().join("tilt.ron");
    let stage =
        r#"stages: [Custom(name: "tilt", kind: "Tilt", increments: 2, values: { "angle": 0.1 }),"#;
    let text = SQUEEZED.replace("stages: [", stage);
    assert_ne!(text, SQUEEZED);
    fs::write(&scene, text).unwrap();
    let path = scene.to_str().unwrap();
    let out = directory.path().join("out");
    for arguments in [vec!["check", path], vec!["run", path, "--out", out.to_str().unwrap()]] {
        let said = stderr(&clastic(&arguments).code(3));
        assert!(said.contains("stages[0].kind: `Tilt` is a kind of stage"), "{said}");
    }
    assert!(!out.exists());
}
