//! The `clastic` program as its user meets it: commands, exit codes, what a run leaves behind.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Stdio};
use std::time::{Duration, Instant};

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use common::files;
use serde_json::Value;
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_clastic");
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// `clastic` with arguments, in the directory of the package, where `scenes/` is.
fn clastic(arguments: &[&str]) -> Assert {
    Command::new(PROGRAM).current_dir(ROOT).args(arguments).assert()
}

fn stdout(run: &Assert) -> String {
    String::from_utf8_lossy(&run.get_output().stdout).into_owned()
}

fn stderr(run: &Assert) -> String {
    String::from_utf8_lossy(&run.get_output().stderr).into_owned()
}

/// Runs a scene into a directory of its own.
fn run(scene: &str, settings: &[&str]) -> (Assert, TempDir) {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().to_str().unwrap();
    let mut arguments = vec!["run", scene, "--out", out];
    arguments.extend(settings);
    (clastic(&arguments), directory)
}

/// A scene of `scenes/` with one text in it replaced by another, as a file.
fn edited(name: &str, from: &str, to: &str) -> (PathBuf, TempDir) {
    let directory = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(Path::new(ROOT).join("scenes").join(name)).unwrap();
    assert!(text.contains(from), "{name} has no `{from}`");
    let path = directory.path().join(name);
    fs::write(&path, text.replacen(from, to, 1)).unwrap();
    (path, directory)
}

fn read(directory: &Path, name: &str) -> String {
    fs::read_to_string(directory.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn json(directory: &Path, name: &str) -> Value {
    serde_json::from_str(&read(directory, name)).unwrap()
}

/// Rows of a file, each by column; every one is whole.
fn rows(directory: &Path, name: &str) -> Vec<BTreeMap<String, String>> {
    let text = read(directory, name);
    assert!(text.ends_with('\n'), "{name} ends within a row");
    let mut lines = text.lines();
    let header: Vec<_> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let fields: Vec<_> = line.split(',').collect();
            assert_eq!(fields.len(), header.len(), "{name}: {line}");
            header.iter().zip(fields).map(|(h, f)| ((*h).to_owned(), f.to_owned())).collect()
        })
        .collect()
}

/// What every run leaves, however it ended.
fn assert_complete(directory: &Path, status: &str) {
    let record = json(directory, "run.json");
    assert_eq!(record["outcome"]["status"], status);
    assert_eq!(record["increments"], rows(directory, "history.csv").len());
    assert_eq!(rows(directory, "timings.csv").len(), rows(directory, "history.csv").len());
    for name in ["scene.ron", "events.csv", "final_particles.csv"] {
        assert!(!read(directory, name).is_empty(), "{name} is empty");
    }
}

#[test]
fn without_an_argument_it_says_what_to_type() {
    let help = stderr(&clastic(&[]).code(2));
    for what in ["Usage: clastic", "run", "check", "list", "clastic run uniaxial", "130"] {
        assert!(help.contains(what), "no `{what}` in\n{help}");
    }
}

#[test]
fn list_names_every_scene_with_its_title() {
    let listed = stdout(&clastic(&["list"]).code(0));
    for entry in fs::read_dir(Path::new(ROOT).join("scenes")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "ron") {
            let name = path.file_stem().unwrap().to_str().unwrap();
            assert!(listed.lines().any(|l| l.split(' ').next() == Some(name)), "no {name}");
        }
    }
    assert!(listed.contains("Tension test of one bond (4.1)"), "{listed}");
}

#[test]
fn check_says_what_a_sound_scene_is() {
    let said = stdout(&clastic(&["check", "tension"]).code(0));
    assert_eq!(said, "ok: Tension test of one bond (4.1), 2 particles, 0 walls, 1 stage\n");
}

