//! Arguments, the choice of the scene, and output on the terminal.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

use crate::call::{PROGRAM, ROOT, clastic, edited, run, stderr, stdout};
use crate::common::files;

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
    // The name of a scene was echoed whole.
    let said = stderr(&clastic(&["check", &long[..100_000]]).code(1));
    assert!(said.len() < 2000 && said.contains("... (100000 characters)"), "{said}");
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
    assert!(stdout(&call(&["list"]).code(0)).contains("(has errors; see `clastic check tension`)"));
    // Messages say that the scene is the shipped one; for a scene that is not found they list the
    // places that were searched.
    let set = ["check", "stack", "--set", "specimen=File(path: \"none.csv\")"];
    let missing = stderr(&call(&set).code(3));
    assert!(missing.contains("`<clastic>/scenes/none.csv`"), "{missing}");
    let nowhere = stderr(&call(&["run", "no_such_scene"]).code(1));
    for place in ["no such file here", "./scenes", "clastic ships none", "clastic list"] {
        assert!(nowhere.contains(place), "no `{place}` in {nowhere}");
    }
}

/// A recipe that writes a scene into `scenes/` leaves one there that the program does not list and
/// that has no stored reference, so that the tests fail afterwards.
#[test]
fn no_recipe_of_the_docs_writes_into_the_scenes() {
    let root = Path::new(ROOT);
    let pages = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let pages = pages.chain(["README.md", "CONTRIBUTING.md"].map(|page| root.join(page)));
    let mut commands = 0;
    for page in pages.filter(|page| page.extension().is_some_and(|e| e == "md")) {
        // Blocks of commands are indented by four spaces.
        for line in fs::read_to_string(&page).unwrap().lines().filter(|l| l.starts_with("    ")) {
            commands += usize::from(line.contains("scenes/"));
            let writes = ["> scenes/", ">scenes/", "--out scenes", "-o scenes/"];
            let found = writes.iter().any(|write| line.contains(write));
            assert!(!found, "{}: {line}", page.display());
        }
    }
    assert!(commands > 0, "{commands} lines name a scene: are blocks still indented?");
}

/// `clastic envelope` and `clastic stability` are in the package for Python alone.
#[test]
fn a_command_of_the_package_for_python_says_where_it_is() {
    for arguments in [
        &["stability"][..],
        &["stability", "--help"],
        &["stability", "slope", "--on", "gravity"],
        &["envelope", "biaxial_small", "--confining", "1e5,2e5"],
    ] {
        let said = stderr(&clastic(arguments).code(2));
        assert!(said.contains("pip install './python[all]'"), "{said}");
    }
}
