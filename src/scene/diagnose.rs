//! The second reading of a scene that `ron` refuses: every mistake in one go.
//!
//! It [reads](super::tree_reader) the tree of the [scanner](super::scan), so it knows the path and
//! the place of all it touches, notes each mistake and goes on with what was probably meant or with
//! a [stand-in](super::stand_in). What it accepts is not decided here but by `ron` before.

use std::cell::RefCell;
use std::fmt;

use serde::{Deserialize, de};

use super::diagnostic::{Finding, MOST, Placed};
use super::format::{Scene, VERSION};
use super::scan::{Node, Shape, scan};
use super::spans::join;
use super::tree_reader::Reader;

/// With more mistakes than this nothing is gained by asking what the scene means.
const ENOUGH: usize = 1000;

/// What the second reading found.
pub(super) struct Diagnosis {
    /// The scene as it was probably meant, if that can be told.
    pub scene: Option<Scene>,
    /// The mistakes.
    pub placed: Vec<Placed>,
    /// Paths of values that were made up: what follows from them is no news.
    pub made_up: Vec<String>,
    /// Misspelt fields: the path as it was meant and as it is written.
    pub renamed: Vec<(String, String)>,
}

/// Reads a text that `ron` refused.
pub(super) fn diagnose(text: &str) -> Diagnosis {
    let (root, faults) = scan(text);
    let faults: Vec<_> = faults
        .into_iter()
        .map(|fault| Placed { at: fault.at, finding: Finding::new("", fault.message, fault.help) })
        .collect();
    let Some(root) = root else {
        return Diagnosis { scene: None, placed: faults, made_up: Vec::new(), renamed: Vec::new() };
    };
    // A missing field stops serde, so it is noted, made up and the reading is repeated.
    let mut missing: Vec<Placed> = Vec::new();
    let mut absent: Vec<String> = Vec::new();
    loop {
        let cx = Context { text, absent: &absent, notes: RefCell::default() };
        let reader = Reader::new(&cx, &root, String::new());
        let result = Scene::deserialize(reader);
        let notes = cx.notes.into_inner();
        let failure = result.as_ref().err().map(Failure::placed);
        match failure {
            Some(Some((path, placed))) if missing.len() <= MOST => {
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

/// What all of a reading shares.
pub(super) struct Context<'a> {
    /// The text.
    pub text: &'a str,
    /// Paths of missing fields that are to be made up.
    pub absent: &'a [String],
    notes: RefCell<Notes>,
}

#[derive(Default)]
struct Notes {
    placed: Vec<Placed>,
    made_up: Vec<String>,
    renamed: Vec<(String, String)>,
}

impl Context<'_> {
    /// Notes a mistake.
    pub fn note(&self, at: usize, path: &str, message: String, help: impl Into<String>) {
        let finding = Finding::new(path, message, help);
        self.notes.borrow_mut().placed.push(Placed { at, finding });
    }

    /// Notes that the value at a path is not the scene's own.
    pub fn made_up(&self, path: String) {
        self.notes.borrow_mut().made_up.push(path);
    }

    /// Notes a misspelt field: its path as it was meant and as it is written.
    pub fn renamed(&self, meant: String, written: String) {
        self.notes.borrow_mut().renamed.push((meant, written));
    }

    /// The text of a value.
    pub fn literal(&self, node: &Node) -> &str {
        self.text.get(node.span.clone()).unwrap_or_default()
    }

    /// A value in a message.
    pub fn found(&self, node: &Node) -> String {
        const LONGEST: usize = 40;
        let literal = self.literal(node);
        let name = node.name.clone().and_then(|name| self.text.get(name));
        match node.shape {
            Shape::Nothing => "nothing".to_owned(),
            _ if literal.chars().count() <= LONGEST && !literal.contains('\n') => {
                format!("`{literal}`")
            }
            _ if name.is_some() => format!("`{}(...)`", name.unwrap_or_default()),
            Shape::List => "a list `[...]`".to_owned(),
            Shape::Map => "a map `{...}`".to_owned(),
            Shape::Struct => "named fields `(name: ...)`".to_owned(),
            Shape::Tuple => "values in brackets `(...)`".to_owned(),
            _ => format!("`{}...`", literal.chars().take(LONGEST).collect::<String>()),
        }
    }
}

/// Why serde stopped: in practice a missing field.
#[derive(Debug)]
pub(super) struct Failure {
    field: Option<&'static str>,
    message: String,
    place: Option<(String, usize)>,
}

impl Failure {
    /// Ties the failure to the struct that it arose in.
    pub fn inside(mut self, path: &str, at: usize) -> Self {
        self.place.get_or_insert_with(|| (path.to_owned(), at));
        self
    }

    /// Path and finding of a missing field.
    fn placed(&self) -> Option<(String, Placed)> {
        let (path, at) = self.place.as_ref()?;
        let field = self.field?;
        let path = join(path, field);
        let help = match unit(field) {
            _ if field == "version" => format!("add `version: {VERSION}`"),
            Some(unit) => format!("add `{field}: ...`, {unit}"),
            None => format!("add `{field}: ...`"),
        };
        let finding = Finding::new(&path, format!("missing field `{field}`"), help);
        Some((path, Placed { at: *at, finding }))
    }
}

/// Units of the fields that cannot be left out.
fn unit(field: &str) -> Option<&'static str> {
    Some(match field {
        "radius" | "spacing" | "length" | "step" => "in m",
        "position" | "start" | "end" | "min" | "max" => "as (x, y) in m",
        "limits" => "as (smallest, greatest) in m",
        "dt" => "in s",
        "cohesion" | "tensile_strength" | "stress" => "in Pa",
        "increments" | "columns" | "rows" | "count" => "a number from 1",
        _ => return None,
    })
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl de::Error for Failure {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self { field: None, message: message.to_string(), place: None }
    }

    fn missing_field(field: &'static str) -> Self {
        Self { field: Some(field), message: format!("missing field `{field}`"), place: None }
    }
}
