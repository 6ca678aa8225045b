//! A run that has ended is given more increments or more stages: what it leaves then is what a run
//! of the longer scene leaves, byte for byte.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clastic::output::{self, Checkpoint, OutputPlugin, directory};
use clastic::run::state::StateView;
use clastic::run::{Simulation, changes};
use clastic::scene::{self, LoadedScene};

use crate::common::files;
use crate::resumed::{COULOMB, finish, load, load_small_cell, parse, run};

/// Extends the run in a directory by the scene `text`, as the program does. Returns what is
/// refused.
fn extend(directory: &Path, text: &str) -> Vec<String> {
    let checkpoint = Checkpoint::read_as(directory, directory::FINAL_CHECKPOINT).unwrap();
    let particles = StateView::of(&checkpoint.world).unwrap().specimen;
    let read = |text: &str| {
        scene::from_str_with(text, Path::new("rig.ron"), particles.clone(), &[])
            .unwrap_or_else(|e| panic!("{e}"))
    };
    let (before, loaded) = (read(&checkpoint.scene).scene, read(text));
    let view = StateView::of(&checkpoint.world).unwrap();
    let refused = changes::refused(&before, &loaded.scene, &view);
    if !refused.is_empty() {
        return refused;
    }
    let mut simulation =
        Simulation::resume_in(clastic::run::app(OutputPlugin), &loaded.scene, &checkpoint.world)
            .unwrap();
    changes::apply(simulation.world_mut(), &before, &loaded.scene, &view);
    output::resume(simulation.world_mut(), directory, checkpoint, &loaded, &[], None).unwrap();
    finish(&mut simulation, &mut |_| {});
    Vec::new()
}

/// All files but those that say that a run was resumed.
fn results(directory: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = files(directory);
    assert!(all.remove(Path::new(directory::FINAL_CHECKPOINT)).is_some());
    let record = all.remove(Path::new(directory::RUN)).unwrap();
    let mut record: serde_json::Value = serde_json::from_slice(&record).unwrap();
    let record_of_all = record.as_object_mut().unwrap();
    record_of_all.remove("resumed");
    all.insert("run.json".into(), record.to_string().into_bytes());
    // The page has the record in it.
    if let Some(page) = all.remove(Path::new(directory::REPORT)) {
        all.insert(directory::REPORT.into(), page_without_resumed(page));
    }
    all
}

fn page_without_resumed(page: Vec<u8>) -> Vec<u8> {
    let page = String::from_utf8(page).unwrap();
    let (before, rest) = page.split_once("id=\"data\">").unwrap();
    let (data, after) = rest.split_once("</script>").unwrap();
    let mut data: serde_json::Value = serde_json::from_str(data).unwrap();
    data["runs"][0]["record"].as_object_mut().unwrap().remove("resumed");
    format!("{before}{data}{after}").into_bytes()
}

/// Runs `short` to its end, extends it to `long`, and compares with a run of `long`.
fn same_as_in_one_piece(short: &LoadedScene, long: &LoadedScene) {
    let parent = tempfile::tempdir().unwrap();
    let [extended, whole] = ["extended", "whole"].map(|name| parent.path().join(name));
    run(long, &whole, 0, |_| {});
    run(short, &extended, 0, |_| {});
    let rows = |at: &Path| fs::read_to_string(at.join(directory::HISTORY)).unwrap().lines().count();
    assert!(rows(&extended) < rows(&whole));
    assert_eq!(extend(&extended, &long.text), [""; 0]);
    let (found, expected) = (results(&extended), results(&whole));
    assert!(found.keys().eq(expected.keys()), "{:?}\n{:?}", found.keys(), expected.keys());
    for (name, bytes) in &expected {
        let (found, expected) = (&found[name], bytes);
        assert!(found == expected, "{} differs", name.display());
    }
    // Rows of the timings are kept as well.
    let timings =
        |at: &Path| fs::read_to_string(at.join(directory::TIMINGS)).unwrap().lines().count();
    assert_eq!(timings(&extended), timings(&whole));
}

