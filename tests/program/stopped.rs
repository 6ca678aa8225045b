//! Runs that are interrupted or killed.

use std::fs;
use std::path::Path;
use std::process::{Command as Process, Stdio};
use std::time::{Duration, Instant};

use crate::call::{PROGRAM, ROOT, assert_complete, json, rows};

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
