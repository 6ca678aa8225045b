//! A catalogue of bad scenes, `tests/bad_scenes/NAME.ron`, and the messages about each, word for
//! word, in `NAME.txt` beside it. `clastic check` reads the files, and a review of a changed
//! message shows the text that a user would read.
//!
//! To accept new messages after reading them: `CLASTIC_BLESS=1 cargo test --release --test
//! program bad_scenes`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use clastic::scene::{LoadError, SceneErrors, load};

use crate::call::PROGRAM;

/// Tests run in the directory of the package.
const FOLDER: &str = "tests/bad_scenes";

fn scenes() -> Vec<PathBuf> {
    let mut found: Vec<_> = fs::read_dir(FOLDER)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "ron"))
        .collect();
    found.sort();
    found
}

fn errors(path: &Path) -> SceneErrors {
    match load(path, &[]) {
        Err(LoadError::Scene(errors)) => errors,
        Err(other) => panic!("{}: {other}", path.display()),
        Ok(_) => panic!("{} is accepted", path.display()),
    }
}

#[test]
fn every_bad_scene_is_refused_with_the_words_beside_it() {
    let bless = std::env::var_os("CLASTIC_BLESS").is_some();
    let mut differences = String::new();
    let scenes = scenes();
    assert!(scenes.len() >= 100, "{} scenes", scenes.len());
    for path in scenes {
        let said = format!("{}\n", errors(&path)).replace(&format!("{FOLDER}/"), "");
        let words = path.with_extension("txt");
        if bless {
            fs::write(&words, &said).unwrap();
        }
        let expected = fs::read_to_string(&words).unwrap_or_default();
        if said != expected {
            differences += &format!("{}\n  says\n{said}  not\n{expected}\n", path.display());
        }
    }
    assert!(differences.is_empty(), "\n{differences}");
}

#[test]
fn every_message_has_a_place_a_reason_and_a_remedy() {
    for path in scenes() {
        let errors = errors(&path);
        assert!(!errors.list.is_empty(), "{}", path.display());
        for error in &errors.list {
            let text = String::from_utf8_lossy(&fs::read(&error.file).unwrap()).into_owned();
            let line = text.split('\n').nth(error.line - 1);
            let width = line.map_or(0, |line| line.chars().count());
            assert!((1..=width + 1).contains(&error.column), "{error}");
            assert!(error.message.len() > 5, "{error}");
            let remedy = error.help.is_some() || error.message.contains("expected");
            assert!(remedy, "no remedy: {error}");
        }
    }
}

#[test]
fn several_errors_are_reported_at_once() {
    for (name, count) in
        [("settings_out_of_range", 5), ("negative_values", 4), ("units_everywhere", 4)]
    {
        let found = errors(&Path::new(FOLDER).join(name).with_extension("ron")).list.len();
        assert_eq!(found, count, "{name}");
    }
}

#[test]
fn nothing_in_the_catalogue_is_left_over() {
    let names = |extension: &str| -> BTreeSet<PathBuf> {
        fs::read_dir(FOLDER)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|e| e == extension))
            .map(|path| path.with_extension(""))
            .collect()
    };
    assert_eq!(names("ron"), names("txt"));
}

#[test]
fn the_program_says_the_same_and_exits_with_3() {
    for path in scenes() {
        let path = path.to_str().unwrap();
        let done = Command::new(PROGRAM).args(["check", path]).assert().code(3);
        let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
        assert_eq!(said, format!("{}\n", errors(Path::new(path))));
    }
}
