//! What may change when a run goes on.

use std::fs;
use std::path::Path;

use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;
use clastic::output::{self, Checkpoint, OutputPlugin, RunOptions, directory};
use clastic::run::state::StateView;
use clastic::run::{Outcome, Simulation, Step, changes};
use clastic::scene::{self, LoadedScene};

use crate::common::files;
use crate::resumed::{COULOMB, assert_same_files, copy, load, parse, resume, run};

#[test]
fn an_undecided_run_goes_on_with_other_settings() {
    // Grains move further than the limit of this scene allows, and no wall drives them.
    let sets = [
        "acceptance.turn=1e-6",
        "stages.confine.increments=2",
        "stages.load.increments=11",
        "stages.load.walls.top[1]=-0.2e-3",
    ];
    let loaded = load("biaxial_small", &sets);
    let parent = tempfile::tempdir().unwrap();
    let (stalled, again) = (parent.path().join("stalled"), parent.path().join("again"));
    let mut records = Vec::new();
    // No checkpoints were asked for: the failure itself writes one.
    let (outcome, _) = run(&loaded, &stalled, 0, |o| records.push(o.clone()));
    let failed = records.last().unwrap();
    assert_eq!(failed.status, IncrementStatus::Undecided, "{outcome:?}");
    let checkpoint = Checkpoint::read(&stalled).unwrap();
    assert_eq!(checkpoint.increment + 1, failed.increment);
    let before: Observation = checkpoint.world.get("observation").unwrap();
    assert_eq!(before, records[records.len() - 2]);

    // With the same settings it fails in the same way and leaves the same bytes.
    let expected = files(&stalled);
    copy(&stalled, &again);
    assert_eq!(resume(&again, &[]).0, outcome);
    assert_same_files(&again, &expected, "resumed as it was");

    // With others it goes on to the end. The failed row is gone and the record says what happened.
    let (outcome, state) = resume(&stalled, &["acceptance.turn=0.2"]);
    assert_eq!(outcome, Outcome::Completed);
    let last: Observation = state.get("observation").unwrap();
    assert!(last.increment >= failed.increment);
    let history = fs::read_to_string(stalled.join(directory::HISTORY)).unwrap();
    assert!(!history.contains("undecided"));
    assert_eq!(history.lines().count() as u64, 1 + last.increment);
    let record = fs::read_to_string(stalled.join(directory::RUN)).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    assert_eq!(record["resumed"][0]["after_increment"], failed.increment - 1);
    assert_eq!(record["resumed"][0]["settings"][0], "acceptance.turn=0.2");
    assert_eq!(record["settings"]["acceptance"]["turn"], 0.2);
    assert_eq!(record["increments"], last.increment);
    let scene = fs::read_to_string(stalled.join(directory::SCENE)).unwrap();
    assert!(scene.contains("turn: 0.2"), "{scene}");
}

/// The state of [`COULOMB`] after some increments, and its scene.
fn state_after(increments: u64) -> (LoadedScene, StateView) {
    let loaded = parse(COULOMB);
    let mut simulation = Simulation::new(&loaded.scene, None);
    for _ in 0..increments {
        assert_eq!(simulation.step(), Step::Increment);
    }
    (loaded, StateView::of(&simulation.state().unwrap()).unwrap())
}

#[test]
fn what_may_change_depends_on_how_far_the_run_has_come() {
    let (old, state) = state_after(5);
    assert_eq!(state.progress.stage_name, "compress");
    let refused = |set: &str| {
        let new = scene::from_str_with(
            COULOMB,
            Path::new("rig.ron"),
            state.specimen.clone(),
            &[set.to_owned()],
        );
        changes::refused(&old.scene, &new.unwrap_or_else(|e| panic!("{e}")).scene, &state)
            .join("\n")
    };
    for free in [
        "acceptance.turn=0.5",
        "solver=Clarabel()",
        "friction_law=Associated",
        "rupture.order=Events",
        "rupture.density=0.2",
        "output.frames_every=2",
        "stages.release.increments=7",
        "stages.hold.gravity=(0.0, 0.0)",
        "stages.compress.stop=[Above(\"axial_strain\", 0.01)]",
        "stages.compress.walls.top[1]=-10.0e-6",
        "stages.compress.increments=40",
    ] {
        assert_eq!(refused(free), "", "{free}");
    }
    for (fixed, field) in [
        ("specimen.radius=4.9e-3", "specimen"),
        ("materials.stone.bond.cohesion=1e3", "materials"),
        ("walls.top.contact.friction=0.1", "walls"),
        ("thickness=2.0", "thickness"),
        ("gravity=(0.0, -1.0)", "gravity"),
        ("reference_stage=\"release\"", "reference_stage"),
        ("measures[0].of=Strain(Walls(\"top\", \"bottom\"))", "measures"),
        ("bonds=[(a: 0, b: 1)]", "bonds"),
        ("stages.confine.increments=4", "stages.confine"),
        ("stages.cement.length=0.2e-3", "stages.cement"),
        ("stages.compress.gravity=(0.0, -9.81)", "stages.compress"),
        ("stages.compress.walls.top=Force(10.0)", "stages.compress"),
    ] {
        let said = refused(fixed);
        assert!(said.contains(&format!("`{field}` cannot change: ")), "{fixed}: {said}");
    }

    // While loads go to their targets the number of increments is theirs.
    let (old, state) = state_after(2);
    let new = scene::from_str_with(
        COULOMB,
        Path::new("rig.ron"),
        state.specimen.clone(),
        &["stages.confine.increments=6".to_owned()],
    );
    let said = changes::refused(&old.scene, &new.unwrap().scene, &state).join("\n");
    assert!(said.contains("`stages.confine` cannot change") && said.contains("target"), "{said}");
}

#[test]
fn a_stage_under_way_goes_on_longer_and_slower() {
    let loaded = parse(COULOMB);
    let parent = tempfile::tempdir().unwrap();
    let mut simulation = Simulation::in_app(clastic::run::app(OutputPlugin), &loaded.scene, None);
    let options = RunOptions { directory: parent.path().to_owned(), ..Default::default() };
    output::begin(simulation.world_mut(), options, &loaded).unwrap();
    for _ in 0..5 {
        simulation.step();
    }
    output::finish(simulation.world_mut(), None).unwrap();
    drop(simulation);
    resume(
        parent.path(),
        &["stages.compress.increments=17", "stages.compress.walls.top=Displacement(0.0, -10.0e-6)"],
    );
    let history = fs::read_to_string(parent.path().join(directory::HISTORY)).unwrap();
    let header: Vec<_> = history.lines().next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let place =
        |line: &str| -> f64 { line.split(',').nth(column("top.y_m")).unwrap().parse().unwrap() };
    let compress: Vec<_> = history.lines().filter(|l| l.contains(",compress,")).collect();
    assert_eq!(compress.len(), 17);
    for (pair, motion) in compress.windows(2).zip([-30.0e-6].into_iter().chain([-10.0e-6; 15])) {
        let moved = place(pair[1]) - place(pair[0]);
        assert!((moved - motion).abs() < 1e-12, "{moved} for {motion}");
    }
}
