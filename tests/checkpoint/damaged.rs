//! Saved states of which an array is missing or wrong: refused, with the name of file and array.

use std::fs;
use std::path::Path;

use clastic::run::Simulation;
use clastic::saved::{self, SavedState};
use clastic::scene::{self, LoadedScene};
use clastic::tables::{Array, Data, Tables};

use crate::branched::{CELL, RIGID};
use crate::resumed::load;

fn parse(text: &str, stages: &str) -> LoadedScene {
    let sets = [format!("stages=[{stages}]")];
    scene::from_str(text, Path::new("rig.ron"), Path::new(""), &sets)
        .unwrap_or_else(|e| panic!("{e}"))
}

/// The state at the end of a run.
fn state(loaded: &LoadedScene) -> Tables {
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    simulation.run();
    saved::save(simulation.world_mut()).unwrap()
}

/// The tables without an array.
fn without(tables: &Tables, name: &str) -> Tables {
    let mut left = Tables::default();
    for (known, array) in tables.iter().filter(|(known, _)| *known != name) {
        left.put(known, array.clone());
    }
    left
}

fn with(tables: &Tables, name: &str, array: Array) -> Tables {
    let mut changed = tables.clone();
    changed.put(name, array);
    changed
}

/// Every array whose name begins with `prefix` must be there, and is refused with another shape,
/// with another type, and with a number that is not finite (unless the format allows it).
fn refuses_damage(sound: &Tables, prefix: &str, may_be_nan: &[&str]) {
    SavedState::read(sound).unwrap();
    let refused = |tables: &Tables, name: &str, what: &str| {
        let error = SavedState::read(tables).expect_err(&format!("{name}: {what}")).to_string();
        assert!(error.contains(&format!("`{name}`")), "{name}, {what}: {error}");
    };
    let arrays: Vec<(&str, &Array)> =
        sound.iter().filter(|(name, _)| name.starts_with(prefix)).collect();
    assert!(arrays.len() >= 6, "{prefix}: {}", arrays.len());
    for (name, array) in arrays {
        refused(&without(sound, name), name, "missing");
        let mut other = array.clone();
        other.shape.insert(0, 1);
        refused(&with(sound, name, other), name, "another shape");
        let mut other = array.clone();
        let n = other.shape.iter().product();
        other.data = match array.data {
            Data::F32(_) => Data::U8(vec![0; n]),
            _ => Data::F32(vec![0.0; n]),
        };
        refused(&with(sound, name, other), name, "another type");
        let mut other = array.clone();
        if let Data::F64(values) = &mut other.data
            && !values.is_empty()
            && !may_be_nan.contains(&name)
        {
            values[0] = f64::NAN;
            refused(&with(sound, name, other), name, "not a number");
        }
    }
}

#[test]
fn arrays_of_rigid_groups() {
    let stages = r#"Cement(name: "cement", length: 1.0e-4), Load(name: "press", increments: 2, rigid: {
        "lower": (select: Box(min: (-1.0, -1.0), max: (1.0, 0.02)), x: Held, rotation: Held),
        "upper": (select: Box(min: (-1.0, 0.07), max: (1.0, 1.0)), stress: (value: (0.0, -2.0e3), length: 0.1)) })"#;
    let sound = state(&parse(RIGID, stages));
    refuses_damage(&sound, "rigid.", &[]);
    refuses_damage(&sound, "energy.", &["energy.elastic_j", "energy.kinetic_j"]);
}

#[test]
fn arrays_of_membranes() {
    let sets = [
        "stages.confine.increments=2",
        "stages.load.increments=1",
        "output=(frames_every: 0, plots: false)",
    ];
    refuses_damage(
        &state(&load("biaxial_membrane_small", &sets)),
        "membranes.",
        &["membranes.ball_m"],
    );
}

#[test]
fn arrays_of_a_periodic_cell() {
    let stages = r#"Compact(name: "compact", target: Porosity(0.25), step: 4.0e-3, agitation: 0.1, seed: 11),
        Load(name: "confine", increments: 2, cell: (xx: Stress(50.0e3), yy: Stress(50.0e3)))"#;
    let sound = state(&parse(CELL, stages));
    refuses_damage(&sound, "cell.", &[]);
    let flat = with(&sound, "cell.size_m", Array::f64(vec![0.07, 0.0, 0.0]));
    let error = SavedState::read(&flat).unwrap_err().to_string();
    assert!(error.contains("`cell.size_m`: 0.07 by 0.0"), "{error}");
}

/// The message of a scene names the file, the array and what is wrong with it.
#[test]
fn a_scene_names_the_file_and_the_array() {
    let stages =
        r#"Load(name: "press", increments: 1, rigid: { "lower": (select: Index([0, 1])) })"#;
    let sound = state(&parse(RIGID, stages));
    let parent = tempfile::tempdir().unwrap();
    let file = parent.path().join("broken.npz");
    let sets = [
        "specimen=State(path: \"broken.npz\")".to_owned(),
        "walls=[]".to_owned(),
        "stages=[Load(name: \"on\", increments: 1)]".to_owned(),
    ];
    let scene = parent.path().join("on.ron");
    fs::write(&scene, RIGID).unwrap();
    fs::write(&file, sound.encode().unwrap()).unwrap();
    scene::load(&scene, &sets).unwrap_or_else(|e| panic!("{e}"));
    fs::write(&file, without(&sound, "rigid.load_to").encode().unwrap()).unwrap();
    let error = scene::load(&scene, &sets).unwrap_err().to_string();
    assert!(error.contains("broken.npz") && error.contains("no array `rigid.load_to`"), "{error}");
    fs::write(&file, without(&sound, "rigid.id").encode().unwrap()).unwrap();
    let error = scene::load(&scene, &sets).unwrap_err().to_string();
    assert!(error.contains("array `rigid.id`: missing beside `rigid.name`"), "{error}");
}
