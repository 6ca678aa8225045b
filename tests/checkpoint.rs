//! Checkpoint and resume: a run that stops after any increment and goes on from its checkpoint leaves
//! the same bytes as one that did not.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;
use clastic::output::{Checkpoint, Ending, ResumeError, RunOptions, RunWriter, directory};
use clastic::run::{Outcome, Simulation, Step, WorldState, changes};
use clastic::scene::{self, LoadedScene};
use common::files;

/// A scene of `scenes/` under settings.
fn load(name: &str, sets: &[&str]) -> LoadedScene {
    let path = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
    let sets: Vec<_> = sets.iter().map(|set| (*set).to_owned()).collect();
    scene::load(Path::new(&path), &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// A scene from its text.
fn parse(text: &str) -> LoadedScene {
    scene::from_str(text, Path::new("rig.ron"), Path::new(""), &[])
        .unwrap_or_else(|e| panic!("{e}"))
}

/// Runs a scene into a directory; `after` sees every increment once it is written.
fn run(
    loaded: &LoadedScene,
    directory: &Path,
    every: u32,
    mut after: impl FnMut(&Observation),
) -> (Outcome, WorldState) {
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let options = RunOptions {
        directory: directory.to_owned(),
        dump_programs: vec![2, 5],
        checkpoint_every: every,
        ..Default::default()
    };
    let mut writer = RunWriter::create(options, loaded, simulation.world_mut()).unwrap();
    finish(&mut simulation, &mut writer, &mut after)
}

fn finish(
    simulation: &mut Simulation,
    writer: &mut RunWriter,
    after: &mut dyn FnMut(&Observation),
) -> (Outcome, WorldState) {
    let outcome = loop {
        match simulation.step() {
            Step::Finished(outcome) => break outcome,
            Step::Increment => writer.record(simulation.world_mut()).unwrap(),
        }
        after(simulation.world().resource::<Observation>());
    };
    writer.finish(simulation.world_mut(), &Ending::Finished(outcome.clone())).unwrap();
    (outcome, WorldState::capture(simulation.world_mut()))
}

/// Resumes a directory as the program does.
fn resume(directory: &Path, sets: &[&str]) -> (Outcome, WorldState) {
    let checkpoint = Checkpoint::read(directory).unwrap();
    let sets: Vec<_> = sets.iter().map(|set| (*set).to_owned()).collect();
    let name = Path::new(&checkpoint.facts.scene_file);
    let state = &checkpoint.world;
    let read =
        |sets: &[String]| scene::from_str_with(&checkpoint.scene, name, state.specimen(), sets);
    let (before, loaded) = (read(&[]).unwrap().scene, read(&sets).unwrap());
    assert_eq!(changes::refused(&before, &loaded.scene, state), [""; 0]);
    let mut simulation = Simulation::resume(&loaded.scene, state);
    // What was restored is what was stored, to the bit.
    assert!(bytes(&WorldState::capture(simulation.world_mut())) == bytes(state));
    changes::apply(simulation.world_mut(), &before, &loaded.scene, state);
    let mut writer = RunWriter::resume(directory, checkpoint, &loaded, &sets, None).unwrap();
    finish(&mut simulation, &mut writer, &mut |_| {})
}

/// A state as bytes: not-a-number is equal to itself, and 0 is not -0.
fn bytes(state: &WorldState) -> Vec<u8> {
    postcard::to_stdvec(state).unwrap()
}

fn copy(from: &Path, to: &Path) {
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

fn assert_same_files(found: &Path, expected: &BTreeMap<PathBuf, Vec<u8>>, what: &str) {
    let found = files(found);
    assert!(found.keys().eq(expected.keys()), "{what}: {:?}\n{:?}", found.keys(), expected.keys());
    for (name, bytes) in expected {
        assert!(*bytes == found[name], "{what}: {} differs", name.display());
    }
}

/// Runs a scene undisturbed, and resumes it from its checkpoint after every increment that `stops`
/// names: in the directory as it was then, or, after every other one, in that of the finished run,
/// which holds rows, frames and pictures from later on. Returns the records of all increments.
fn same_from_anywhere(loaded: &LoadedScene, stops: impl Fn(u64) -> bool) -> Vec<Observation> {
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
fn copy_first(loaded: &LoadedScene, directory: &Path) {
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    let options = RunOptions {
        directory: directory.to_owned(),
        dump_programs: vec![2, 5],
        checkpoint_every: 1,
        ..Default::default()
    };
    RunWriter::create(options, loaded, simulation.world_mut()).unwrap();
}

#[test]
fn biaxial_test_after_every_increment() {
    let loaded = load(
        "biaxial_small",
        &[
            "stages.confine.increments=3",
            "stages.load.increments=7",
            "stages.load.walls.top[1]=-0.16e-3",
            "output=(frames_every: 3)",
        ],
    );
    let records = same_from_anywhere(&loaded, |_| true);
    assert_eq!(records.len(), 10);
    assert!(records.iter().any(|o| !o.ruptures.is_empty()), "no bond broke");
}

/// A run that is interrupted within an avalanche has its bonds, its row of the avalanche and its way through it still
/// to come.
#[test]
fn from_event_to_event_and_within_avalanches() {
    let loaded = load(
        "biaxial_small",
        &[
            "rupture.order=Events",
            "rupture.group=0.003",
            "stages.confine.increments=2",
            "stages.load.increments=3",
            "stages.load.walls.top[1]=-0.45e-3",
        ],
    );
    let stops = |increment: u64| increment % 3 == 1;
    let records = same_from_anywhere(&loaded, stops);
    // With the first of them behind it and the next one to come.
    let within = records.iter().filter(|o| stops(o.increment) && o.in_avalanche).count();
    assert!(within >= 2, "stopped {within} times within an avalanche, of {}", records.len());
}

/// A motion that a rupture releases begins with the state that was committed before it.
#[test]
fn before_motions_that_ruptures_release() {
    let sets = [
        "rupture=(order: Events, avalanche: Dynamic)",
        "specimen.count=72",
        "stages.compact.target=Porosity(0.25)",
        "stages.compact.step=2.5e-3",
        "stages.load.increments=6",
        "stages.load.walls.top[1]=-8.0e-6",
    ];
    let loaded = load("uniaxial_small", &sets);
    let mut motions = Vec::new();
    run(&loaded, &tempfile::tempdir().unwrap().path().join("first"), 0, |o| {
        if o.fraction == 0.0 && o.motion_steps > 0 {
            motions.push(o.increment);
        }
    });
    assert!(motions.len() >= 2, "{motions:?}");
    let records = same_from_anywhere(&loaded, |k| motions.contains(&(k + 1)));
    let is_released = |o: &&Observation| motions.contains(&o.increment);
    let broken = records.iter().filter(is_released).map(|o| o.ruptures.len()).sum::<usize>();
    assert!(broken > 0, "no bond broke within a motion");
}

#[test]
fn biaxial_test_whose_motion_is_followed_and_whose_increments_are_halved() {
    // A limit of throw that grains meet all the time.
    let sets = [
        "acceptance.throw=0.01",
        "stages.confine.increments=2",
        "stages.load.increments=11",
        "stages.load.walls.top[1]=-0.2e-3",
    ];
    let loaded = load("biaxial_small", &sets);
    let records = same_from_anywhere(&loaded, |k| [7, 8, 12, 13].contains(&k));
    assert!(records.iter().any(|o| o.motion_steps > 0), "no motion was followed");
    assert!(records.iter().any(|o| o.fraction < 1.0), "nothing was halved");
}

#[test]
fn compaction_cementing_and_walls_taken_away() {
    // The left wall stays: the identity of the one that goes is not the last.
    let sets = [
        "stages.compact.step=2.5e-3",
        "stages.load.increments=8",
        "stages.load.remove_walls=[\"left\"]",
        "stages.load.walls.top[1]=-14.0e-6",
        "output=(frames_every: 5)",
    ];
    let loaded = load("uniaxial_small", &sets);
    let records = same_from_anywhere(&loaded, |k| k % 4 == 1 || k == 22);
    let stages: Vec<_> = records.iter().map(|o| o.stage.as_str()).collect();
    assert!(stages.contains(&"compact") && stages.contains(&"load"), "{stages:?}");
    assert!(records.iter().any(|o| !o.ruptures.is_empty()), "no bond broke");
}

#[test]
fn dynamic_collapse_of_a_column() {
    let sets = [
        "specimen.count=60",
        "specimen.columns=5",
        "stages.compact.target=Porosity(0.35)",
        "walls.floor.end=(70.0e-3, 0.0)",
        "walls.back.start=(0.0, 0.2)",
        "walls.gate.start=(70.0e-3, 0.0)",
        "walls.gate.end=(70.0e-3, 0.2)",
        "walls.lid.start=(70.0e-3, 0.16)",
        "walls.lid.end=(0.0, 0.16)",
        "stages.settle.increments=10",
        "stages.release.increments=40",
        "output=(frames_every: 10)",
    ];
    let loaded = load("column_collapse_small", &sets);
    let records = same_from_anywhere(&loaded, |k| k % 3 == 0);
    assert!(records.iter().any(|o| o.kinetic_energy > 0.0));
}

#[test]
fn bounce_direct_shear_and_clarabel() {
    let bounce = load("bounce", &["stages.drop.increments=60"]);
    same_from_anywhere(&bounce, |k| k % 7 == 0);
    // Loads of particles that are on their way; the bond breaks.
    let shear = load("direct_shear_10N", &[]);
    let records = same_from_anywhere(&shear, |k| k % 35 == 1);
    assert!(records.iter().any(|o| !o.ruptures.is_empty()), "the bond did not break");
    let clarabel = load("tension", &["solver=Clarabel()"]);
    same_from_anywhere(&clarabel, |k| k % 7 == 0);
}

#[test]
fn rebounds_go_on() {
    let sets = [
        "materials.stone.contact=(restitution: 0.6)",
        "walls.floor.contact=(restitution: 0.6)",
        "analysis.theta=0.5",
        "stages.drop.increments=130",
        "output=(energy: true)",
    ];
    let records = same_from_anywhere(&load("bounce", &sets), |k| k == 40 || (99..104).contains(&k));
    let energies: Vec<f64> = records.iter().map(|o| o.kinetic_energy).collect();
    assert!(energies.windows(2).any(|pair| pair[1] < 0.5 * pair[0]), "no impact");
}

#[test]
fn the_ledger_and_the_corrector_go_on() {
    let sets = ["output=(energy: true)", "corrector=(passes: 20)", "stages.drop.increments=40"];
    same_from_anywhere(&load("bounce", &sets), |k| k % 6 == 1);
    let sets = [
        "output=(energy: true)",
        "corrector=(passes: 20)",
        "stages.confine.increments=2",
        "stages.load.increments=5",
        "stages.load.walls.top[1]=-0.16e-3",
    ];
    let records = same_from_anywhere(&load("biaxial_small", &sets), |k| k % 2 == 1);
    assert!(records.iter().any(|o| o.solves > 1), "nothing was corrected");
}

/// A bond breaks under the 25th newton and nothing holds the rest; a stage follows.
const COLLAPSE: &str = r#"(
    version: 1,
    title: "two disks torn apart",
    materials: { "stone": (
        contact: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6),
        bond: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6, cohesion: 4.0e3, tensile_strength: 2.0e3),
    ) },
    specimen: Particles([
        (position: (0.0, 0.0), radius: 6.0e-3),
        (position: (12.0e-3, 0.0), radius: 6.0e-3, probe: "pulled"),
    ]),
    bonds: [(a: 0, b: 1)],
    stages: [
        Load(name: "pull", increments: 35, particles: [
            (select: Index([0]), x: Held, y: Held, rotation: Held),
            (select: Index([1]), y: Held, rotation: Held, force: (35.0, 0.0)),
        ]),
        Load(name: "hold", increments: 5, particles: [(select: All, x: Held, y: Held, rotation: Held)]),
    ],
)"#;

#[test]
fn the_mechanism_of_a_collapse_is_of_whoever_sees_it() {
    // Before the collapse, at it and after it; every other time in a directory that has it already.
    let records = same_from_anywhere(&parse(COLLAPSE), |k| [7, 8, 25, 26, 27].contains(&k));
    let collapsed = |o: &&Observation| o.status == IncrementStatus::Collapsed;
    let increments: Vec<_> = records.iter().filter(collapsed).map(|o| o.increment).collect();
    assert_eq!(increments, [25]);
    let parent = tempfile::tempdir().unwrap();
    run(&parse(COLLAPSE), parent.path(), 0, |_| {});
    assert!(parent.path().join(directory::MECHANISM).exists());
}

/// A bonded lattice under Coulomb's law, with a cascade; walls come, go and are driven by force.
const COULOMB: &str = r#"(
    version: 1,
    title: "lattice",
    friction_law: Coulomb(),
    rupture: (rolling: Yields, order: AllAtOnce, rounds: 50),
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
    measures: (
        reference_stage: "compress",
        axial_strain: Walls("bottom", "top"),
        lateral_strain: Particles(0, 5),
        axial_stress: Average(component: Yy, area: Fixed(3.6e-3)),
    ),
)"#;

