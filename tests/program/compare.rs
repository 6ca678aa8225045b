//! `clastic compare`: the table and the pictures of several runs.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

use crate::call::{PROGRAM, ROOT};

fn clastic(arguments: &[&str]) -> String {
    let program = Command::new(PROGRAM).current_dir(ROOT).args(arguments).assert().code(0);
    String::from_utf8_lossy(&program.get_output().stdout).into_owned()
}

fn run(scene: &str, out: &Path, set: &str) {
    clastic(&["run", scene, "--quiet", "--out", out.to_str().unwrap(), "--set", set]);
}

#[test]
fn runs_of_one_name_are_told_apart_and_unfinished_ones_are_marked() {
    let parent = tempfile::tempdir().unwrap();
    let at = |name: &str| parent.path().join(name);
    run("lattice", &at("old/lattice"), "output.plots=false");
    run("lattice", &at("new/lattice"), "output.plots=false");
    run("uniaxial_rigid_small", &at("rigid"), "output.plots=false");
    // The directory of a run that is under way or was killed.
    let record = at("new/lattice/run.json");
    let text = fs::read_to_string(&record).unwrap();
    let running = text.replacen("\"status\": \"completed\"", "\"status\": \"running\"", 1);
    assert_ne!(text, running);
    fs::write(&record, running).unwrap();

    let out = at("pictures");
    let directories = ["old/lattice", "new/lattice", "rigid"].map(at);
    let mut arguments = vec!["compare", "--out", out.to_str().unwrap()];
    arguments.extend(directories.iter().map(|path| path.to_str().unwrap()));
    let said = clastic(&arguments);
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines[0].contains("limit load, MPa"), "{said}");
    assert!(lines[1].starts_with("old/lattice") && lines[1].ends_with("completed"), "{said}");
    assert!(lines[2].starts_with("new/lattice") && lines[2].ends_with("running"), "{said}");
    // The limit load that `run.json` of the rigid specimen holds, in MPa.
    let record = fs::read_to_string(at("rigid/run.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    let limit = record["results"]["limit_load_pa"].as_f64().unwrap() * 1e-6;
    assert!(limit > 1000.0 && lines[3].contains(&format!("{limit:.4}")), "{limit}: {said}");
    assert!(said.contains("killed"), "{said}");
    let stress = fs::read_to_string(out.join("stress.svg")).unwrap();
    assert!(stress.contains("new/lattice (running)") && stress.contains("old/lattice"));
}

/// Where no picture was drawn, older pictures of other runs stayed in the directory.
#[test]
fn a_comparison_without_curves_leaves_no_older_picture() {
    let parent = tempfile::tempdir().unwrap();
    let at = |name: &str| parent.path().join(name);
    run("bounce", &at("bounce"), "output.plots=false");
    let out = at("pictures");
    fs::create_dir(&out).unwrap();
    for file in ["stress.svg", "volumetric.svg"] {
        fs::write(out.join(file), "older").unwrap();
    }
    let paths = [&out, &at("bounce")].map(|path| path.to_str().unwrap().to_owned());
    let said = clastic(&["compare", "--out", &paths[0], &paths[1]]);
    assert!(said.contains("no picture"), "{said}");
    assert_eq!(fs::read_dir(&out).unwrap().count(), 0);
}

#[test]
fn a_directory_without_a_run_is_named() {
    let parent = tempfile::tempdir().unwrap();
    let program =
        Command::new(PROGRAM).args(["compare", parent.path().to_str().unwrap()]).assert().code(1);
    let said = String::from_utf8_lossy(&program.get_output().stderr).into_owned();
    assert!(said.contains("no run is here (no run.json)"), "{said}");
}
