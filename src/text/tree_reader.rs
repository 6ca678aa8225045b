//! A serde deserializer over the tree of the [scanner](super::scan).
//!
//! A mistake is recorded in the [`Context`] with its path and place, and
//! the reading continues with a made-up value: 1, an empty list, `None` or a first variant.

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeOwned, Visitor};

use super::access::Variant;
use super::read::{Context, Failure, NAME_OF_VERBATIM, found};
use super::tree::{Entry, Node, Shape};
use super::values;
use super::{suggest, units};

/// See [`Shape::MadeUp`].
static MADE_UP: Node<'static> = Node {
    span: 0..0,
    literal: "",
    number: None,
    name: None,
    shape: Shape::MadeUp,
    entries: Vec::new(),
};

/// Reads one value of the tree.
pub(super) struct Reader<'a> {
    pub(super) cx: &'a Context<'a>,
    pub(super) node: &'a Node<'a>,
    pub(super) path: String,
    /// Whether the name before the brackets has been read: a variant that contains a struct.
    pub(super) inside: bool,
    /// Unit of the numbers inside; see [`units::unit_of`].
    pub(super) unit: Option<&'static str>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(cx: &'a Context<'a>, node: &'a Node<'a>, path: String) -> Self {
        Self { cx, node, path, inside: false, unit: None }
    }

    /// Sets the field or variant to which the numbers inside belong.
    pub(super) fn named_for(self, name: &str) -> Self {
        let unit = units::unit_of(name, self.unit);
        Self { unit, ..self }
    }

    /// Reads a made-up value in place of this one, about which nothing is recorded.
    pub(super) fn made_up(&self) -> Self {
        Self::new(self.cx, &MADE_UP, String::new())
    }

    pub(super) fn is_made_up(&self) -> bool {
        self.node.shape == Shape::MadeUp
    }

    /// Records that another kind of value was expected, and makes up a value.
    pub(super) fn expected(&self, what: &str) -> Self {
        self.expected_with(what, self.meant(what))
    }

    pub(super) fn expected_with(&self, what: &str, help: impl Into<String>) -> Self {
        if !self.is_made_up() {
            let message = format!("expected {what}, found {}", found(self.node));
            self.cx.note(self.node.span.start, &self.path, message, help);
            self.cx.notes.borrow_mut().made_up.push(self.path.clone());
        }
        self.made_up()
    }

    /// The remedy, if it can be derived from the value.
    pub(super) fn meant(&self, what: &str) -> String {
        let literal = self.node.value();
        let number = what.ends_with("number") || what.contains("whole number");
        let arithmetic = matches!(self.node.shape, Shape::Word | Shape::Expression);
        if number && arithmetic {
            return values::help(self.node, self.cx.values, self.unit);
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
                    if self.node.name == Some("Some") && value.shape == Shape::Number =>
                {
                    format!("write `{}`, without `Some`", value.literal)
                }
                [Entry { key: None, value }] if self.node.name.is_none() => {
                    format!("leave the outer brackets out: `{}`", value.literal)
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
        fits.then(|| ron::from_str(self.node.value()).ok())?
    }
}

macro_rules! scalars {
    ($($method:ident $visit:ident $made_up:expr, $shapes:expr, $what:expr;)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
            let value = self.scalar(&$shapes).unwrap_or_else(|| {
                self.expected($what);
                $made_up
            });
            visitor.$visit(value)
        }
    )*};
}

impl<'de> de::Deserializer<'de> for Reader<'de> {
    type Error = Failure;

    scalars! {
        deserialize_bool visit_bool false, [Shape::Word], "`true` or `false`";
        deserialize_u32 visit_u32 1, [Shape::Number], "a whole number from 0 to 4294967295";
        deserialize_u64 visit_u64 1, [Shape::Number], "a whole number from 0";
        deserialize_f64 visit_f64 1.0, [Shape::Number, Shape::Word], "a number";
        deserialize_string visit_string String::new(), [Shape::Text], "a text in quotes";
        deserialize_str visit_string String::new(), [Shape::Text], "a text in quotes";
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_unit()
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        let inside = self.node.name == Some("Some");
        match self.node.entries.as_slice() {
            _ if self.is_made_up() || self.node.literal == "None" => visitor.visit_none(),
            [Entry { key: None, value }] if inside => {
                visitor.visit_some(Reader { node: value, ..self })
            }
            _ => visitor.visit_some(Reader { inside, ..self }),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        if name == NAME_OF_VERBATIM {
            return visitor.visit_newtype_struct(StrDeserializer::new(self.node.literal));
        }
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        if !self.is_made_up() && self.node.shape != Shape::List {
            return self.expected("a list `[...]`").deserialize_seq(visitor);
        }
        self.items(self.node.entries.len(), visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let is_plain = self.inside || self.node.name.is_none();
        if self.is_made_up() || (self.node.shape == Shape::Tuple && is_plain) {
            return self.values(length, visitor);
        }
        let what = format!("{length} values in round brackets `(...)`");
        self.expected(&what).deserialize_tuple(length, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        const MAP: &str = "a map `{\"name\": ...}`";
        let keys = || self.node.entries.iter().filter_map(|entry| entry.key.as_ref());
        match self.node.shape {
            Shape::Map | Shape::MadeUp => self.pairs(visitor),
            // The struct was meant as a map if its names are those of a map.
            Shape::Struct if self.node.name.is_none() && keys().all(|key| key.quoted) => {
                let message = format!("expected {MAP}, found {}", found(self.node));
                let help = "write `{` and `}` for `(` and `)`";
                self.cx.note(self.node.span.start, &self.path, message, help);
                self.pairs(visitor)
            }
            _ => self.expected(MAP).deserialize_map(visitor),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let shape = self.node.shape;
        let is_empty = self.node.entries.is_empty();
        let brackets =
            matches!(shape, Shape::Struct | Shape::MadeUp) || (shape == Shape::Tuple && is_empty);
        let other_name = !self.inside && self.node.name.is_some_and(|found| found != name);
        if other_name || !brackets {
            let what = format!("`({}: ...)`", fields.first().copied().unwrap_or_default());
            let help = match self.node.entries.as_slice() {
                [Entry { key: None, value }] if value.shape == Shape::Struct => {
                    self.without_names(fields)
                }
                _ if shape == Shape::Tuple && !other_name => self.without_names(fields),
                _ => self.meant(&what),
            };
            return self.expected_with(&what, help).deserialize_struct(name, fields, visitor);
        }
        self.fields(fields, visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let word = match self.node.shape {
            Shape::MadeUp => variants.first().copied(),
            Shape::Word => Some(self.node.literal),
            _ => self.node.name.filter(|_| !self.inside),
        };
        let Some(word) = word else {
            let what = format!("one of {}", suggest::list(variants));
            return self.expected(&what).deserialize_enum(name, variants, visitor);
        };
        if let Some(variant) = variants.iter().find(|variant| **variant == word) {
            return visitor.visit_enum(Variant { name: variant, reader: self });
        }
        let message = format!("unknown variant `{word}`");
        let help = suggest::help(word, variants, "variants");
        self.cx.note(self.node.span.start, &self.path, message, help);
        match suggest::nearest(word, variants.iter().copied()) {
            Some(name) => visitor.visit_enum(Variant { name, reader: self }),
            None => {
                self.cx.notes.borrow_mut().made_up.push(self.path.clone());
                self.made_up().deserialize_enum(name, variants, visitor)
            }
        }
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 f32 char bytes byte_buf unit unit_struct
        tuple_struct identifier ignored_any
    }
}
