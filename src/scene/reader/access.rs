//! Access to the parts of a value: fields of structs, items of lists, tuples and maps, and variants
//! of enums.

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeSeed, IntoDeserializer, Visitor};

use super::context::{Failure, found};
use super::spans::{is_group, join};
use super::suggest;
use super::tree::{Entry, Key, Shape};
use super::tree_reader::Reader;

fn name(text: &str) -> StrDeserializer<'_, Failure> {
    text.into_deserializer()
}

impl<'a> Reader<'a> {
    pub(super) fn fields<V: Visitor<'a>>(
        self,
        allowed: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let at = self.node.span.start;
        let fields = Fields { reader: &self, allowed, given: Vec::new(), next: 0, value: None };
        visitor.visit_map(fields).map_err(|failure| failure.inside(&self.path, at))
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
}

/// Fields of a struct without unknown and repeated fields, which are recorded.
struct Fields<'r, 'a> {
    reader: &'r Reader<'a>,
    allowed: &'static [&'static str],
    given: Vec<&'static str>,
    next: usize,
    /// Value of the last returned field; `None` means a value to be made up.
    value: Option<Reader<'a>>,
}

impl<'a> Fields<'_, 'a> {
    /// The field that a key stands for.
    fn meant(&self, key: &Key) -> Option<&'static str> {
        let Reader { cx, node, path, .. } = self.reader;
        let at = key.span.start;
        if key.quoted {
            let message = "a field name in quotes".to_owned();
            cx.note(at, &join(path, &key.text), message, "leave the quotes out");
        }
        if let Some(field) = self.allowed.iter().find(|field| **field == key.text) {
            if self.given.contains(field) {
                let message = format!("`{field}` is given twice");
                cx.note(at, &join(path, field), message, "give it once");
                return None;
            }
            return Some(*field);
        }
        let meant = suggest::nearest(&key.text, self.allowed.iter().copied());
        let list = suggest::list(self.allowed);
        let help = match meant {
            Some(field) => format!("did you mean `{field}`? the fields here are {list}"),
            None => format!("the fields here are {list}"),
        };
        cx.note(at, &join(path, &key.text), format!("unknown field `{}`", key.text), help);
        let keys = || node.entries.iter().filter_map(|entry| entry.key.as_ref());
        let open =
            |field: &&str| !self.given.contains(field) && keys().all(|key| key.text != **field);
        let meant = meant.filter(open);
        if let Some(field) = meant {
            cx.renamed(join(path, field), join(path, &key.text));
        }
        meant
    }
}

impl<'a> de::MapAccess<'a> for Fields<'_, 'a> {
    type Error = Failure;

    fn next_key_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Failure> {
        let Reader { cx, node, path, .. } = self.reader;
        let mut field = None;
        while let Some(entry) = node.entries.get(self.next) {
            self.next += 1;
            if let Some(key) = &entry.key {
                field = self.meant(key);
                self.value = field
                    .map(|field| Reader::new(cx, &entry.value, join(path, field)).named_for(field));
                if field.is_some() {
                    break;
                }
            } else {
                let message = format!("expected `name: value`, found {}", found(&entry.value));
                let number = |entry: &Entry| entry.value.shape == Shape::Number;
                let before = node.entries.get(self.next.wrapping_sub(2));
                let help = if number(entry) && before.is_some_and(number) {
                    "a decimal has a point, no comma"
                } else {
                    ""
                };
                cx.note(entry.value.span.start, path, message, help);
            }
        }
        if field.is_none() {
            let absent = |field: &&&str| {
                let is_made_up = || {
                    let is_absent = !cx.absent.is_empty() && cx.absent.contains(&join(path, field));
                    self.reader.is_made_up() || is_absent
                };
                !self.given.contains(field) && is_made_up()
            };
            field = self.allowed.iter().find(absent).copied();
            self.value = None;
        }
        let Some(field) = field else { return Ok(None) };
        self.given.push(field);
        seed.deserialize(name(field)).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<S::Value, Failure> {
        seed.deserialize(self.value.take().unwrap_or_else(|| self.reader.made_up()))
    }
}

impl<'a> Reader<'a> {
    pub(super) fn values<V: Visitor<'a>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        if self.is_made_up() || self.node.entries.len() == length {
            return visitor.visit_seq(Items { reader: &self, next: 0, length });
        }
        self.expected(&format!("{length} values in brackets")).values(length, visitor)
    }
}

/// Items of a list or a tuple.
pub(super) struct Items<'r, 'a> {
    pub(super) reader: &'r Reader<'a>,
    pub(super) next: usize,
    pub(super) length: usize,
}

impl<'a> de::SeqAccess<'a> for Items<'_, 'a> {
    type Error = Failure;

    fn next_element_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Failure> {
        if self.next == self.length {
            return Ok(None);
        }
        let Reader { cx, node, path, unit, .. } = self.reader;
        let item = match node.entries.get(self.next) {
            Some(entry) => {
                let path = format!("{path}[{}]", self.next);
                Reader { unit: *unit, ..Reader::new(cx, &entry.value, path) }
            }
            None => self.reader.made_up(),
        };
        self.next += 1;
        seed.deserialize(item).map(Some)
    }
}

/// Entries of a map with text keys.
pub(super) struct Pairs<'r, 'a> {
    pub(super) reader: &'r Reader<'a>,
    pub(super) next: usize,
    /// The value of the last returned key.
    pub(super) value: Option<Reader<'a>>,
}

impl<'a> de::MapAccess<'a> for Pairs<'_, 'a> {
    type Error = Failure;

    fn next_key_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Failure> {
        let Reader { cx, node, path, .. } = self.reader;
        while let Some(entry) = node.entries.get(self.next) {
            self.next += 1;
            let Some(key) = &entry.key else {
                let message = format!("expected `\"name\": value`, found {}", found(&entry.value));
                cx.note(entry.value.span.start, path, message, "put a name and `:` before it");
                continue;
            };
            let path = join(path, &key.text);
            if !key.quoted {
                let help = format!("write `\"{}\"`", key.text.trim_matches('\''));
                cx.note(key.span.start, &path, "a key without quotes".to_owned(), help);
            }
            let mut earlier = node.entries[..self.next - 1].iter().flat_map(|entry| &entry.key);
            if earlier.any(|other| other.text == key.text) {
                let message = format!("`{}` is given twice", key.text);
                cx.note(key.span.start, &path, message, "give it once");
                continue;
            }
            self.value = Some(Reader::new(cx, &entry.value, path));
            return seed.deserialize(name(&key.text)).map(Some);
        }
        Ok(None)
    }

    fn next_value_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<S::Value, Failure> {
        seed.deserialize(self.value.take().unwrap_or_else(|| self.reader.made_up()))
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
        Ok((seed.deserialize(name(self.name))?, self))
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
        if !is_word && entries.iter().all(|entry| entry.key.is_some()) {
            return reader.fields(fields, visitor);
        }
        let first = fields.first().copied().unwrap_or_default();
        let what =
            if is_word { format!("`{name}(...)`") } else { format!("`{name}({first}: ...)`") };
        let help = match entries {
            _ if is_word && fields.is_empty() => format!("write `{name}()`"),
            _ if is_word => format!("its fields are {}", suggest::list(fields)),
            [Entry { value, .. }] if !is_group(value) => {
                format!("write `{name}({first}: {})`", value.literal)
            }
            _ => reader.without_names(fields),
        };
        reader.expected_with(&what, help).fields(fields, visitor)
    }
}