#[test]
fn by_more_increments_of_the_last_stage() {
    let with = |increments: u32| {
        load(
            "biaxial_small",
            &[
                "stages.confine.increments=3",
                "stages.load.walls.top[1]=-0.16e-3",
                "output=(frames_every: 3, energy: true)",
                &format!("stages.load.increments={increments}"),
            ],
        )
    };
    same_as_in_one_piece(&with(4), &with(9));
}

/// The indices of a stored specimen are those of its file, also where particles were taken away.
#[test]
fn of_a_stored_specimen_from_which_particles_were_taken_away() {
    let with = |increments: u32| {
        let cut: Vec<u32> = (0..=300).collect();
        let stages = format!(
            r#"stages=[Remove(name: "cut", select: Index({cut:?})), Load(name: "load",
                increments: {increments}, particles: [(select: Index([399]), y: Displacement(1.0e-5))])]"#
        );
        load("biaxial_small", &[r#"probes={"last": 399}"#, &stages])
    };
    same_as_in_one_piece(&with(2), &with(4));
}

#[test]
fn by_more_increments_and_stages_of_a_dynamic_run() {
    let with = |increments: u32, more: &str| {
        let stages = format!(
            r#"stages=[Load(name: "fall", increments: {increments}, stop: [Rest(1.0e-9)]), {more}]"#
        );
        let sets = ["reference_stage=\"fall\"", &stages];
        load("bounce", &sets)
    };
    let more = r#"Save(name: "fallen"), Load(name: "heavy", increments: 9, gravity: (0.0, -20.0))"#;
    same_as_in_one_piece(&with(20, ""), &with(33, more));
}

#[test]
fn by_stages_under_coulombs_law() {
    let long = parse(COULOMB);
    let hold = long.text.find("        Load(name: \"hold\"").unwrap();
    let end = hold + long.text[hold..].find('\n').unwrap() + 1;
    let short = parse(&format!("{}{}", &long.text[..hold], &long.text[end..]));
    same_as_in_one_piece(&short, &long);
}

#[test]
fn what_would_not_be_a_run_in_one_piece_is_refused() {
    let parent = tempfile::tempdir().unwrap();
    let short = parse(COULOMB);
    run(&short, parent.path(), 0, |_| {});
    let refused = |from: &str, to: &str| {
        assert!(short.text.contains(from), "{from}");
        extend(parent.path(), &short.text.replace(from, to)).join("\n")
    };
    // The last stage keeps its loads, so that more increments change nothing before them.
    let said = refused("\"release\", increments: 4", "\"release\", increments: 5");
    assert!(said.contains("`stages.release` cannot change: it has ended"), "{said}");
    let said = refused("name: \"hold\", increments: 2", "name: \"hold\", increments: 1");
    assert!(said.contains("`stages.hold` cannot change"), "{said}");
    // Strains would count from another stage.
    let short = parse(&COULOMB.replace("reference_stage: \"compress\",", ""));
    let parent = tempfile::tempdir().unwrap();
    run(&short, parent.path(), 0, |_| {});
    let hold = "Load(name: \"hold\", increments: 2, add_walls: [\"left\"], gravity: (0.0, -9.81)),";
    let more = format!("{hold} Load(name: \"more\", increments: 1),");
    let text = short.text.replace(hold, &more);
    let said = extend(parent.path(), &text).join("\n");
    assert!(said.contains("name it in `reference_stage`"), "{said}");
    let text = text.replace("measures: [", "reference_stage: \"hold\", measures: [");
    assert_eq!(extend(parent.path(), &text), [""; 0]);
}

