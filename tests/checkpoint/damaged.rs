//! Saved states whose content is missing or wrong: refused, with the name of file and array.

use std::fs;
use std::path::Path;

use clastic::run::Simulation;
use clastic::saved::{self, SavedState};
use clastic::scene;
use clastic::tables::{Array, Tables};

use crate::branched::RIGID;

/// The message of a scene names the file, the array and what is wrong with it.
#[test]
fn a_scene_names_the_file_and_the_array() {
    let stages = [r#"stages=[Load(name: "press", increments: 1,
        rigid: { "lower": (select: Index([0, 1])) })]"#
        .to_owned()];
    let loaded = scene::from_str(RIGID, Path::new("rig.ron"), Path::new(""), &stages);
    let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
    simulation.run();
    let sound = saved::save(simulation.world_mut()).unwrap();
    let state = sound.values::<u8>("state", &[sound.rows("state").unwrap()]).unwrap();
    let with = |array: Array| {
        let mut changed = sound.clone();
        changed.put("state", array);
        changed
    };
    let mut without = Tables::default();
    for (name, array) in sound.iter().filter(|(name, _)| *name != "state") {
        without.put(name, array.clone());
    }

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
    for (tables, what) in [
        (without, "no array `state`"),
        (with(Array::column([0.0])), "array `state`: type `float64`"),
        (with(Array::column(state[..state.len() - 1].to_vec())), "array `state`: "),
    ] {
        assert!(SavedState::read(&tables).is_err(), "{what}");
        fs::write(&file, tables.encode().unwrap()).unwrap();
        let error = scene::load(&scene, &sets).unwrap_err().to_string();
        assert!(error.contains("broken.npz") && error.contains(what), "{error}");
    }
}
