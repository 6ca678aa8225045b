//! Calls of the `clastic` program, and the files of a run.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use bevy_ecs::prelude::*;
use clastic::output::{self, OutputPlugin, RunDirectory, RunOptions};
use clastic::run::{Outcome, Simulation};
use clastic::scene::LoadedScene;
use serde_json::Value;
use tempfile::TempDir;

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_clastic");
pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// `clastic` with arguments, in the directory of the package, where `scenes/` is.
pub fn clastic(arguments: &[&str]) -> Assert {
    Command::new(PROGRAM).current_dir(ROOT).args(arguments).assert()
}

pub fn stdout(run: &Assert) -> String {
    String::from_utf8_lossy(&run.get_output().stdout).into_owned()
}

pub fn stderr(run: &Assert) -> String {
    String::from_utf8_lossy(&run.get_output().stderr).into_owned()
}

/// Runs a scene into a directory of its own.
pub fn run(scene: &str, settings: &[&str]) -> (Assert, TempDir) {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().to_str().unwrap();
    let mut arguments = vec!["run", scene, "--out", out];
    arguments.extend(settings);
    (clastic(&arguments), directory)
}

/// Runs a scene into a directory of its own, in this process, with settings of the engine that
/// scenes do not have.
pub fn run_with(loaded: &LoadedScene, set: impl FnOnce(&mut World)) -> TempDir {
    let out = tempfile::tempdir().unwrap();
    let specimen = loaded.specimen.as_ref();
    let mut simulation =
        Simulation::in_app(clastic::run::app(OutputPlugin), &loaded.scene, specimen);
    set(simulation.world_mut());
    let options = RunOptions { directory: out.path().to_owned(), ..Default::default() };
    output::begin(simulation.world_mut(), options, loaded).unwrap();
    let outcome = simulation.run();
    assert!(matches!(outcome, Outcome::Completed | Outcome::Collapsed(_)), "{outcome:?}");
    output::finish(simulation.world_mut(), Some(&outcome)).unwrap();
    simulation.world_mut().remove_resource::<RunDirectory>();
    out
}

/// A scene of `scenes/` with one text in it replaced by another, as a file.
pub fn edited(name: &str, from: &str, to: &str) -> (PathBuf, TempDir) {
    let directory = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(Path::new(ROOT).join("scenes").join(name)).unwrap();
    assert!(text.contains(from), "{name} has no `{from}`");
    let path = directory.path().join(name);
    fs::write(&path, text.replacen(from, to, 1)).unwrap();
    (path, directory)
}

pub fn read(directory: &Path, name: &str) -> String {
    fs::read_to_string(directory.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

pub fn json(directory: &Path, name: &str) -> Value {
    serde_json::from_str(&read(directory, name)).unwrap()
}

/// Rows of a file, each by column; every one is whole.
pub fn rows(directory: &Path, name: &str) -> Vec<BTreeMap<String, String>> {
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

/// The files that every run leaves, however it ended.
pub fn assert_complete(directory: &Path, status: &str) {
    let record = json(directory, "run.json");
    assert_eq!(record["outcome"]["status"], status);
    assert_eq!(record["increments"], rows(directory, "history.csv").len());
    assert_eq!(rows(directory, "timings.csv").len(), rows(directory, "history.csv").len());
    for name in ["scene.ron", "events.csv", "final_particles.csv"] {
        assert!(!read(directory, name).is_empty(), "{name} is empty");
    }
}
