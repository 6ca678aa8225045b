//! The tree of a RON text: the shape and place of every value, without its meaning.

use std::ops::Range;

/// Range of bytes in the text.
pub type Span = Range<usize>;

/// Shape of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A missing value.
    Nothing,
    /// An identifier: a variant without payload, `true`, `None`.
    Word,
    Number,
    /// Arithmetic in place of a number: `2 * step`, `-step`.
    Expression,
    Text,
    Char,
    /// `(name: value, ...)`.
    Struct,
    /// `(value, ...)` or `()`.
    Tuple,
    /// `[value, ...]`.
    List,
    /// `{key: value, ...}`.
    Map,
    /// Stands for any value, where the text has none or one that does not fit.
    MadeUp,
}

/// A value of the text.
#[derive(Clone, Debug)]
pub struct Node<'t> {
    /// Span of the whole value, with the name before its brackets.
    pub span: Span,
    /// Its text.
    pub literal: &'t str,
    /// The number that a name or an expression stands for.
    pub number: Option<Box<str>>,
    /// Name before the brackets: a struct or a variant with payload.
    pub name: Option<&'t str>,
    pub shape: Shape,
    /// Entries inside the brackets.
    pub entries: Vec<Entry<'t>>,
}

impl<'t> Node<'t> {
    /// The text of the value, or the number that it stands for.
    pub fn value(&self) -> &str {
        self.number.as_deref().unwrap_or(self.literal)
    }

    /// A number in place of this value, and with its place.
    pub(crate) fn as_number(&self, number: &str) -> Self {
        Self { number: Some(number.into()), ..self.as_group(Shape::Number, []) }
    }

    /// A list, a tuple or a made-up value in place of this one, and with its place.
    pub(crate) fn as_group(&self, shape: Shape, values: impl IntoIterator<Item = Self>) -> Self {
        let entries = values.into_iter().map(|value| Entry { key: None, value }).collect();
        let Self { span, literal, .. } = self;
        Self { span: span.clone(), literal, number: None, name: None, shape, entries }
    }

    /// The entry with a key.
    pub fn entry(&self, key: &str) -> Option<&Entry<'t>> {
        self.entries.iter().find(|entry| entry.key.as_ref().is_some_and(|k| k.text == key))
    }

    /// The value of a key.
    pub fn field(&self, key: &str) -> Option<&Self> {
        self.entry(key).map(|entry| &entry.value)
    }
}

/// A value inside brackets.
#[derive(Clone, Debug)]
pub struct Entry<'t> {
    /// Key of the entry, in structs and maps.
    pub key: Option<Key>,
    pub value: Node<'t>,
}

/// A field name or a map key.
#[derive(Clone, Debug)]
pub struct Key {
    pub span: Span,
    /// Text of the key without quotes.
    pub text: String,
    /// Whether the key is in quotes.
    pub quoted: bool,
}
