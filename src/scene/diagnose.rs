//! Second reading of a scene that `ron` refuses, which finds all mistakes at once.
//!
//! It [reads](super::tree_reader) the tree of the [scanner](super::scan), which has the path and
//! the place of every value. It records each mistake and continues with the probable meaning or
//! with a [stand-in](super::stand_in). It does not accept scenes: only the first reading with `ron`
//! does.

use std::cell::RefCell;
use std::fmt;

use serde::{Deserialize, de};

use super::diagnostic::{Finding, MAX_SHOWN, Placed};
use super::format::{Scene, VERSION};
use super::scan::{Node, Shape, scan};
use super::spans::join;
use super::tree_reader::Reader;
use super::values;

/// With more mistakes than this the meaning of the scene is not examined.
const ENOUGH: usize = 1000;

/// Result of the second reading.
pub(super) struct Diagnosis {
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
pub(super) fn diagnose(text: &str) -> Diagnosis {
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
    let values = values::names(&root, text);
    loop {
        let cx = Context { text, absent: &absent, values: &values, notes: RefCell::default() };
        let reader = Reader::new(&cx, &root, String::new());
        let result = Scene::deserialize(reader);
        let notes = cx.notes.into_inner();
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

/// Data that all readers of a text share.
pub(super) struct Context<'a> {
    /// The text.
    pub text: &'a str,
    /// Paths of missing fields that the reading makes up.
    pub absent: &'a [String],
    /// Names that stand for numbers.
    pub values: &'a [String],
    notes: RefCell<Notes>,
}

#[derive(Default)]
struct Notes {
    placed: Vec<Placed>,
    made_up: Vec<String>,
    renamed: Vec<(String, String)>,
}

impl Context<'_> {
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

    /// The text of a value.
    pub fn literal(&self, node: &Node) -> &str {
        self.text.get(node.span.clone()).unwrap_or_default()
    }

    /// Description of a value for messages.
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

/// Why serde stopped: usually a missing field.
#[derive(Debug)]
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

/// Units of the mandatory fields.
fn unit(field: &str) -> Option<&'static str> {
    Some(match field {
        "radius" | "spacing" | "length" | "step" => "in m",
        "position" | "start" | "end" | "min" | "max" => "as (x, y) in m",
        "limits" => "as (minimum, maximum) in m",
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
