//! Data that all readers of a text share, and the error with which serde stops.

use std::cell::RefCell;
use std::fmt;

use serde::de;

use super::spans::join;
use super::tree::{Node, Shape};
use super::units::unit_of;
use crate::scene::diagnostic::{Finding, Placed};
use crate::scene::format::VERSION;

/// Data that all readers of a text share.
pub(super) struct Context<'a> {
    /// Paths of missing fields that the reading makes up.
    pub absent: &'a [String],
    /// Names that stand for numbers.
    pub values: &'a [String],
    notes: RefCell<Notes>,
}

/// What a reading has recorded.
#[derive(Default)]
pub(in crate::scene) struct Notes {
    /// The mistakes.
    pub placed: Vec<Placed>,
    /// Paths of values that were made up. Findings about them are not reported.
    pub made_up: Vec<String>,
    /// Misspelt fields: the correct path and the path as written.
    pub renamed: Vec<(String, String)>,
}

impl<'a> Context<'a> {
    /// The context of a reading that has recorded nothing yet.
    pub fn new(absent: &'a [String], values: &'a [String]) -> Self {
        Self { absent, values, notes: RefCell::default() }
    }

    /// What the reading has recorded.
    pub fn into_notes(self) -> Notes {
        self.notes.into_inner()
    }

    /// Records a mistake.
    pub fn note(&self, at: usize, path: &str, message: String, help: impl Into<String>) {
        let finding = Finding::new(path, message, help);
        self.notes.borrow_mut().placed.push(Placed { at, finding });
    }

    /// Records that the value at a path was made up.
    pub fn made_up(&self, path: String) {
        self.notes.borrow_mut().made_up.push(path);
    }

    /// Records a misspelt field: its correct path and its path as written.
    pub fn renamed(&self, meant: String, written: String) {
        self.notes.borrow_mut().renamed.push((meant, written));
    }
}

/// Description of a value for messages.
pub(super) fn found(node: &Node) -> String {
    const LONGEST: usize = 40;
    let Node { literal, number, name, shape, .. } = node;
    let is_short = literal.chars().count() <= LONGEST && !literal.contains('\n');
    match (shape, number, name) {
        (Shape::Nothing, ..) => "nothing".to_owned(),
        (_, Some(number), _) if is_short => format!("`{literal}`, which is {number}"),
        (_, Some(number), _) => format!("`{number}`"),
        _ if is_short => format!("`{literal}`"),
        (_, _, Some(name)) => format!("`{name}(...)`"),
        (Shape::List, ..) => "a list `[...]`".to_owned(),
        (Shape::Map, ..) => "a map `{...}`".to_owned(),
        (Shape::Struct, ..) => "named fields `(name: ...)`".to_owned(),
        (Shape::Tuple, ..) => "values in brackets `(...)`".to_owned(),
        _ => format!("`{}...`", literal.chars().take(LONGEST).collect::<String>()),
    }
}

/// Why serde stopped: usually a missing field.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(super) struct Failure {
    field: Option<&'static str>,
    message: String,
    place: Option<(String, usize)>,
}

impl Failure {
    /// Adds the path and place of the surrounding struct.
    pub fn inside(mut self, path: &str, at: usize) -> Self {
        self.place.get_or_insert_with(|| (path.to_owned(), at));
        self
    }

    /// Path and finding of a missing field, if that is why.
    pub fn missing_field(&self) -> Option<(String, Placed)> {
        let (path, at) = self.place.as_ref()?;
        let field = self.field?;
        let path = join(path, field);
        let help = match (field, unit_of(field, None).filter(|unit| !unit.is_empty())) {
            ("version", _) => format!("add `version: {VERSION}`"),
            ("increments" | "columns" | "rows" | "count", _) => {
                format!("add `{field}: ...`, a number from 1")
            }
            ("position" | "start" | "end" | "min" | "max" | "about" | "centre", Some(unit)) => {
                format!("add `{field}: ...`, as (x, y) in {unit}")
            }
            ("size", Some(unit)) if path == "cell.size" => {
                format!("add `{field}: ...`, as (width, height) in {unit}")
            }
            ("limits" | "radii", Some(unit)) => {
                format!("add `{field}: ...`, as (minimum, maximum) in {unit}")
            }
            (_, Some(unit)) => format!("add `{field}: ...`, in {unit}"),
            (_, None) => format!("add `{field}: ...`"),
        };
        let finding = Finding::new(&path, format!("missing field `{field}`"), help);
        Some((path, Placed { at: *at, finding }))
    }
}

impl de::Error for Failure {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self { field: None, message: message.to_string(), place: None }
    }

    fn missing_field(field: &'static str) -> Self {
        Self { field: Some(field), message: format!("missing field `{field}`"), place: None }
    }
}
