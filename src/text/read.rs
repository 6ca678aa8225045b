//! Reading of a text into a type of serde.

use std::cell::RefCell;
use std::fmt;
use std::path::Path;

use serde::Deserialize;
use serde::de::{self, DeserializeOwned};

use super::VERSION;
use super::diagnostic::{Finding, MAX_SHOWN, Placed, SceneErrors};
use super::edited::EditedText;
use super::scan::scan;
use super::spans::join;
use super::tree::{Node, Shape};
use super::tree_reader::Reader;
use super::units::unit_of;
use super::values;

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
pub fn read<T: DeserializeOwned>(root: &Node) -> (Option<T>, Notes) {
    // A missing field stops serde. It is recorded and made up, and the text is read again.
    let mut missing: Vec<Placed> = Vec::new();
    let values = values::names(root);
    loop {
        let cx = Context { missing: &missing, values: &values, notes: RefCell::default() };
        let value = T::deserialize(Reader::new(&cx, root, String::new()));
        let mut notes = cx.notes.into_inner();
        if let Err(failure) = &value {
            if let Some(placed) = failure.missing_field()
                && missing.len() <= MAX_SHOWN
            {
                missing.push(placed);
                continue;
            }
            let at = root.span.start;
            notes.placed.push(Placed { at, finding: Finding::new("", failure.to_string(), "") });
        }
        let value = value.ok().filter(|_| notes.placed.len() <= ENOUGH);
        notes.made_up.extend(missing.iter().map(|placed| placed.finding.path.clone()));
        notes.placed.splice(..0, missing);
        return (value, notes);
    }
}

/// Data that all readers of a text share.
pub(super) struct Context<'a> {
    /// Missing fields, which the reading makes up.
    pub missing: &'a [Placed],
    /// Names that stand for numbers.
    pub values: &'a [String],
    pub notes: RefCell<Notes>,
}

/// What a reading has recorded, and before it the putting in of values.
#[derive(Default)]
pub(crate) struct Notes {
    pub placed: Vec<Placed>,
    /// Tables that expressions stood for: path and number of increments.
    pub tables: Vec<(String, f64)>,
    /// Paths of values that were made up. Findings about them are not reported.
    pub made_up: Vec<String>,
    /// Misspelt fields: the correct path and the path as written, outer fields first.
    pub renamed: Vec<(String, String)>,
}

impl Context<'_> {
    pub fn note(&self, at: usize, path: &str, message: String, help: impl Into<String>) {
        let finding = Finding::new(path, message, help);
        self.notes.borrow_mut().placed.push(Placed { at, finding });
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

    /// The finding of a missing field, if that is why.
    pub(crate) fn missing_field(&self) -> Option<Placed> {
        let (path, at) = self.place.as_ref()?;
        let field = self.field?;
        let path = join(path, field);
        let parts = match field {
            "position" | "start" | "end" | "min" | "max" | "about" | "centre" => "as (x, y) ",
            "size" if path == "cell.size" => "as (width, height) ",
            "limits" | "radii" => "as (minimum, maximum) ",
            _ => "",
        };
        let help = match (field, unit_of(field, None).filter(|unit| !unit.is_empty())) {
            ("version", _) => format!("add `version: {VERSION}`"),
            ("increments" | "columns" | "rows" | "count", _) => {
                format!("add `{field}: ...`, a number from 1")
            }
            (_, Some(unit)) => format!("add `{field}: ...`, {parts}in {unit}"),
            (_, None) => format!("add `{field}: ...`"),
        };
        let finding = Finding::new(path, format!("missing field `{field}`"), help);
        Some(Placed { at: *at, finding })
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

/// Name by which the [reader](super::tree_reader) knows such a value.
pub(super) const NAME_OF_VERBATIM: &str = "Verbatim";

/// The text of a value of any type.
#[derive(Clone, Debug, Deserialize)]
pub struct Verbatim(pub String);
