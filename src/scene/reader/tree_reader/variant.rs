//! Access to the variants of an enum.

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeSeed, IntoDeserializer, Visitor};

use super::node_reader::Reader;
use crate::scene::reader::context::Failure;
use crate::scene::reader::spans::is_group;
use crate::scene::reader::suggest;
use crate::scene::reader::tree::{Entry, Shape};

/// A value of an enum whose variant is known.
pub(super) struct Variant<'a> {
    pub(super) name: &'static str,
    pub(super) reader: Reader<'a>,
}

impl<'a> de::EnumAccess<'a> for Variant<'a> {
    type Error = Failure;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'a>>(self, seed: S) -> Result<(S::Value, Self), Failure> {
        let name: StrDeserializer<'_, Failure> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
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
                let stand_in = reader.expected(&format!("`{}(...)`", self.name));
                seed.deserialize(stand_in)
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
        let unnamed = |entry: &Entry| entry.key.is_none();
        if self.reader.node.shape == Shape::Word {
            let what = format!("`{}(...)`", self.name);
            let help = match fields {
                [] => format!("write `{}()`", self.name),
                _ => format!("its fields are {}", suggest::list(fields)),
            };
            let stand_in = self.reader.expected_with(&what, help);
            return de::Deserializer::deserialize_struct(stand_in, "", fields, visitor);
        }
        if self.reader.node.entries.iter().any(unnamed) {
            let first = fields.first().copied().unwrap_or_default();
            let what = format!("`{}({first}: ...)`", self.name);
            let help = match self.reader.node.entries.as_slice() {
                [Entry { value, .. }] if value.shape == Shape::Struct => {
                    "leave out one pair of brackets".to_owned()
                }
                [Entry { value, .. }] if !is_group(value) => {
                    format!("write `{}({first}: {})`", self.name, self.reader.cx.literal(value))
                }
                _ => format!("write `name: value`; the fields here are {}", suggest::list(fields)),
            };
            let stand_in = self.reader.expected_with(&what, help);
            return de::Deserializer::deserialize_struct(stand_in, "", fields, visitor);
        }
        self.reader.fields(fields, visitor)
    }
}
