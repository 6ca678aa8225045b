//! Reading of a text into a type of serde.

use std::path::Path;

use serde::de::DeserializeOwned;

use super::context::{Context, Notes};
use super::scan::scan;
use super::tree::Node;
use super::tree_reader::Reader;
use crate::scene::diagnostic::{Finding, MAX_SHOWN, Placed, SceneErrors};
use crate::scene::edited::EditedText;
use crate::scene::values;

/// With more mistakes than this the meaning of the text is not examined.
const ENOUGH: usize = 1000;

/// Reads the text of a file that has no mistakes.
///
/// # Errors
/// All mistakes.
pub(crate) fn read_sound<T: DeserializeOwned>(text: &str, file: &Path) -> Result<T, SceneErrors> {
    let (root, mut mistakes) = scan(text);
    let value = root.and_then(|root| {
        let (value, notes) = read(&root);
        mistakes.extend(notes.placed);
        value
    });
    let sound = value.filter(|_| mistakes.is_empty());
    sound.ok_or_else(|| SceneErrors::new(file, &EditedText::of(text), mistakes))
}

/// Reads a tree, and records its mistakes. If it has any, the value is what was probably meant;
/// `None` if nothing can be made of it.
pub(in crate::scene) fn read<T: DeserializeOwned>(root: &Node) -> (Option<T>, Notes) {
    // A missing field stops serde. It is recorded and made up, and the text is read again.
    let mut missing: Vec<Placed> = Vec::new();
    let mut absent: Vec<String> = Vec::new();
    let values = values::names(root);
    loop {
        let cx = Context::new(&absent, &values);
        let value = T::deserialize(Reader::new(&cx, root, String::new()));
        let mut notes = cx.into_notes();
        if let Err(failure) = &value {
            if let Some((path, placed)) = failure.missing_field()
                && missing.len() <= MAX_SHOWN
            {
                missing.push(placed);
                absent.push(path);
                continue;
            }
            let at = root.span.start;
            notes.placed.push(Placed { at, finding: Finding::new("", failure.to_string(), "") });
        }
        let value = value.ok().filter(|_| notes.placed.len() <= ENOUGH);
        notes.placed = missing.into_iter().chain(notes.placed).collect();
        notes.made_up.extend(absent);
        return (value, notes);
    }
}