/// Strains and stresses of a cell are reached over the increments of their stage. With more of them
/// the increments before would have been others.
#[test]
fn a_cell_on_its_way_to_a_strain_takes_no_more_increments() {
    let short = load_small_cell(&["stages.shear.increments=3"]);
    let parent = tempfile::tempdir().unwrap();
    run(&short, parent.path(), 0, |_| {});
    let long =
        short.text.replace("name: \"shear\", increments: 3", "name: \"shear\", increments: 4");
    assert_ne!(short.text, long);
    let said = extend(parent.path(), &long).join("\n");
    assert!(said.contains("a load reaches its target at the end"), "{said}");
}

/// The state goes back before the stages without increments that ended the run. These are made anew:
/// the file of `Save` is that of a run in one piece.
#[test]
fn by_more_increments_of_a_stage_before_a_save() {
    let with = |increments: u32, more: &str| {
        let stages = format!(
            r#"stages=[Load(name: "fall", increments: {increments}), Save(name: "fallen"), {more}]"#
        );
        load("bounce", &["reference_stage=\"fall\"", &stages])
    };
    same_as_in_one_piece(&with(20, ""), &with(33, ""));
    let on = r#"Load(name: "heavy", increments: 9, gravity: (0.0, -20.0)), Save(name: "end")"#;
    same_as_in_one_piece(&with(20, ""), &with(20, on));
    same_as_in_one_piece(&with(20, ""), &with(33, on));

    let with = |increments: u32| {
        let load_set = format!("stages.load.increments={increments}");
        let mut loaded = load("biaxial_small", &["stages.confine.increments=2", &load_set]);
        let end = loaded.text.rfind("    measures:").unwrap();
        let close = loaded.text[..end].rfind("    ],").unwrap();
        loaded.text.insert_str(close, "        Save(name: \"sheared\"),\n");
        let name = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/rig.ron"));
        let directory = name.parent().unwrap();
        scene::from_str(&loaded.text, name, directory, &[]).unwrap_or_else(|e| panic!("{e}"))
    };
    same_as_in_one_piece(&with(3), &with(5));
}

/// A lid slides on: its motion, which ends with its stage, is in the state.
#[test]
fn by_more_increments_under_a_lid_that_slides() {
    let with = |increments: u32| {
        load(
            "shear_box",
            &[
                "specimen.count=100",
                &format!("stages.shear.increments={increments}"),
                "walls.lid.start=(0.204, 0.06)",
                "walls.lid.end=(0.0, 0.06)",
                "stages.compact.target=Porosity(0.25)",
                "stages.compact.step=4.0e-3",
                "walls.low_left.shape=Polyline([(0.0, 0.01)])",
                "walls.low_left.start=(-0.04, 0.01)",
                "walls.low_right.shape=Polyline([(0.204, 0.01)])",
                "walls.low_right.end=(0.244, 0.01)",
                "walls.high_left.shape=Polyline([(0.0, 0.01)])",
                "walls.high_left.end=(-0.04, 0.01)",
                "walls.high_right.shape=Polyline([(0.204, 0.01)])",
                "walls.high_right.start=(0.244, 0.01)",
            ],
        )
    };
    same_as_in_one_piece(&with(3), &with(6));
}

/// A table is followed over the increments of its stage: with more of them those before would have
/// been others.
#[test]
fn a_wall_that_follows_a_table_takes_no_more_increments() {
    let table = r#"stages.load.walls={ "top": Follow(Displacement([(0.0, 0.0, 0.0), (1.0, 0.0, -0.3e-3)])) }"#;
    let with = |increments: u32| {
        let load_set = format!("stages.load.increments={increments}");
        load("biaxial_small", &["stages.confine.increments=2", table, &load_set])
    };
    let (short, long) = (with(2), with(3));
    let parent = tempfile::tempdir().unwrap();
    run(&short, parent.path(), 0, |_| {});
    let said = extend(parent.path(), &long.text).join("\n");
    assert!(said.contains("a load reaches its target at the end"), "{said}");
}
