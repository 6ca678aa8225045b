//! Checkpoints and directories that a run cannot go on from.

use std::fs;
use std::path::Path;

use bevy_app::App;
use bevy_ecs::prelude::*;
use clastic::output::{self, Checkpoint, OutputError, OutputPlugin, RunOptions, directory};
use clastic::run::plugin::StageSystems;
use clastic::run::{Simulation, StateError, Step};
use clastic::systems::state::RegisterState;
use clastic::systems::stepping::{AdvanceIncrement, AdvanceSystems};
use serde::{Deserialize, Serialize};

use crate::resumed::{COULOMB, bytes, copy_first, parse};

/// A directory with a checkpoint, and the error of reading it after a change.
fn refusal(change: impl Fn(&Path)) -> String {
    let parent = tempfile::tempdir().unwrap();
    let directory = parent.path().join("run");
    copy_first(&parse(COULOMB), &directory);
    assert!(Checkpoint::read(&directory).is_ok());
    change(&directory);
    let read = Checkpoint::read(&directory).map(|_| ());
    let message = read.err().map(|e: OutputError| e.to_string()).unwrap_or_default();
    assert!(message.contains(&*directory.to_string_lossy()), "no name in `{message}`");
    message
}

fn edit(path: &Path, change: impl Fn(&mut Vec<u8>)) {
    let mut bytes = fs::read(path).unwrap();
    change(&mut bytes);
    fs::write(path, bytes).unwrap();
}

#[test]
fn checkpoints_that_are_not_right_are_refused_by_name() {
    let checkpoint = directory::CHECKPOINT;
    let cases: [(&str, Box<dyn Fn(&Path)>); 8] = [
        ("format 0", Box::new(|d| edit(&d.join(checkpoint), |b| b[27] = b'0'))),
        ("damaged", Box::new(|d| edit(&d.join(checkpoint), |b| *b.last_mut().unwrap() ^= 1))),
        ("damaged", Box::new(|d| edit(&d.join(checkpoint), |b| b.truncate(b.len() / 2)))),
        ("damaged", Box::new(|d| edit(&d.join(checkpoint), Vec::clear))),
        ("damaged", Box::new(|d| edit(&d.join(checkpoint), |b| b[0] = b'x'))),
        ("another scene", Box::new(|d| edit(&d.join(directory::SCENE), |b| b.push(b' ')))),
        ("no checkpoint", Box::new(|d| fs::remove_file(d.join(checkpoint)).unwrap())),
        (
            "no run is here",
            Box::new(|d| {
                fs::remove_file(d.join(checkpoint)).unwrap();
                fs::remove_file(d.join(directory::RUN)).unwrap();
            }),
        ),
    ];
    for (expected, change) in &cases {
        let message = refusal(change);
        assert!(message.contains(expected), "no `{expected}` in `{message}`");
    }
}

#[test]
fn every_byte_of_a_checkpoint_counts() {
    let parent = tempfile::tempdir().unwrap();
    copy_first(&parse(COULOMB), parent.path());
    let path = parent.path().join(directory::CHECKPOINT);
    let whole = fs::read(&path).unwrap();
    for k in (0..whole.len()).step_by(97) {
        let mut bytes = whole.clone();
        bytes[k] ^= 0x10;
        fs::write(&path, &bytes).unwrap();
        assert!(Checkpoint::read(parent.path()).is_err(), "byte {k}");
        fs::write(&path, &whole[..k]).unwrap();
        assert!(Checkpoint::read(parent.path()).is_err(), "cut at {k}");
    }
    fs::write(&path, &whole).unwrap();
    assert!(Checkpoint::read(parent.path()).is_ok());
}

#[test]
fn a_directory_that_lost_rows_or_is_in_use_is_refused() {
    let parent = tempfile::tempdir().unwrap();
    let loaded = parse(COULOMB);
    let dir = parent.path();
    let try_resume = || {
        let checkpoint = Checkpoint::read(dir).unwrap();
        let state = &checkpoint.world;
        let mut other =
            Simulation::resume_in(clastic::run::app(OutputPlugin), &loaded.scene, state).unwrap();
        output::resume(other.world_mut(), dir, checkpoint, &loaded, &[], None)
            .map_err(|e| e.to_string())
    };
    let mut simulation = Simulation::in_app(clastic::run::app(OutputPlugin), &loaded.scene, None);
    let options =
        RunOptions { directory: dir.to_owned(), checkpoint_every: 2, ..Default::default() };
    output::begin(simulation.world_mut(), options, &loaded).unwrap();
    for _ in 0..3 {
        simulation.step();
    }
    assert!(try_resume().is_err_and(|e| e.contains("still writing")));
    drop(simulation);
    let history = dir.join(directory::HISTORY);
    let whole = fs::read(&history).unwrap();
    // An incomplete row after the checkpoint is dropped ...
    fs::write(&history, &whole[..whole.len() - 20]).unwrap();
    assert_eq!(try_resume(), Ok(()));
    assert_eq!(fs::read_to_string(&history).unwrap().lines().count(), 3);
    // ... but an incomplete row before the checkpoint is an error.
    edit(&history, |bytes| bytes.truncate(bytes.len() - 20));
    assert!(try_resume().is_err_and(|e| e.contains("history.csv") && e.contains("bytes")));
    edit(&history, |bytes| bytes.extend([b'x'; 20]));
    assert!(try_resume().is_err_and(|e| e.contains("its rows differ")));
}

#[derive(Resource, Serialize, Deserialize, PartialEq, Debug)]
struct Temperature(f64);

/// A plugin that keeps a temperature, and warms the specimen in every increment.
fn heat(app: &mut App) {
    app.register_resource::<Temperature>("heat.temperature");
    let warm = |mut temperature: ResMut<Temperature>| temperature.0 += 1.0;
    app.add_systems(AdvanceIncrement, warm.in_set(AdvanceSystems::End).before(StageSystems::Stop));
}

#[test]
fn state_of_a_plugin_resumes_with_it_and_is_refused_by_name_without() {
    let scene = parse(COULOMB).scene;
    let mut simulation = Simulation::in_app(clastic::run::app(heat), &scene, None);
    simulation.world_mut().insert_resource(Temperature(297.0));
    for _ in 0..3 {
        assert_eq!(simulation.step(), Step::Increment);
    }
    let state = simulation.state().unwrap();
    let error = Simulation::resume(&scene, &state).err().unwrap();
    assert_eq!(error, StateError::Unknown("heat.temperature".to_owned()));
    assert!(error.to_string().contains("`heat.temperature`"), "{error}");

    let mut resumed = Simulation::resume_in(clastic::run::app(heat), &scene, &state).unwrap();
    assert_eq!(resumed.world().resource::<Temperature>(), &Temperature(300.0));
    assert!(bytes(&resumed.state().unwrap()) == bytes(&state));
    assert_eq!(simulation.run(), resumed.run());
    assert!(bytes(&simulation.state().unwrap()) == bytes(&resumed.state().unwrap()));
}
