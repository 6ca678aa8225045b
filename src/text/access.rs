//! Access to the parts of a value: fields of structs, items of lists, tuples and maps, and variants
//! of enums.

use std::iter::from_fn;

use serde::de::value::{MapDeserializer, SeqDeserializer, StrDeserializer};
use serde::de::{self, DeserializeSeed, IntoDeserializer, Visitor};

use super::diagnostic::Placed;
use super::read::{Failure, found};
use super::spans::{is_group, join};
use super::suggest;
use super::tree::{Entry, Key, Node, Shape};
use super::tree_reader::Reader;
use super::units::unit_of;

impl<'a> IntoDeserializer<'a, Failure> for Reader<'a> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'a> Reader<'a> {
    /// Reads the fields of a struct, without unknown and repeated ones, which are recorded.
    pub(super) fn fields<V: Visitor<'a>>(
        self,
        allowed: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let Self { cx, node, path, .. } = &self;
        let mut entries = node.entries.iter().enumerate();
        let mut given = Vec::new();
        let fields = from_fn(|| {
            let written = entries.by_ref().find_map(|(k, entry)| {
                let Some(key) = &entry.key else {
                    self.note_unnamed(k);
                    return None;
                };
                let field = self.field_meant(key, allowed, &given)?;
                let value = Reader::new(cx, &entry.value, join(path, field)).named_for(field);
                Some((field, value))
            });
            let made_up = || {
                let is_due = |field: &&&str| {
                    let is_missing = |of: &Placed| of.finding.path == join(path, field);
                    let is_due = self.is_made_up() || cx.missing.iter().any(is_missing);
                    is_due && !given.contains(*field)
                };
                Some((*allowed.iter().find(is_due)?, self.made_up()))
            };
            let (field, value) = written.or_else(made_up)?;
            given.push(field);
            Some((field, value))
        });
        let result = visitor.visit_map(MapDeserializer::new(fields));
        result.map_err(|failure: Failure| failure.inside(path, node.span.start))
    }

    /// The field that a key stands for, if it is none of those that are `given` already.
    fn field_meant(
        &self,
        key: &Key,
        allowed: &'static [&'static str],
        given: &[&str],
    ) -> Option<&'static str> {
        let Self { cx, node, path, .. } = self;
        let at = key.span.start;
        if key.quoted {
            let message = "a field name in quotes".to_owned();
            cx.note(at, &join(path, &key.text), message, "leave the quotes out");
        }
        if let Some(field) = allowed.iter().find(|field| **field == key.text) {
            if given.contains(field) {
                let message = format!("`{field}` is given twice");
                cx.note(at, &join(path, field), message, "give it once");
                return None;
            }
            return Some(*field);
        }
        let meant = suggest::nearest(&key.text, allowed.iter().copied());
        let list = suggest::list(allowed);
        let help = match meant {
            Some(field) => format!("did you mean `{field}`? the fields here are {list}"),
            None if allowed.is_empty() => "leave it out: there are no fields here".to_owned(),
            None => format!("the fields here are {list}"),
        };
        cx.note(at, &join(path, &key.text), format!("unknown field `{}`", key.text), help);
        let field = meant.filter(|field| !given.contains(field) && node.entry(field).is_none())?;
        cx.notes.borrow_mut().renamed.push((join(path, field), join(path, &key.text)));
        Some(field)
    }

    /// Records that the entry of an index has no name.
    fn note_unnamed(&self, k: usize) {
        let value = |k: usize| &self.node.entries[k].value;
        let message = format!("expected `name: value`, found {}", found(value(k)));
        let is_number = |k: usize| value(k).shape == Shape::Number;
        let is_decimal = k > 0 && is_number(k - 1) && is_number(k);
        let help = if is_decimal { "a decimal has a point, no comma" } else { "" };
        self.cx.note(value(k).span.start, &self.path, message, help);
    }

    /// The remedy where values have no names.
    pub(super) fn without_names(&self, fields: &[&str]) -> String {
        match self.node.entries.as_slice() {
            [Entry { value, .. }] if value.shape == Shape::Struct => {
                "leave out one pair of brackets".to_owned()
            }
            _ => format!("write `name: value`; the fields here are {}", suggest::list(fields)),
        }
    }

    /// Reads the values of a tuple.
    pub(super) fn values<V: Visitor<'a>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        if self.is_made_up() || self.node.entries.len() == length {
            return self.items(length, visitor);
        }
        self.expected(&format!("{length} values in brackets")).values(length, visitor)
    }

    /// Reads the items of a list or a tuple.
    pub(super) fn items<V: Visitor<'a>>(
        &self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let item = |k: usize| match self.node.entries.get(k) {
            Some(entry) => {
                let path = format!("{}[{k}]", self.path);
                Reader { unit: self.unit, ..Reader::new(self.cx, &entry.value, path) }
            }
            None => self.made_up(),
        };
        visitor.visit_seq(SeqDeserializer::new((0..length).map(item)))
    }

    /// Reads the entries of a map with text keys.
    pub(super) fn pairs<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Failure> {
        let Self { cx, node, path, .. } = self;
        let pairs = node.entries.iter().enumerate().filter_map(|(k, entry)| {
            let Some(key) = &entry.key else {
                let message = format!("expected `\"name\": value`, found {}", found(&entry.value));
                cx.note(entry.value.span.start, &path, message, "put a name and `:` before it");
                return None;
            };
            let path = join(&path, &key.text);
            if !key.quoted {
                let help = format!("write `\"{}\"`", key.text.trim_matches('\''));
                cx.note(key.span.start, &path, "a key without quotes".to_owned(), help);
            }
            let mut earlier = node.entries[..k].iter().flat_map(|entry| &entry.key);
            if earlier.any(|other| other.text == key.text) {
                let message = format!("`{}` is given twice", key.text);
                cx.note(key.span.start, &path, message, "give it once");
                return None;
            }
            Some((key.text.as_str(), Reader::new(cx, &entry.value, path)))
        });
        visitor.visit_map(MapDeserializer::new(pairs))
    }
}