#[test]
fn control_characters_of_a_scene_do_not_reach_the_terminal() {
    // Clears the screen, rings the bell, goes back to the begin of the line.
    let (path, directory) = edited("tension.ron", "(4.1)", "\\u{1b}[2J\\u{7}\\r\\nok: forged");
    let text = fs::read_to_string(&path).unwrap();
    let named = text.replace("name: \"pull\"", "name: \"pu\\u{1b}[31m\\nll\"");
    assert_ne!(named, text);
    fs::write(&path, named).unwrap();
    let scenes = directory.path().join("scenes");
    fs::create_dir(&scenes).unwrap();
    fs::copy(&path, scenes.join("tension.ron")).unwrap();
    let one = "stages[0].increments=1";
    // The name is quoted by a complaint as well, and the run fails with it.
    let stalls = ["run", "tension.ron", "--force", "--set", "acceptance.residual=1e-25"];
    let wrong = ["check", "tension.ron", "--set", "stages[0].walls={\"\u{1b}]0;x\": Fixed}"];
    let calls: [&[&str]; 5] = [
        &["check", "tension.ron"],
        &["list"],
        &["run", "tension.ron", "--set", one],
        &stalls,
        &wrong,
    ];
    for arguments in calls {
        let mut command = Command::new(PROGRAM);
        let done = command.current_dir(directory.path()).args(arguments).assert();
        let said = stdout(&done) + &stderr(&done);
        let raw = |c: char| c.is_control() && c != '\n';
        assert!(!said.contains(raw), "{arguments:?}: {said:?}");
        assert!(said.contains("\\u{1b}"), "{arguments:?}: {said:?}");
        assert!(!said.lines().any(|line| line.starts_with("ok: forged")), "{said}");
    }
}

#[test]
fn long_tokens_are_shortened_in_messages() {
    let long = "x".repeat(300_000);
    let name = format!("radius: 6.0e-3, {long}: 1, radius");
    let (path, _directory) = edited("tension.ron", "radius", &name);
    let said = stderr(&clastic(&["check", path.to_str().unwrap()]).code(3));
    assert!(said.len() < 2000, "{} bytes", said.len());
    assert!(said.contains("`xxxx") && said.contains("... (300000 characters)"), "{said}");
    let set = format!("stages.{}.increments=1", &long[..100_000]);
    let said = stderr(&clastic(&["check", "tension", "--set", &set]).code(2));
    assert!(said.len() < 2000 && said.contains("characters)"), "{said}");
}

#[test]
fn a_directory_does_not_hide_the_scene_of_its_name() {
    let here = tempfile::tempdir().unwrap();
    fs::create_dir_all(here.path().join("tension")).unwrap();
    fs::create_dir_all(here.path().join("scenes")).unwrap();
    let scene = Path::new(ROOT).join("scenes/tension.ron");
    fs::copy(scene, here.path().join("scenes/tension.ron")).unwrap();
    let check = |name: &str| {
        Command::new(PROGRAM).current_dir(here.path()).args(["check", name]).assert().code(0)
    };
    check("tension");
    check("tension.ron");
}

