//! `clastic report` of several runs: their table and the names in their page.

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

    let page = at("page.html");
    let directories = ["old/lattice", "new/lattice", "rigid"].map(at);
    let mut arguments = vec!["report", "--out", page.to_str().unwrap()];
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
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("new/lattice") && page.contains("old/lattice"));
}
