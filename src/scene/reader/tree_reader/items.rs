//! Access to the items of lists, tuples and maps.

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeSeed, IntoDeserializer, Visitor};

use super::node_reader::Reader;
use crate::scene::reader::context::Failure;
use crate::scene::reader::spans::join;
use crate::scene::reader::stand_in::StandIn;
use crate::scene::reader::tree::Entry;

impl<'a> Reader<'a> {
    pub(super) fn values<V: Visitor<'a>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let found = self.node.entries.len();
        if found == length {
            return visitor.visit_seq(Items { reader: &self, next: 0 });
        }
        let stand_in = self.expected(&format!("{length} values in brackets"));
        de::Deserializer::deserialize_tuple(stand_in, length, visitor)
    }
}

/// Items of a list or a tuple.
pub(super) struct Items<'r, 'a> {
    pub(super) reader: &'r Reader<'a>,
    pub(super) next: usize,
}

impl<'a> de::SeqAccess<'a> for Items<'_, 'a> {
    type Error = Failure;

    fn next_element_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Failure> {
        let Reader { cx, node, path, unit, .. } = self.reader;
        let Some(entry) = node.entries.get(self.next) else { return Ok(None) };
        let path = format!("{path}[{}]", self.next);
        self.next += 1;
        let item = Reader { unit: *unit, ..Reader::new(cx, &entry.value, path) };
        seed.deserialize(item).map(Some)
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.reader.node.entries.len() - self.next)
    }
}

/// Entries of a map with text keys.
pub(super) struct Pairs<'r, 'a> {
    pub(super) reader: &'r Reader<'a>,
    pub(super) next: usize,
}

impl<'a> de::MapAccess<'a> for Pairs<'_, 'a> {
    type Error = Failure;

    fn next_key_seed<S: DeserializeSeed<'a>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Failure> {
        let Reader { cx, node, path, .. } = self.reader;
        loop {
            let Some(entry) = node.entries.get(self.next) else { return Ok(None) };
            self.next += 1;
            let Some(key) = &entry.key else {
                let message =
                    format!("expected `\"name\": value`, found {}", cx.found(&entry.value));
                cx.note(entry.value.span.start, path, message, "put a name and `:` before it");
                continue;
            };
            let path = join(path, &key.text);
            if !key.quoted {
                let help = format!("write `\"{}\"`", key.text);
                cx.note(key.span.start, &path, "a key without quotes".to_owned(), help);
            }
            let earlier = node.entries.iter().take(self.next - 1);
            if earlier.filter_map(|entry| entry.key.as_ref()).any(|other| other.text == key.text) {
                let message = format!("`{}` is given twice", key.text);
                cx.note(key.span.start, &path, message, "give it once");
                continue;
            }
            let name: StrDeserializer<'_, Failure> = key.text.as_str().into_deserializer();
            return seed.deserialize(name).map(Some);
        }
    }

    fn next_value_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<S::Value, Failure> {
        let Reader { cx, node, path, .. } = self.reader;
        match node.entries.get(self.next.wrapping_sub(1)) {
            Some(Entry { key: Some(key), value }) => {
                let path = join(path, &key.text);
                seed.deserialize(Reader::new(cx, value, path))
            }
            _ => seed.deserialize(StandIn),
        }
    }
}
