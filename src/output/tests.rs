//! Tests of the files of a run.

use std::error::Error;
use std::fs;
use std::path::Path;

use clastic_cone::program::SolveStatus;
use clastic_cone::solver::ConeSolver;
use clastic_reference::Clarabel;
use clastic_reference::dump::from_json;

use super::*;
use crate::run::key_results::Results;
use crate::run::{Simulation, Step};
use crate::scene::from_str;

const SCENE: &str = r#"(
    version: 1,
    title: "two disks pulled apart",
    rupture: (order: OneRound),
    materials: { "m": (
        contact: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6),
        bond: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6, cohesion: 4.0e3, tensile_strength: 2.0e3),
    ) },
    specimen: Particles([
        (position: (0.0, 0.0), radius: 6.0e-3),
        (position: (12.0e-3, 0.0), radius: 6.0e-3, probe: "pulled"),
    ]),
    bonds: [(a: 0, b: 1)],
    stages: [Load(name: "pull", increments: 4, particles: [
        (select: Index([0]), x: Held, y: Held, rotation: Held),
        (select: Index([1]), x: Displacement(1.0e-6), y: Held, rotation: Held),
    ])],
    output: (frames_every: 2),
)"#;

fn run(directory: &Path, stop_after: u64) -> Result<Results, Box<dyn Error>> {
    let loaded = from_str(SCENE, Path::new("elsewhere/two.ron"), Path::new(""), &[])?;
    let mut simulation = Simulation::in_app(crate::run::app(OutputPlugin), &loaded.scene, None);
    let options = RunOptions {
        directory: directory.to_owned(),
        dump_programs: vec![3],
        ..Default::default()
    };
    begin(simulation.world_mut(), options, &loaded)?;
    for _ in 0..stop_after {
        if let Step::Finished(outcome) = simulation.step() {
            return Ok(finish(simulation.world_mut(), Some(&outcome))?);
        }
    }
    Ok(finish(simulation.world_mut(), None)?)
}

/// Names and contents of all files except the timings.
fn files(directory: &Path) -> Result<Vec<(String, String)>, Box<dyn Error>> {
    let mut all = Vec::new();
    for directory in [directory.to_owned(), directory.join(directory::FRAMES)] {
        for entry in fs::read_dir(directory)? {
            let path = entry?.path();
            if path.is_file() && !path.ends_with(directory::TIMINGS) {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                all.push((name, String::from_utf8_lossy(&fs::read(path)?).into_owned()));
            }
        }
    }
    all.sort();
    Ok(all)
}

#[test]
fn two_runs_leave_the_same_bytes() -> Result<(), Box<dyn Error>> {
    let parent = tempfile::tempdir()?;
    let (first, second) = (parent.path().join("1"), parent.path().join("2"));
    let results = run(&first, u64::MAX)?;
    run(&second, u64::MAX)?;
    assert_eq!(results.bonds_broken.tension, 1);
    let written = files(&first)?;
    assert_eq!(written, files(&second)?);
    let names: Vec<_> = written.iter().map(|(name, _)| name.as_str()).collect();
    let expected = [
        "avalanches.csv",
        "end.npz",
        "events.csv",
        "final_checkpoint.bin",
        "final_particles.csv",
        "final_state.npz",
        "frame_000002.csv",
        "frame_000002.npz",
        "frame_000004.csv",
        "frame_000004.npz",
        "history.csv",
        "program_000003.json",
        #[cfg(feature = "report")]
        "report.html",
        "run.json",
        "scene.ron",
        "specimen.csv",
        "start.npz",
    ];
    assert_eq!(names, expected);
    let here = parent.path().to_string_lossy();
    assert!(written.iter().all(|(_, text)| !text.contains(&*here) && !text.contains("elsewhere")));
    Ok(())
}