#[test]
fn coulomb_cascade_and_walls_that_come_and_go() {
    let records = same_from_anywhere(&parse(COULOMB), |_| true);
    assert!(records.iter().any(|o| !o.ruptures.is_empty()), "no bond broke");
    assert!(records.iter().any(|o| o.coulomb_residual > 0.0), "Coulomb's law made no difference");
    assert!(records.iter().any(|o| o.stage == "hold"), "{:?}", records.last());
}

#[test]
fn an_undecided_run_goes_on_with_other_settings() {
    // Grains move further than is accepted here, and walls at rest do not move them.
    let sets = [
        "acceptance.throw=0.005",
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
    assert_eq!(checkpoint.world.progress.increment + 1, failed.increment);
    assert_eq!(checkpoint.world.observation, records[records.len() - 2]);

    // With the same settings it fails in the same way and leaves the same bytes.
    let expected = files(&stalled);
    copy(&stalled, &again);
    assert_eq!(resume(&again, &[]).0, outcome);
    assert_same_files(&again, &expected, "resumed as it was");

    // With others it goes on to the end. The failed row is gone and the record says what happened.
    let (outcome, state) = resume(&stalled, &["acceptance.throw=0.3"]);
    assert_eq!(outcome, Outcome::Completed);
    assert!(state.observation.increment >= failed.increment);
    let history = fs::read_to_string(stalled.join(directory::HISTORY)).unwrap();
    assert!(!history.contains("undecided"));
    assert_eq!(history.lines().count() as u64, 1 + state.observation.increment);
    let record = fs::read_to_string(stalled.join(directory::RUN)).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    assert_eq!(record["resumed"][0]["after_increment"], failed.increment - 1);
    assert_eq!(record["resumed"][0]["settings"][0], "acceptance.throw=0.3");
    assert_eq!(record["settings"]["acceptance"]["throw"], 0.3);
    assert_eq!(record["increments"], state.observation.increment);
    let scene = fs::read_to_string(stalled.join(directory::SCENE)).unwrap();
    assert!(scene.contains("throw: 0.3"), "{scene}");
}

/// The state of [`COULOMB`] after some increments, and its scene.
fn state_after(increments: u64) -> (LoadedScene, WorldState) {
    let loaded = parse(COULOMB);
    let mut simulation = Simulation::new(&loaded.scene, None);
    for _ in 0..increments {
        assert_eq!(simulation.step(), Step::Increment);
    }
    (loaded, WorldState::capture(simulation.world_mut()))
}

#[test]
fn what_may_change_depends_on_how_far_the_run_has_come() {
    let (old, state) = state_after(5);
    assert_eq!(state.progress.stage_name, "compress");
    let refused = |set: &str| {
        let new = scene::from_str_with(
            COULOMB,
            Path::new("rig.ron"),
            state.specimen(),
            &[set.to_owned()],
        );
        changes::refused(&old.scene, &new.unwrap_or_else(|e| panic!("{e}")).scene, &state)
            .join("\n")
    };
    for free in [
        "acceptance.throw=0.5",
        "solver=Clarabel()",
        "friction_law=Associated",
        "rupture.order=AllAtOnce",
        "rupture.rounds=3",
        "output.frames_every=2",
        "stages.release.increments=7",
        "stages.hold.gravity=(0.0, 0.0)",
        "stages.compress.stop=[AxialStrain(0.01)]",
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
        ("measures.reference_stage=\"release\"", "measures"),
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
        state.specimen(),
        &["stages.confine.increments=6".to_owned()],
    );
    let said = changes::refused(&old.scene, &new.unwrap().scene, &state).join("\n");
    assert!(said.contains("`stages.confine` cannot change") && said.contains("target"), "{said}");
}

#[test]
fn a_stage_under_way_goes_on_longer_and_slower() {
    let loaded = parse(COULOMB);
    let parent = tempfile::tempdir().unwrap();
    let mut simulation = Simulation::new(&loaded.scene, None);
    let options = RunOptions { directory: parent.path().to_owned(), ..Default::default() };
    let mut writer = RunWriter::create(options, &loaded, simulation.world_mut()).unwrap();
    for _ in 0..5 {
        simulation.step();
        writer.record(simulation.world_mut()).unwrap();
    }
    writer.finish(simulation.world_mut(), &Ending::Interrupted).unwrap();
    drop(writer);
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

/// A directory with a checkpoint, and the error of reading it after a change.
fn refusal(change: impl Fn(&Path)) -> String {
    let parent = tempfile::tempdir().unwrap();
    let directory = parent.path().join("run");
    copy_first(&parse(COULOMB), &directory);
    assert!(Checkpoint::read(&directory).is_ok());
    change(&directory);
    let read = Checkpoint::read(&directory).map(|_| ());
    let message = read.err().map(|e: ResumeError| e.to_string()).unwrap_or_default();
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
        RunWriter::resume(dir, checkpoint, &loaded, &[], None)
            .map(|_| ())
            .map_err(|e| e.to_string())
    };
    let mut simulation = Simulation::new(&loaded.scene, None);
    let options =
        RunOptions { directory: dir.to_owned(), checkpoint_every: 2, ..Default::default() };
    let mut writer = RunWriter::create(options, &loaded, simulation.world_mut()).unwrap();
    for _ in 0..3 {
        simulation.step();
        writer.record(simulation.world_mut()).unwrap();
    }
    assert!(try_resume().is_err_and(|e| e.contains("still writing")));
    drop(writer);
    let history = dir.join(directory::HISTORY);
    let whole = fs::read(&history).unwrap();
    // Half of the row that came after the checkpoint is no harm ...
    fs::write(&history, &whole[..whole.len() - 20]).unwrap();
    assert_eq!(try_resume(), Ok(()));
    assert_eq!(fs::read_to_string(&history).unwrap().lines().count(), 3);
    // ... half of one that the checkpoint counts on is.
    edit(&history, |bytes| bytes.truncate(bytes.len() - 20));
    assert!(try_resume().is_err_and(|e| e.contains("history.csv") && e.contains("bytes")));
    edit(&history, |bytes| bytes.extend([b'x'; 20]));
    assert!(try_resume().is_err_and(|e| e.contains("other rows")));
}

/// A checkpoint of this version of the format, as some earlier program wrote it.
fn stored() -> PathBuf {
    let name = format!("tests/data/checkpoint_{}.bin", clastic::output::checkpoint::VERSION);
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Writes it, once for every new version of the format: `CLASTIC_STORE_CHECKPOINT=1 cargo test
/// --release --test checkpoint -- --ignored`. Not by a bare `--ignored`, which only runs what is long.
#[test]
#[ignore = "writes the stored checkpoint, with CLASTIC_STORE_CHECKPOINT=1"]
fn write_the_stored_checkpoint() {
    if std::env::var_os("CLASTIC_STORE_CHECKPOINT").is_none() {
        eprintln!("skipped: CLASTIC_STORE_CHECKPOINT is not set");
        return;
    }
    assert!(!stored().exists(), "{} is there: raise the version", stored().display());
    let parent = tempfile::tempdir().unwrap();
    run(&parse(COULOMB), parent.path(), 1, |o| {
        if o.increment == 15 {
            fs::copy(parent.path().join(directory::CHECKPOINT), stored()).unwrap();
        }
    });
}

/// Fails when what a checkpoint holds has changed without a new version: then raise
/// `checkpoint::VERSION`, run the test above as it says, and remove the file of the version before.
#[test]
fn the_format_is_that_of_its_version() {
    let parent = tempfile::tempdir().unwrap();
    fs::copy(stored(), parent.path().join(directory::CHECKPOINT)).unwrap();
    fs::write(parent.path().join(directory::SCENE), COULOMB).unwrap();
    let checkpoint = Checkpoint::read(parent.path()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(checkpoint.world.progress.increment, 15);
    assert!(checkpoint.world.ruptures.0.iter().sum::<usize>() > 0);
    // Written again it is the same: nothing of it was left out or read as something else.
    checkpoint.write(parent.path()).unwrap();
    let again = fs::read(parent.path().join(directory::CHECKPOINT)).unwrap();
    assert!(again == fs::read(stored()).unwrap());
}