#[test]
fn shipped_scenes_are_found_anywhere() {
    let here = tempfile::tempdir().unwrap();
    let call = |arguments: &[&str]| {
        Command::new(PROGRAM).current_dir(here.path()).args(arguments).assert()
    };
    let listed = stdout(&call(&["list"]).code(0));
    assert_eq!(listed, stdout(&clastic(&["list"]).code(0)));
    // With the stored specimen that it names, and the same results as from its file.
    let one = ["run", "biaxial_small", "--quiet", "--set", "stages.load.increments=1"];
    call(&one).code(0);
    let (from_file, out) = run("scenes/biaxial_small.ron", &one[2..]);
    from_file.code(0);
    assert!(files(&here.path().join("runs/biaxial_small")) == files(out.path()));
    // A scene in ./scenes goes before the shipped one of its name.
    fs::create_dir(here.path().join("scenes")).unwrap();
    fs::write(here.path().join("scenes/tension.ron"), "(").unwrap();
    let own = stderr(&call(&["check", "tension"]).code(3));
    assert!(own.starts_with("scenes/tension.ron:1:"), "{own}");
    assert!(stdout(&call(&["list"]).code(0)).contains("(not sound; see `clastic check tension`)"));
    // Mistakes say that the scene is the shipped one; what is nowhere says where it was looked for.
    let set = ["check", "stack", "--set", "specimen=File(path: \"none.csv\")"];
    let missing = stderr(&call(&set).code(3));
    assert!(missing.contains("`<clastic>/scenes/none.csv`"), "{missing}");
    let nowhere = stderr(&call(&["run", "no_such_scene"]).code(1));
    for place in ["no such file here", "./scenes", "clastic ships none", "clastic list"] {
        assert!(nowhere.contains(place), "no `{place}` in {nowhere}");
    }
}

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

    // What stands where a directory of scenes should be.
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
fn an_existing_run_is_written_over_by_force_only() {
    let (first, directory) = run("tension", &[]);
    first.code(0);
    let before = read(directory.path(), "history.csv");
    let out = directory.path().to_str().unwrap();
    let half = ["run", "tension", "--out", out, "--set", "stages.pull.increments=12"];
    let refused = stderr(&clastic(&half).code(1));
    assert!(refused.contains(out) && refused.contains("--force"), "{refused}");
    assert_eq!(read(directory.path(), "history.csv"), before);

    clastic(&[&half[..], &["--force"]].concat()).code(0);
    assert_eq!(rows(directory.path(), "history.csv").len(), 12);
    assert_eq!(json(directory.path(), "run.json")["overrides"][0], "stages.pull.increments=12");
    assert!(read(directory.path(), "scene.ron").contains("increments: 12,"));
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let pipe = directory.path().join("pipe.ron");
    assert!(Process::new("mkfifo").arg(&pipe).status().unwrap().success());
    let out = directory.path().join("out");
    // Nobody writes to the pipe: whoever opens it waits for ever.
    let refuse = |arguments: &[&str]| {
        let mut command = Command::new(PROGRAM);
        command.current_dir(ROOT).args(arguments).timeout(Duration::from_secs(60));
        stderr(&command.assert())
    };
    for command in ["check", "run"] {
        let said = refuse(&[command, pipe.to_str().unwrap()]);
        let expected = "pipe.ron: cannot read the scene: it is a named pipe, not a regular file";
        assert!(said.contains(expected), "{said}");
    }
    let specimen = format!("specimen.path={:?}", pipe.to_str().unwrap());
    let out = out.to_str().unwrap();
    let said = refuse(&["run", "biaxial_small", "--set", &specimen, "--out", out]);
    assert!(said.contains("pipe.ron`: it is a named pipe, not a regular file"), "{said}");
}

#[test]
fn a_specimen_of_only_a_header_is_an_input_error() {
    let directory = tempfile::tempdir().unwrap();
    let specimen = directory.path().join("header.csv");
    fs::write(&specimen, "x_m,y_m,radius_m\n").unwrap();
    let set = format!("specimen.path={:?}", specimen.to_str().unwrap());
    let (refused, out) = run("biaxial_small", &["--set", &set]);
    let said = stderr(&refused.code(3));
    assert!(said.contains("header.csv:2:1: no particles: only a header"), "{said}");
    assert_eq!(fs::read_dir(out.path()).unwrap().count(), 0);
}

