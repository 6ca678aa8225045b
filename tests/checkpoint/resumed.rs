//! Runs, resumed as the program does it, and compared.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clastic::components::observation::Observation;
use clastic::output::{self, Checkpoint, OutputPlugin, RunDirectory, RunOptions, directory};
use clastic::run::state::StateView;
use clastic::run::{Outcome, Simulation, Step, WorldState, changes};
use clastic::scene::{self, LoadedScene};

use crate::common::files;

/// A scene of `scenes/` under settings.
pub fn load(name: &str, sets: &[&str]) -> LoadedScene {
    let path = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
    let sets: Vec<_> = sets.iter().map(|set| (*set).to_owned()).collect();
    scene::load(Path::new(&path), &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// `simple_shear_periodic` with 64 disks, under settings.
pub fn load_small_cell(sets: &[&str]) -> LoadedScene {
    let small = [
        "specimen.count=64",
        "specimen.columns=8",
        "cell.size=(0.0808, 0.0808)",
        "stages.compact.step=4.0e-3",
        "stages.confine.increments=2",
    ];
    load("simple_shear_periodic", &[&small, sets].concat())
}

/// A scene from its text.
pub fn parse(text: &str) -> LoadedScene {
    scene::from_str(text, Path::new("rig.ron"), Path::new(""), &[])
        .unwrap_or_else(|e| panic!("{e}"))
}

/// Runs a scene into a directory; `after` sees every increment once it is written.
pub fn run(
    loaded: &LoadedScene,
    directory: &Path,
    every: u32,
    mut after: impl FnMut(&Observation),
) -> (Outcome, WorldState) {
    let mut simulation = Simulation::in_app(
        clastic::run::app(OutputPlugin),
        &loaded.scene,
        loaded.specimen.as_ref(),
    );
    let options = RunOptions {
        directory: directory.to_owned(),
        dump_programs: vec![2, 5],
        checkpoint_every: every,
        ..Default::default()
    };
    output::begin(simulation.world_mut(), options, loaded).unwrap();
    finish(&mut simulation, &mut after)
}

pub fn finish(
    simulation: &mut Simulation,
    after: &mut dyn FnMut(&Observation),
) -> (Outcome, WorldState) {
    let outcome = loop {
        if let Step::Finished(outcome) = simulation.step() {
            break outcome;
        }
        after(simulation.world().resource::<Observation>());
    };
    output::finish(simulation.world_mut(), Some(&outcome)).unwrap();
    simulation.world_mut().remove_resource::<RunDirectory>();
    (outcome, simulation.state().unwrap())
}

/// Resumes a directory as the program does.
pub fn resume(directory: &Path, sets: &[&str]) -> (Outcome, WorldState) {
    let checkpoint = Checkpoint::read(directory).unwrap();
    let sets: Vec<_> = sets.iter().map(|set| (*set).to_owned()).collect();
    let name = Path::new(&checkpoint.facts.scene_file);
    let state = &checkpoint.world;
    let view = StateView::of(state).unwrap();
    let read = |sets: &[String]| {
        scene::from_str_with(&checkpoint.scene, name, view.specimen.clone(), sets)
    };
    let (before, loaded) = (read(&[]).unwrap().scene, read(&sets).unwrap());
    assert_eq!(changes::refused(&before, &loaded.scene, &view), [""; 0]);
    let mut simulation =
        Simulation::resume_in(clastic::run::app(OutputPlugin), &loaded.scene, state).unwrap();
    // What was restored is what was stored, to the bit.
    assert!(bytes(&simulation.state().unwrap()) == bytes(state));
    changes::apply(simulation.world_mut(), &before, &loaded.scene, &view);
    output::resume(simulation.world_mut(), directory, checkpoint, &loaded, &sets, None).unwrap();
    finish(&mut simulation, &mut |_| {})
}

/// A state as bytes: not-a-number is equal to itself, and 0 is not -0.
pub fn bytes(state: &WorldState) -> Vec<u8> {
    postcard::to_stdvec(state).unwrap()
}

pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, target).unwrap();
        }
    }
}

pub fn assert_same_files(found: &Path, expected: &BTreeMap<PathBuf, Vec<u8>>, what: &str) {
    let found = files(found);
    assert!(found.keys().eq(expected.keys()), "{what}: {:?}\n{:?}", found.keys(), expected.keys());
    for (name, bytes) in expected {
        assert!(*bytes == found[name], "{what}: {} differs", name.display());
    }
}

