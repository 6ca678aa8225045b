//! Converts a value of the tree to a type, with messages about errors.

use serde::de::DeserializeOwned;

use crate::scene::reader::context::Context;
use crate::scene::reader::stand_in::StandIn;
use crate::scene::reader::tree::{Entry, Node, Shape};
use crate::scene::reader::units;
use crate::scene::values;

/// Reads one value of the tree.
pub(in crate::scene::reader) struct Reader<'a> {
    pub(super) cx: &'a Context<'a>,
    pub(super) node: &'a Node,
    pub(super) path: String,
    /// Whether the name before the brackets has been read: a variant that contains a struct.
    pub(super) inside: bool,
    /// Unit of the numbers inside; see [`units::unit_of`].
    pub(super) unit: Option<&'static str>,
}

impl<'a> Reader<'a> {
    pub(in crate::scene::reader) fn new(cx: &'a Context<'a>, node: &'a Node, path: String) -> Self {
        Self { cx, node, path, inside: false, unit: None }
    }

    /// Sets the field or variant to which the numbers inside belong.
    pub(super) fn named_for(self, name: &str) -> Self {
        let unit = units::unit_of(name, self.unit);
        Self { unit, ..self }
    }

    /// Records that another kind of value was expected, and makes up a value.
    pub(super) fn expected(&self, what: &str) -> StandIn {
        self.expected_with(what, self.meant(what))
    }

    pub(super) fn expected_with(&self, what: &str, help: impl Into<String>) -> StandIn {
        let message = format!("expected {what}, found {}", self.cx.found(self.node));
        self.cx.note(self.node.span.start, &self.path, message, help);
        self.cx.made_up(self.path.clone());
        StandIn
    }

    /// The remedy, if it can be derived from the value.
    pub(super) fn meant(&self, what: &str) -> String {
        let literal = self.cx.literal(self.node);
        let number = what.ends_with("number") || what.contains("whole number");
        let arithmetic = matches!(self.node.shape, Shape::Word | Shape::Expression);
        if number && arithmetic {
            return values::help(self.node, self.cx.text, self.cx.values, self.unit);
        }
        match self.node.shape {
            Shape::Number if number => match (units::split(literal), literal.parse::<f64>()) {
                (Some((value, unit)), _) => units::help(value, unit, self.unit),
                (_, Ok(value)) if value >= 0.0 && value.fract() == 0.0 && value < 1e9 => {
                    format!("write {value:.0}")
                }
                (_, Ok(value)) if value > 1.0 && value < 1e9 && what.contains("whole") => {
                    format!("write {:.0} or {:.0}", value.floor(), value.ceil())
                }
                _ => String::new(),
            },
            Shape::Tuple if number => match self.node.entries.as_slice() {
                [Entry { key: None, value }]
                    if self.named() == Some("Some") && value.shape == Shape::Number =>
                {
                    format!("write `{}`, without `Some`", self.cx.literal(value))
                }
                [_, _, ..] => "give one number".to_owned(),
                _ => String::new(),
            },
            Shape::Nothing if self.path.is_empty() => {
                "there is nothing but comments in it; `clastic list` shows scenes to start from"
                    .into()
            }
            Shape::Text if number => "leave the quotes out".to_owned(),
            Shape::Word | Shape::Number | Shape::Expression | Shape::Char
                if what.starts_with("a text") =>
            {
                format!("write `\"{}\"`", literal.trim_matches('\''))
            }
            Shape::Text if what.starts_with("a text") && literal.contains('\\') => {
                "a backslash in a text is written twice, `\\\\`; in paths `/` will do".to_owned()
            }
            Shape::Tuple if what.starts_with("a list") && self.node.name.is_none() => {
                "write `[` and `]` for `(` and `)`".to_owned()
            }
            Shape::Map if what.starts_with("a list") => {
                "items of a list are in `[` and `]`, with no name before them".to_owned()
            }
            _ => String::new(),
        }
    }

    pub(super) fn scalar<T: DeserializeOwned>(&self, shapes: &[Shape]) -> Option<T> {
        let fits = shapes.contains(&self.node.shape);
        fits.then(|| ron::from_str(self.cx.literal(self.node)).ok())?
    }

    pub(super) fn named(&self) -> Option<&'a str> {
        self.node.variant(self.cx.text)
    }
}
