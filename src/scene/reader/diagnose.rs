//! Second reading of a scene that `ron` refuses, which finds all mistakes at once.
//!
//! It [reads](super::tree_reader) the tree of the [scanner](super::scan), which has the path and
//! the place of every value. It records each mistake and continues with the probable meaning or
//! with a [stand-in](super::stand_in). It does not accept scenes: only the first reading with `ron`
//! does.

use serde::Deserialize;

use super::context::{Context, Failure};
use super::scan::scan;
use super::tree_reader::Reader;
use crate::scene::diagnostic::{Finding, MAX_SHOWN, Placed};
use crate::scene::format::Scene;
use crate::scene::values;

/// With more mistakes than this the meaning of the scene is not examined.
const ENOUGH: usize = 1000;

/// Result of the second reading.
pub(in crate::scene) struct Diagnosis {
    /// The probable meaning of the scene, if it can be determined.
    pub scene: Option<Scene>,
    /// The mistakes.
    pub placed: Vec<Placed>,
    /// Paths of values that were made up. Findings about them are not reported.
    pub made_up: Vec<String>,
    /// Misspelt fields: the correct path and the path as written.
    pub renamed: Vec<(String, String)>,
}

/// Reads a text that `ron` refused.
pub(in crate::scene) fn diagnose(text: &str) -> Diagnosis {
    let (root, faults) = scan(text);
    let faults: Vec<_> = faults
        .into_iter()
        .map(|fault| Placed { at: fault.at, finding: Finding::new("", fault.message, fault.help) })
        .collect();
    let Some(root) = root else {
        return Diagnosis { scene: None, placed: faults, made_up: Vec::new(), renamed: Vec::new() };
    };
    // A missing field stops serde. It is recorded and made up, and the text is read again.
    let mut missing: Vec<Placed> = Vec::new();
    let mut absent: Vec<String> = Vec::new();
    let values = values::names(&root);
    loop {
        let cx = Context::new(text, &absent, &values);
        let reader = Reader::new(&cx, &root, String::new());
        let result = Scene::deserialize(reader);
        let notes = cx.into_notes();
        let failure = result.as_ref().err().map(Failure::placed);
        match failure {
            Some(Some((path, placed))) if missing.len() <= MAX_SHOWN => {
                missing.push(placed);
                absent.push(path);
            }
            _ => {
                let enough = notes.placed.len() > ENOUGH;
                let placed = faults.into_iter().chain(missing).chain(notes.placed).collect();
                let made_up = notes.made_up.into_iter().chain(absent).collect();
                let scene = result.ok().filter(|_| !enough);
                return Diagnosis { scene, placed, made_up, renamed: notes.renamed };
            }
        }
    }
}