#[test]
fn a_run_reads_the_final_particles_of_another_one() {
    let (first, out) = run("biaxial_small", &["--set", "stages.load.increments=1"]);
    first.code(0);
    let specimen = out.path().join("final_particles.csv");
    let set = format!("specimen.path={:?}", specimen.to_str().unwrap());
    let one = ["--set", "stages.load.increments=1", "--set", &set];
    let (second, again) = run("biaxial_small", &one);
    second.code(0);
    let expected = rows(out.path(), "final_particles.csv");
    let found = rows(again.path(), "specimen.csv");
    assert_eq!(found.len(), expected.len());
    assert_eq!(json(again.path(), "run.json")["specimen_sha256"].as_str().map(str::len), Some(64));
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
    // Nothing of the increment that failed is committed.
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

#[test]
fn a_stall_for_want_of_digits_says_so() {
    let (stalled, _out) = run("lattice", &["--set", "acceptance.residual=1e-25"]);
    let said = stderr(&stalled.code(4));
    assert!(said.contains("try: a greater `acceptance.residual`"), "{said}");
}

#[test]
fn a_collapse_is_a_result() {
    // Pulled by 1 N more in every increment; the bond carries 24 N.
    let (collapsed, out) = run(
        "tension",
        &[
            "--set",
            "stages.pull.particles[1].x=Free",
            "--set",
            "stages.pull.particles[1].force=(35.0, 0.0)",
        ],
    );
    let said = stdout(&collapsed.code(0));
    assert!(said.contains("collapsed in increment 25, in stage pull"), "{said}");
    assert_complete(out.path(), "collapsed");
    let record = json(out.path(), "run.json");
    assert_eq!(
        (&record["outcome"]["stage"], &record["outcome"]["increment"]),
        (&"pull".into(), &25.into())
    );
    let events = rows(out.path(), "events.csv");
    assert_eq!((events.len(), events[0]["mode"].as_str()), (1, "tension"));
    let p: f64 = events[0]["p_n"].parse().unwrap();
    assert!((p + 24.0).abs() < 1e-6, "{p} N");
    assert_eq!(rows(out.path(), "history.csv").last().unwrap()["status"], "collapsed");
}

#[test]
fn the_mechanism_of_a_collapse_is_a_result() {
    // When the bond breaks nothing holds the 10 N that pull the free disk along x.
    let (collapsed, out) = run("direct_shear_-10N", &[]);
    collapsed.code(0);
    let record = json(out.path(), "run.json");
    let mechanism = &record["results"]["mechanism"];
    assert_eq!(mechanism["increment"], record["outcome"]["increment"]);
    // Nothing dissipates, and no condition is violated.
    assert!((mechanism["margin"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{mechanism}");
    assert!(mechanism["defect"].as_f64().unwrap() < 1e-9, "{mechanism}");
    let text = read(out.path(), "mechanism.csv");
    assert!(text.starts_with("body,x_m,y_m,u_x,u_y,rotation\n"), "{text}");
    let rows = rows(out.path(), "mechanism.csv");
    let number = |row: usize, column: &str| rows[row][column].parse::<f64>().unwrap();
    assert_eq!(rows.len(), 2);
    for (row, u_x) in [(0, 0.0), (1, 1.0)] {
        let motion = ["u_x", "u_y", "rotation"].map(|column| number(row, column));
        assert_eq!(motion, [u_x, 0.0, 0.0]);
    }
    assert_eq!([number(0, "x_m"), number(0, "y_m"), number(1, "y_m")], [0.0; 3]);
    assert!((number(1, "x_m") - 12.0e-3).abs() < 1e-6);
    assert!(read(out.path(), "mechanism.svg").contains("increment"));

    // A run that does not collapse has none.
    let (completed, out) = run("direct_shear_10N", &[]);
    completed.code(0);
    assert!(!out.path().join("mechanism.csv").exists());
    assert!(json(out.path(), "run.json")["results"]["mechanism"].is_null());
}

#[test]
fn the_first_increment_of_the_rigid_test_shows_its_mechanism() {
    let (done, out) = run("uniaxial_rigid_small", &["--set", "output.plots=false"]);
    done.code(0);
    assert_eq!(fs::read_dir(out.path().join("frames")).unwrap().count(), 1);
    let rows = rows(out.path(), "frames/frame_000001.csv");
    assert_eq!(rows.len(), 400);
    let moves = |column: &str, sign: f64| {
        rows.iter().map(|row| sign * row[column].parse::<f64>().unwrap()).fold(0.0, f64::max)
    };
    // The platen comes down, and the specimen gives way to both sides.
    let platen = 1.451e-6;
    for (column, sign, least) in [("uy_m", -1.0, 0.9), ("ux_m", 1.0, 0.3), ("ux_m", -1.0, 0.3)] {
        let most = moves(column, sign);
        assert!(most > least * platen, "{column}: {most}");
    }
}

#[test]
fn headers_are_the_documented_ones() {
    let (done, out) = run("tension", &["--quiet", "--set", "stages.pull.increments=1"]);
    assert_eq!(stderr(&done.code(0)), "");
    let header = |name| read(out.path(), name).lines().next().unwrap().to_owned();
    let history = header("history.csv");
    let columns = "increment,stage,time_s,axial_strain,lateral_strain,volumetric_strain,\
        axial_stress_pa,lateral_stress_pa,contacts,bonds,broken_tension,broken_shear,\
        broken_rolling,solver_iterations,residual_balance,residual_kinematics,residual_cone,\
        residual_complementarity,status,";
    assert!(history.starts_with(columns), "{history}");
    let probes = "held.x_m,held.y_m,held.rotation_rad,held.force_x_n,held.force_y_n,held.moment_nm,\
        pulled.x_m,pulled.y_m,pulled.rotation_rad,pulled.force_x_n,pulled.force_y_n,pulled.moment_nm";
    assert!(history.ends_with(probes), "{history}");
    let events = "increment,stage,bond,a,b,mode,x_m,y_m,normal_x,normal_y,p_n,q_n,tau_nm";
    assert_eq!(header("events.csv"), events);
    let timings =
        "increment,detect_s,assemble_s,solve_s,update_s,rupture_s,walls_s,record_s,output_s";
    assert_eq!(header("timings.csv"), timings);
}

/// Starts a run that would take hours; returns once its history has some rows.
fn long_run(out: &Path) -> std::process::Child {
    let mut child = Process::new(PROGRAM)
        .current_dir(ROOT)
        .args(["run", "tension", "--set", "stages.pull.increments=100000000", "--out"])
        .arg(out)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while fs::read_to_string(out.join("history.csv")).map_or(0, |text| text.lines().count()) < 10 {
        assert_eq!(child.try_wait().unwrap(), None, "it ended by itself");
        assert!(begun.elapsed() < Duration::from_secs(60), "no rows after a minute");
        std::thread::sleep(Duration::from_millis(10));
    }
    child
}

#[cfg(unix)]
#[test]
fn exit_130_interrupted_with_whole_rows() {
    let out = tempfile::tempdir().unwrap();
    let mut child = long_run(out.path());
    let interrupt = format!("kill -INT {}", child.id());
    assert!(Process::new("sh").args(["-c", &interrupt]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_complete(out.path(), "interrupted");
}

#[test]
fn a_killed_run_leaves_whole_rows() {
    let out = tempfile::tempdir().unwrap();
    let mut child = long_run(out.path());
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(rows(out.path(), "history.csv").len() >= 9);
    rows(out.path(), "timings.csv");
    rows(out.path(), "events.csv");
    assert_eq!(json(out.path(), "run.json")["outcome"]["status"], "running");
}

#[test]
fn two_runs_leave_the_same_bytes() {
    // Compaction, bonds that break, walls that a stage takes away, frames, pictures, a dump.
    let settings = [
        "--set",
        "stages.load.walls.top[1]=-14.0e-6",
        "--set",
        "stages.load.increments=8",
        "--set",
        "output=(frames_every: 3)",
        "--dump-program",
        "40",
    ];
    let (first, a) = run("uniaxial_small", &[&settings[..], &["--threads", "1"]].concat());
    let (second, b) =
        run("uniaxial_small", &[&settings[..], &["--quiet", "--threads", "2"]].concat());
    let (first, second) = (first.code(0), second.code(0));
    let last = |run: &Assert| stdout(run).lines().rev().nth(1).map(str::to_owned);
    assert_eq!(last(&first), last(&second));
    let (a, b) = (files(a.path()), files(b.path()));
    assert!(a.keys().eq(b.keys()), "{:?}\n{:?}", a.keys(), b.keys());
    for (name, bytes) in &a {
        assert!(*bytes == b[name], "{} differs", name.display());
    }
    let events = String::from_utf8_lossy(&a[Path::new("events.csv")]);
    assert!(events.lines().count() > 1, "no bond broke");
    for name in ["frames/frame_000003.csv", "program_000040.json", "curves.svg", "specimen.csv"] {
        assert!(a.contains_key(Path::new(name)), "no {name}");
    }
}

/// A biaxial test without bonds whose solves under Coulomb's law end before they have converged.
fn capped(settings: &[&str]) -> (Assert, TempDir) {
    let law = "friction_law=Coulomb(factorisations: 5)";
    let few = ["stages.cement.length=1e-12", "stages.load.increments=4", "output.plots=false"];
    let mut all = vec!["--quiet", "--set", law];
    all.extend(few.iter().chain(settings).flat_map(|set| ["--set", set]));
    run("biaxial_small", &all)
}

#[test]
fn a_run_with_capped_increments_says_so_loudly() {
    let (done, out) = capped(&[]);
    let said = stdout(&done.code(0));
    for what in [
        "completed in 9 increments, all of them capped",
        "WARNING: all 5 increments of stage confine are capped",
        "WARNING: all 4 increments of stage load are capped",
    ] {
        assert!(said.lines().any(|line| line == what), "no `{what}` in\n{said}");
    }
    assert!(rows(out.path(), "history.csv").iter().all(|row| row["status"] == "capped"));
    let record = json(out.path(), "run.json");
    assert_eq!(record["capped_increments"], 9);
    assert_eq!(record["stages"][2]["capped"], 4);
    let message = record["outcome"]["message"].as_str().unwrap();
    assert!(message.contains("all 4 increments of stage load are capped"), "{message}");
    let pictures = tempfile::tempdir().unwrap();
    let [runs, to] = [out.path(), pictures.path()].map(|path| path.to_str().unwrap());
    let compared = stdout(&clastic(&["compare", runs, "--out", to]).code(0));
    assert!(compared.contains("completed, 9 of 9 increments capped"), "{compared}");

    // With as many factorisations as some solves need, and others do not.
    let (done, out) = capped(&["friction_law.factorisations=7"]);
    let said = stdout(&done.code(0));
    let history = rows(out.path(), "history.csv");
    let count = |stage: &str| {
        history.iter().filter(|row| row["stage"] == stage && row["status"] == "capped").count()
    };
    let [confine, load] = ["confine", "load"].map(count);
    assert!(confine > 0 && confine + load < 9, "{confine}, {load}");
    let all = confine + load;
    assert!(
        said.starts_with(&format!("completed in 9 increments, {all} of them capped\n")),
        "{said}"
    );
    let of_five = if confine == 5 { "all 5".to_owned() } else { format!("{confine} of 5") };
    let warning = format!("\nWARNING: {of_five} increments of stage confine are capped\n");
    assert!(said.contains(&warning), "{said}");
    assert_eq!(said.contains("increments of stage load are capped"), load > 0, "{said}");
    assert_eq!(json(out.path(), "run.json")["capped_increments"], all);
    // A run without capped increments has no warning.
    let (done, _out) = run("tension", &["--quiet"]);
    assert!(!stdout(&done.code(0)).contains("apped"));
}

#[test]
fn key_results_of_capped_increments_are_null_with_the_reason() {
    let (done, out) = capped(&[]);
    let said = stdout(&done.code(0));
    assert!(!said.contains("E = ") && !said.contains("peak stress 3"), "{said}");
    assert!(said.contains("no modulus and no peak stress: all increments"), "{said}");
    let results = &json(out.path(), "run.json")["results"];
    for name in [
        "youngs_modulus_pa",
        "youngs_modulus_secant_half_peak_pa",
        "peak_stress_pa",
        "strain_at_peak",
    ] {
        assert!(results[name].is_null(), "{name}: {}", results[name]);
        let reason = results["not_defined"][name].as_str().unwrap();
        assert!(reason.contains("capped"), "{name}: {reason}");
    }
}

#[test]
fn round_off_is_no_key_result() {
    // The platen moves away from the specimen.
    let away = ["stages.load.walls.top[1]=1.0e-6", "stages.load.increments=6"];
    let (done, out) = run("uniaxial_small", &["--quiet", "--set", away[0], "--set", away[1]]);
    let said = stdout(&done.code(0));
    assert!(!said.contains("E = ") && said.contains("but for round-off"), "{said}");
    let results = &json(out.path(), "run.json")["results"];
    assert!(results["youngs_modulus_pa"].is_null() && results["peak_stress_pa"].is_null());
    let reason = results["not_defined"]["youngs_modulus_pa"].as_str().unwrap();
    assert!(reason.contains("round-off"), "{reason}");
}

#[test]
fn a_reference_stage_without_a_curve_is_mentioned() {
    let load = "Load(name: \"load\", increments: 2, particles: [(select: Group(\"boundary\"), \
                rotation: Held, affine: ((0.0, 0.0), (0.0, -1.0e-6)))])";
    let cement = |name: &str| format!("Cement(name: \"{name}\", length: 1.0e-6)");
    let stages = format!("stages=[{}, {load}, {}]", cement("bonds"), cement("last"));
    let (done, _out) = run("lattice", &["--quiet", "--set", &stages]);
    let said = stdout(&done.code(0));
    let line = said.lines().find(|line| line.contains("no increment from the start"));
    let line = line.unwrap_or_else(|| panic!("nothing is said in {said}"));
    assert!(line.contains("the reference stage is last; `measures.reference_stage`"), "{line}");
    // The other one has a curve: nothing is to be said.
    let reference = "measures.reference_stage=\"load\"";
    let (done, _out) = run("lattice", &["--quiet", "--set", &stages, "--set", reference]);
    let said = stdout(&done.code(0));
    assert!(said.contains("E = ") && !said.contains("measures.reference_stage"), "{said}");
}

#[test]
fn the_moment_of_the_stored_specimen_is_said() {
    // Poured: the disk falls in the only stage, which is the reference stage.
    let (done, out) = run("bounce", &["--quiet", "--set", "stages.drop.increments=60"]);
    let said = stdout(&done.code(0));
    let moment = "at the start of the reference stage `drop`, before its first increment";
    assert!(said.contains(&format!("specimen.csv holds the particles {moment}")), "{said}");
    assert_eq!(json(out.path(), "run.json")["specimen_csv"], moment);
    let height = |name: &str| rows(out.path(), name)[0]["y_m"].parse::<f64>().unwrap();
    assert!(height("specimen.csv") > height("final_particles.csv"));
    // A compaction leaves its packing.
    let (done, out) = run("prepare_biaxial_small", &["--quiet"]);
    let said = stdout(&done.code(0));
    let moment = "at the end of the compaction `compact`";
    assert!(said.contains(&format!("specimen.csv holds the particles {moment}")), "{said}");
    assert_eq!(json(out.path(), "run.json")["specimen_csv"], moment);
}

#[test]
fn a_program_is_dumped_by_increments_of_the_run_or_of_a_stage() {
    let few = ["--quiet", "--set", "stages.load.increments=3"];
    let dumps = ["--dump-program", "2", "--dump-program", "load:2", "--dump-program", "load:9"];
    let (done, out) = run("biaxial_small", &[&few[..], &dumps].concat());
    let said = stderr(&done.code(0));
    assert!(said.contains("--dump-program load:9: the stage ended with its increment 3"), "{said}");
    let names = files(out.path()).into_keys().map(|name| name.display().to_string());
    let programs: Vec<_> = names.filter(|name| name.starts_with("program_")).collect();
    // The confinement has five increments: the second one of the load is the seventh of the run.
    assert_eq!(programs, ["program_000002.json", "program_000007.json"]);
    assert_eq!(json(out.path(), "program_000007.json")["stage"], "load");
    let unknown = ["run", "biaxial_small", "--dump-program", "lod:2"];
    let said = stderr(&clastic(&unknown).code(2));
    assert!(said.contains("no such stage; its stages are cement, confine, load"), "{said}");
    for wrong in ["0", "load:", "load:0", "x"] {
        clastic(&["run", "biaxial_small", "--dump-program", wrong]).code(2);
    }
}

/// The number at a key, or the numbers of a table.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list = value.as_array().unwrap();
    assert_eq!(list.len(), N);
    std::array::from_fn(|k| number(&list[k]))
}

/// Balance and complementarity of a dumped program, from the words of its `format` alone.
fn check_dump(dump: &Value) -> [f64; 2] {
    let table = |value: &Value| -> Vec<[f64; 3]> {
        value.as_array().unwrap().iter().map(numbers).collect()
    };
    let forces = table(&dump["solution"]["forces"]);
    let u = table(&dump["solution"]["displacements"]);
    let bodies = dump["bodies"].as_array().unwrap();
    let axes: Vec<[f64; 2]> = bodies.iter().map(|b| numbers(&b["axis"])).collect();
    // Forces along x and y and moments about the centre that every body resists.
    let mut resisted = vec![[0.0; 3]; bodies.len()];
    let mut greatest = [f64::MIN_POSITIVE; 2];
    for f in &forces {
        greatest[0] = greatest[0].max(f[0].abs()).max(f[1].abs());
    }
    let global = |i: usize| {
        let (a, v) = (axes[i], u[i]);
        [a[0] * v[0] - a[1] * v[1], a[1] * v[0] + a[0] * v[1], v[2]]
    };
    for i in 0..bodies.len() {
        let v = global(i);
        greatest[1] = greatest[1].max(v[0].hypot(v[1]));
    }
    let mut product = 0.0_f64;
    let mut lever = 0.0_f64;
    for (c, [p, q, tau]) in dump["interactions"].as_array().unwrap().iter().zip(&forces) {
        let get = |key: &str| number(&c[key]);
        let limit = |key: &str| number(&c["limits"][key]);
        let (a, b) = (c["a"].as_u64().unwrap() as usize, c["b"].as_u64().unwrap() as usize);
        let [nx, ny]: [f64; 2] = numbers(&c["normal"]);
        let (x, y) = (p * nx - q * ny, p * ny + q * nx);
        let (arm_a, arm_b) = (get("arm_a"), get("arm_b"));
        lever = lever.max(arm_a).max(arm_b);
        for (body, add) in [(a, [x, y, arm_a * q + tau]), (b, [-x, -y, arm_b * q - tau])] {
            for k in 0..3 {
                resisted[body][k] += add[k];
            }
        }
        let (ua, ub) = (global(a), global(b));
        let (dx, dy) = (ua[0] - ub[0], ua[1] - ub[1]);
        let closing = nx * dx + ny * dy;
        let sheared = limit("cohesion") > 0.0 || limit("friction") > 0.0;
        let slip = if sheared {
            let elastic = get("tangential_compliance") * (q - get("previous_shear"));
            nx * dy - ny * dx + arm_a * ua[2] + arm_b * ub[2] - elastic
        } else {
            0.0
        };
        let rotation = if limit("rolling") > 0.0 { ua[2] - ub[2] } else { 0.0 };
        let opening = get("offset") + get("normal_compliance") * p
            - closing
            - limit("friction") * slip.abs()
            - limit("rolling") * rotation.abs();
        for (multiplier, slack) in [
            (slip, limit("cohesion") + limit("friction") * p - q * slip.signum()),
            (rotation, limit("moment") + limit("rolling") * p - tau * rotation.signum()),
            (opening, p + limit("tension")),
        ] {
            product = product.max((multiplier * slack).abs());
        }
    }
    let mut balance = 0.0_f64;
    for (i, body) in bodies.iter().enumerate() {
        let (a, r) = (axes[i], resisted[i]);
        let own = [a[0] * r[0] + a[1] * r[1], a[0] * r[1] - a[1] * r[0], r[2]];
        for k in 0..3 {
            let free = &body["dofs"][k]["free"];
            if free.is_object() {
                let defect = number(&free["inertia"]) * u[i][k] + own[k] - number(&free["load"]);
                let unit = if k < 2 { greatest[0] } else { greatest[0] * lever };
                balance = balance.max(defect.abs() / unit);
            }
        }
    }
    [balance, product / (greatest[0] * greatest[1])]
}

#[test]
fn a_dumped_program_can_be_checked_by_anyone() {
    // The last increments of the confinement: bonds, contacts, four loaded walls.
    let (done, out) = run("biaxial_small", &["--set", "stages.load.increments=2"]);
    done.code(0);
    let history = rows(out.path(), "history.csv");
    let dumped = ["confine", "load"].map(|stage| {
        let row = history.iter().rev().find(|row| row["stage"] == stage).unwrap();
        assert_eq!(row["status"], "solved");
        row["increment"].clone()
    });
    let (done, out) = run(
        "biaxial_small",
        &[
            "--set",
            "stages.load.increments=2",
            "--dump-program",
            &dumped[0],
            "--dump-program",
            &dumped[1],
        ],
    );
    done.code(0);
    for increment in dumped {
        let mut dump = json(out.path(), &format!("program_{increment:0>6}.json"));
        assert!(dump["interactions"].as_array().unwrap().len() > 400);
        let [balance, complementarity] = check_dump(&dump);
        assert!(balance <= 1e-8, "increment {increment}: balance {balance:e}");
        assert!(complementarity <= 1e-8, "increment {increment}: {complementarity:e}");
        // The check sees what is wrong: a force that is off by 1 %.
        let forces = dump["solution"]["forces"].as_array_mut().unwrap();
        let greatest = (0..forces.len())
            .max_by(|i, j| number(&forces[*i][0]).total_cmp(&number(&forces[*j][0])))
            .unwrap();
        forces[greatest][0] = (1.01 * number(&forces[greatest][0])).into();
        let [balance, complementarity] = check_dump(&dump);
        assert!(balance > 1e-4 && complementarity > 1e-8, "{balance:e}, {complementarity:e}");
    }
}