#[test]
fn a_dumped_program_reads_back_and_has_the_dumped_solution() -> Result<(), Box<dyn Error>> {
    let parent = tempfile::tempdir()?;
    run(parent.path(), u64::MAX)?;
    let path = directory::program(parent.path(), 3);
    let dump = from_json(&fs::read_to_string(&path)?)?;
    let (program, dumped) = (dump.program(), dump.solution);
    assert_eq!(dumped.status, SolveStatus::Solved);
    let solution = Clarabel::default().solve(&program, 0.0)?;
    let maximum = dumped.forces.iter().map(|g| g[0].abs()).fold(0.0, f64::max);
    for (f, g) in solution.forces.iter().zip(&dumped.forces) {
        let tolerance = 1e-9 * g[0].abs() + f64::EPSILON * maximum;
        assert!((f[0] - g[0]).abs() <= tolerance, "{f:?} {g:?}");
    }
    let other = fs::read_to_string(&path)?.replacen("version 1", "version 2", 1);
    assert!(from_json(&other).is_err());
    Ok(())
}

#[test]
fn a_stage_says_what_is_recorded() -> Result<(), Box<dyn Error>> {
    let parent = tempfile::tempdir()?;
    let set = ["stages.pull.record=(every: 3, frames_every: 0, frames: [1, 4])".to_owned()];
    let loaded = from_str(SCENE, Path::new("two.ron"), Path::new(""), &set)?;
    let mut simulation = Simulation::in_app(crate::run::app(OutputPlugin), &loaded.scene, None);
    let options = RunOptions { directory: parent.path().to_owned(), ..Default::default() };
    begin(simulation.world_mut(), options, &loaded)?;
    let outcome = simulation.run();
    finish(simulation.world_mut(), Some(&outcome))?;
    let written = |name: &str| fs::read_to_string(parent.path().join(name));
    // Every third increment, and the last.
    for file in [directory::HISTORY, directory::TIMINGS] {
        let text = written(file)?;
        let rows: Vec<_> = text.lines().filter_map(|line| line.split(',').next()).collect();
        assert_eq!(rows, ["increment", "3", "4"], "{file}");
    }
    let names: Vec<_> = files(parent.path())?.into_iter().map(|(name, _)| name).collect();
    let frames: Vec<_> = names.iter().filter(|name| name.starts_with("frame_")).collect();
    let expected = ["1.csv", "1.npz", "4.csv", "4.npz"];
    let expected = expected.map(|name| format!("frame_00000{name}"));
    assert_eq!(frames, expected.iter().collect::<Vec<_>>());
    // The record contains the rupture in between all the same.
    let record: serde_json::Value = serde_json::from_str(&written(directory::RUN)?)?;
    assert_eq!(record["increments"], 4);
    assert_eq!(record["results"]["bonds_broken"]["tension"], 1);
    assert_eq!(record["stages"][0]["ended_by"], "all_increments");
    Ok(())
}

#[test]
fn an_interrupted_run_is_complete_up_to_there() -> Result<(), Box<dyn Error>> {
    let parent = tempfile::tempdir()?;
    run(parent.path(), 2)?;
    let history = fs::read_to_string(parent.path().join(directory::HISTORY))?;
    assert_eq!(history.lines().count(), 3);
    let record = fs::read_to_string(parent.path().join(directory::RUN))?;
    let record: serde_json::Value = serde_json::from_str(&record)?;
    assert_eq!(record["outcome"]["status"], "interrupted");
    assert_eq!(record["increments"], 2);
    assert_eq!(record["results"]["bonds_intact"], 1);
    Ok(())
}

#[test]
fn the_stored_specimen_reads_back_to_the_bit() -> Result<(), Box<dyn Error>> {
    let parent = tempfile::tempdir()?;
    run(parent.path(), 1)?;
    let stored = crate::scene::specimen_file::read(&parent.path().join(directory::SPECIMEN))?;
    let disks: Vec<_> = stored.rows.iter().map(|row| (row.x, row.y, row.r)).collect();
    assert_eq!(disks, [(0.0, 0.0, 6.0e-3), (12.0e-3, 0.0, 6.0e-3)]);
    Ok(())
}