/// A value of an enum whose variant is known.
pub(super) struct Variant<'a> {
    pub(super) name: &'static str,
    pub(super) reader: Reader<'a>,
}

impl<'a> de::EnumAccess<'a> for Variant<'a> {
    type Error = Failure;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'a>>(self, seed: S) -> Result<(S::Value, Self), Failure> {
        Ok((seed.deserialize(StrDeserializer::<Failure>::new(self.name))?, self))
    }
}

impl<'a> de::VariantAccess<'a> for Variant<'a> {
    type Error = Failure;

    fn unit_variant(self) -> Result<(), Failure> {
        if self.reader.node.name.is_some() {
            self.reader.expected(&format!("plain `{}`", self.name));
        }
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'a>>(self, seed: S) -> Result<S::Value, Failure> {
        let reader = self.reader.named_for(self.name);
        match reader.node.entries.as_slice() {
            [Entry { key: None, value }] => {
                let group = is_group(value);
                let path = if group { reader.path } else { format!("{}[0]", reader.path) };
                seed.deserialize(Reader { node: value, path, inside: false, ..reader })
            }
            _ if reader.node.shape == Shape::Word => {
                seed.deserialize(reader.expected(&format!("`{}(...)`", self.name)))
            }
            _ => seed.deserialize(Reader { inside: true, ..reader }),
        }
    }

    fn tuple_variant<V: Visitor<'a>>(self, length: usize, visitor: V) -> Result<V::Value, Failure> {
        self.reader.named_for(self.name).values(length, visitor)
    }

    fn struct_variant<V: Visitor<'a>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let Self { name, reader } = self;
        let is_word = reader.node.shape == Shape::Word;
        let entries = reader.node.entries.as_slice();
        // Without fields brackets may be left out.
        let is_whole = !is_word || fields.is_empty();
        if is_whole && entries.iter().all(|entry| entry.key.is_some()) {
            return reader.fields(fields, visitor);
        }
        let Some(first) = fields.first() else {
            return reader.expected(&format!("plain `{name}`")).fields(fields, visitor);
        };
        let what =
            if is_word { format!("`{name}(...)`") } else { format!("`{name}({first}: ...)`") };
        // A number is meant for the first field of a number, and a word for the first of another kind.
        let meant = |value: &Node| {
            let is_number = value.shape == Shape::Number;
            fields.iter().position(|field| unit_of(field, None).is_some() == is_number)
        };
        let help = match entries {
            _ if is_word => format!("its fields are {}", suggest::list(fields)),
            [Entry { value, .. }] if !is_group(value) => {
                let k = meant(value).unwrap_or(0);
                let before: String = fields[..k].iter().map(|of| format!("{of}: ..., ")).collect();
                format!("write `{name}({before}{}: {})`", fields[k], value.literal)
            }
            _ => reader.without_names(fields),
        };
        reader.expected_with(&what, help).fields(fields, visitor)
    }
}
