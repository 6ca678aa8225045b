//! Second reading of a scene that `ron` refuses, which finds all mistakes at once.
//!
//! It [reads](super::tree_reader) the tree of the [scanner](super::scan), which has the path and
//! the place of every value. It records each mistake and continues with the probable meaning or
//! with a made-up value. It does not accept scenes: only the first reading with `ron` does.

use serde::Deserialize;

use super::context::{Context, Failure, Notes};
use super::scan::scan;
use super::tree_reader::Reader;
use crate::scene::diagnostic::{MAX_SHOWN, Placed};
use crate::scene::format::Scene;
use crate::scene::values;

/// With more mistakes than this the meaning of the scene is not examined.
const ENOUGH: usize = 1000;

/// Reads a text that `ron` refused. Returns its probable meaning, if it can be determined, and the
/// mistakes.
pub(in crate::scene) fn diagnose(text: &str) -> (Option<Scene>, Notes) {
    let (root, faults) = scan(text);
    let Some(root) = root else {
        return (None, Notes { placed: faults, ..Notes::default() });
    };
    // A missing field stops serde. It is recorded and made up, and the text is read again.
    let mut missing: Vec<Placed> = Vec::new();
    let mut absent: Vec<String> = Vec::new();
    let values = values::names(&root);
    loop {
        let cx = Context::new(text, &absent, &values);
        let scene = Scene::deserialize(Reader::new(&cx, &root, String::new()));
        let mut notes = cx.into_notes();
        if let Some((path, placed)) = scene.as_ref().err().and_then(Failure::placed)
            && missing.len() <= MAX_SHOWN
        {
            missing.push(placed);
            absent.push(path);
            continue;
        }
        let scene = scene.ok().filter(|_| notes.placed.len() <= ENOUGH);
        notes.placed = faults.into_iter().chain(missing).chain(notes.placed).collect();
        notes.made_up.extend(absent);
        return (scene, notes);
    }
}
