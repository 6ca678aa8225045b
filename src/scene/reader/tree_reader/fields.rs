//! Access to the fields of a struct.

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeSeed, IntoDeserializer, Visitor};

use super::node_reader::Reader;
use crate::scene::reader::context::Failure;
use crate::scene::reader::spans::join;
use crate::scene::reader::stand_in::StandIn;
use crate::scene::reader::suggest;
use crate::scene::reader::tree::{Entry, Key, Node, Shape};

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
}

/// Fields of a struct without unknown and repeated fields, which are recorded.
struct Fields<'r, 'a> {
    reader: &'r Reader<'a>,
    allowed: &'static [&'static str],
    given: Vec<&'static str>,
    next: usize,
    /// Value of the last returned field; `None` means a value to be made up.
    value: Option<(&'a Node, &'static str)>,
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
                self.value = field.map(|field| (&entry.value, field));
                if field.is_some() {
                    break;
                }
            } else {
                let message = format!("expected `name: value`, found {}", cx.found(&entry.value));
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
                !self.given.contains(field) && cx.absent.contains(&join(path, field))
            };
            field = self.allowed.iter().find(absent).copied();
            self.value = None;
        }
        let Some(field) = field else { return Ok(None) };
        self.given.push(field);
        let name: StrDeserializer<'_, Failure> = field.into_deserializer();
        seed.deserialize(name).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<S::Value, Failure> {
        match self.value.take() {
            Some((node, field)) => {
                let path = join(&self.reader.path, field);
                seed.deserialize(Reader::new(self.reader.cx, node, path).named_for(field))
            }
            None => seed.deserialize(StandIn),
        }
    }
}
