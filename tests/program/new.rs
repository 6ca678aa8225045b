//! `clastic new`: every rig is sound and runs.

use std::fs;

use crate::call::{clastic, stderr, stdout};

/// Names of the rigs, with settings that shorten their last stages.
const RIGS: [(&str, &[&str]); 5] = [
    ("biaxial", &["stages.load.increments=3"]),
    ("column_collapse", &["stages.settle.increments=5", "stages.release.increments=3"]),
    ("direct_tension", &["stages.load.increments=3"]),
    ("hopper", &["stages.settle.increments=5", "stages.flow.increments=3"]),
    ("uniaxial", &["stages.load.increments=3"]),
];

#[test]
fn every_rig_is_listed_sound_and_runs() {
    let list = stdout(&clastic(&["new"]).code(0));
    assert_eq!(list.lines().count(), 2 + RIGS.len(), "{list}");
    let folder = tempfile::tempdir().unwrap();
    for (rig, sets) in RIGS {
        assert!(list.contains(&format!("  {rig} ")), "{list}");
        let text = stdout(&clastic(&["new", rig]).code(0));
        assert!(text.contains("version: 1,"), "{rig}");
        let path = folder.path().join(format!("{rig}.ron"));
        fs::write(&path, text).unwrap();
        let path = path.to_str().unwrap();
        clastic(&["check", path]).code(0);
        let out = folder.path().join(rig);
        let mut arguments = vec!["run", path, "--quiet", "--out", out.to_str().unwrap()];
        for set in sets {
            arguments.extend(["--set", set]);
        }
        clastic(&arguments).code(0);
    }
}

#[test]
fn an_unknown_rig_is_refused_with_the_nearest_name() {
    let said = stderr(&clastic(&["new", "biaxail"]).code(2));
    assert!(said.contains("did you mean `biaxial`?"), "{said}");
}

/// `clastic new footing` was "no rig".
#[test]
fn a_scene_that_ships_is_printed_as_it_is() {
    for name in ["footing", "slope_block"] {
        let done = clastic(&["new", name]).code(0);
        let path = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
        assert_eq!(stdout(&done).trim_end(), fs::read_to_string(path).unwrap().trim_end());
        // Its specimen is no part of the text.
        assert_eq!(stderr(&done).contains("slope_ground.npz"), name == "slope_block");
    }
    let said = stderr(&clastic(&["new", "footin"]).code(2));
    assert!(said.contains("did you mean `footing`?"), "{said}");
}