/// Runs a scene undisturbed, and resumes it from its checkpoint after every increment that `stops`
/// names: in the directory as it was then, or, after every other one, in that of the finished run,
/// which holds rows, frames and pictures from later on. Returns the records of all increments.
pub fn same_from_anywhere(loaded: &LoadedScene, stops: impl Fn(u64) -> bool) -> Vec<Observation> {
    let parent = tempfile::tempdir().unwrap();
    let (plain, saved) = (parent.path().join("plain"), parent.path().join("saved"));
    let mut records = Vec::new();
    let (outcome, last) = run(loaded, &plain, 0, |o| records.push(o.clone()));
    let expected = files(&plain);

    let mut stopped = vec![0];
    copy_first(loaded, &parent.path().join("0"));
    let again = run(loaded, &saved, 1, |o| {
        if stops(o.increment) {
            copy(&saved, &parent.path().join(o.increment.to_string()));
            stopped.push(o.increment);
        }
    });
    assert_eq!(again.0, outcome);
    assert_same_files(&saved, &expected, "with checkpoints");

    for increment in stopped {
        let what = format!("resumed after increment {increment} of {}", records.len());
        let mut there = parent.path().join(increment.to_string());
        if increment % 2 == 0 {
            let late = parent.path().join(format!("late_{increment}"));
            copy(&saved, &late);
            fs::copy(there.join(directory::CHECKPOINT), late.join(directory::CHECKPOINT)).unwrap();
            there = late;
        }
        let (ended, state) = resume(&there, &[]);
        assert_eq!(ended, outcome, "{what}");
        assert!(bytes(&state) == bytes(&last), "{what}: another state");
        assert_same_files(&there, &expected, &what);
    }
    records
}

/// The directory of a run before its first increment.
pub fn copy_first(loaded: &LoadedScene, directory: &Path) {
    let mut simulation = Simulation::in_app(
        clastic::run::app(OutputPlugin),
        &loaded.scene,
        loaded.specimen.as_ref(),
    );
    let options = RunOptions {
        directory: directory.to_owned(),
        dump_programs: vec![2, 5],
        checkpoint_every: 1,
        ..Default::default()
    };
    output::begin(simulation.world_mut(), options, loaded).unwrap();
}

/// [`COULOMB`] with rolling moments that are elastic between grains and at the top and the bottom.
pub fn rolling_elastically() -> String {
    COULOMB
        .replace("rolling_friction: 0.05", "rolling_friction: 0.05, rolling_stiffness: 480.0")
        .replace(
            "friction: 0.3)),",
            "friction: 0.3, rolling_friction: 0.1, rolling_stiffness: 250.0)),",
        )
}

/// A bonded lattice under Coulomb's law, whose bonds break; walls come, go and are driven by force.
pub const COULOMB: &str = r#"(
    version: 1,
    title: "lattice",
    friction_law: Coulomb(),
    rupture: (rolling: Yields, order: OneRound),
    materials: { "stone": (
        contact: (normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.3, rolling_friction: 0.05),
        bond: (normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.5, rolling_friction: 0.05,
            cohesion: 20.0e3, tensile_strength: 20.0e3),
    ) },
    specimen: Lattice(columns: 6, rows: 7, radius: 5.0e-3, origin: (5.0e-3, 5.0e-3)),
    walls: [
        (name: "bottom", start: (0.0, 0.0), end: (60.0e-3, 0.0),
            contact: (normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.3)),
        (name: "left", start: (0.0, 70.0e-3), end: (0.0, 0.0), contact: (normal_stiffness: 6.0e7)),
        (name: "right", start: (60.0e-3, 0.0), end: (60.0e-3, 70.0e-3), contact: (normal_stiffness: 6.0e7)),
        (name: "top", start: (60.0e-3, 61.96e-3), end: (0.0, 61.96e-3), probe: "top",
            contact: (normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.3)),
    ],
    stages: [
        Cement(name: "cement", length: 0.1e-3),
        Load(name: "confine", increments: 3, walls: {
            "top": Stress(stress: 20.0e3, between: ("left", "right")),
            "left": Stress(stress: 20.0e3, between: ("bottom", "top")),
            "right": Stress(stress: 20.0e3, between: ("bottom", "top")),
        }),
        Load(name: "compress", increments: 14, walls: { "top": Displacement(0.0, -30.0e-6) }),
        Load(name: "release", increments: 4, remove_walls: ["left"], walls: { "top": Force(500.0) }),
        Load(name: "hold", increments: 2, add_walls: ["left"], gravity: (0.0, -9.81)),
    ],
    reference_stage: "compress",
    measures: [
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "lateral_strain", of: Strain(Particles(0, 5))),
        (name: "axial_stress", of: Stress(Average(component: Yy, area: Fixed(3.6e-3)))),
    ],
)"#;
