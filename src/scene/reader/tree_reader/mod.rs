//! A serde deserializer over the tree of the [scanner](super::scan).
//!
//! A mistake is recorded in the [`Context`](super::context::Context) with its path and place, and
//! the reading continues.

mod fields;
mod items;
mod node_reader;
mod variant;

use serde::de::{self, Visitor};

use super::context::Failure;
use super::stand_in::StandIn;
use super::suggest;
use super::tree::{Entry, Shape};
use items::{Items, Pairs};
pub(super) use node_reader::Reader;
use variant::Variant;

macro_rules! scalars {
    ($($method:ident $visit:ident $type:ty, $shapes:expr, $what:expr;)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
            match self.scalar::<$type>(&$shapes) {
                Some(value) => visitor.$visit(value),
                None => self.expected($what).$method(visitor),
            }
        }
    )*};
}

impl<'de> de::Deserializer<'de> for Reader<'de> {
    type Error = Failure;

    scalars! {
        deserialize_bool visit_bool bool, [Shape::Word], "`true` or `false`";
        deserialize_u32 visit_u32 u32, [Shape::Number], "a whole number from 0 to 4294967295";
        deserialize_u64 visit_u64 u64, [Shape::Number], "a whole number from 0";
        deserialize_f64 visit_f64 f64, [Shape::Number, Shape::Word], "a number";
        deserialize_string visit_string String, [Shape::Text], "a text in quotes";
        deserialize_str visit_string String, [Shape::Text], "a text in quotes";
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        visitor.visit_unit()
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        if self.node.shape == Shape::Word && self.cx.literal(self.node) == "None" {
            return visitor.visit_none();
        }
        match self.node.entries.as_slice() {
            [Entry { key: None, value }] if self.named() == Some("Some") => {
                visitor.visit_some(Reader { node: value, ..self })
            }
            _ => {
                let inside = self.named() == Some("Some");
                visitor.visit_some(Reader { inside, ..self })
            }
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        if self.node.shape == Shape::List {
            visitor.visit_seq(Items { reader: &self, next: 0 })
        } else {
            self.expected("a list `[...]`").deserialize_seq(visitor)
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        if self.node.shape == Shape::Tuple && (self.inside || self.node.name.is_none()) {
            return self.values(length, visitor);
        }
        let what = format!("{length} values in round brackets `(...)`");
        self.expected(&what).deserialize_tuple(length, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        const MAP: &str = "a map `{\"name\": ...}`";
        let keys = || self.node.entries.iter().filter_map(|entry| entry.key.as_ref());
        match self.node.shape {
            Shape::Map => visitor.visit_map(Pairs { reader: &self, next: 0 }),
            // The struct was meant as a map if its names are those of a map.
            Shape::Struct if self.node.name.is_none() && keys().all(|key| key.quoted) => {
                let message = format!("expected {MAP}, found {}", self.cx.found(self.node));
                let help = "write `{` and `}` for `(` and `)`";
                self.cx.note(self.node.span.start, &self.path, message, help);
                visitor.visit_map(Pairs { reader: &self, next: 0 })
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
        let brackets =
            shape == Shape::Struct || (shape == Shape::Tuple && self.node.entries.is_empty());
        let other_name = !self.inside && self.named().is_some_and(|found| found != name);
        if other_name || !brackets {
            let what = format!("`({}: ...)`", fields.first().copied().unwrap_or_default());
            let help = match self.node.entries.as_slice() {
                [Entry { key: None, value }] if value.shape == Shape::Struct => {
                    "leave out one pair of brackets".to_owned()
                }
                _ if shape == Shape::Tuple && !other_name => {
                    format!("write `name: value`; the fields here are {}", suggest::list(fields))
                }
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
            Shape::Word => Some(self.cx.literal(self.node)),
            _ => self.named().filter(|_| !self.inside),
        };
        let Some(word) = word else {
            let what = format!("one of {}", suggest::list(variants));
            return self.expected(&what).deserialize_enum(name, variants, visitor);
        };
        let (known, meant) = match variants.iter().find(|variant| **variant == word) {
            Some(variant) => (true, Some(*variant)),
            None => (false, suggest::nearest(word, variants.iter().copied())),
        };
        if !known {
            let message = format!("unknown variant `{word}`");
            let help = suggest::help(word, variants, "variants");
            self.cx.note(self.node.span.start, &self.path, message, help);
        }
        if let Some(variant) = meant {
            visitor.visit_enum(Variant { name: variant, reader: self })
        } else {
            self.cx.made_up(self.path);
            StandIn.deserialize_enum(name, variants, visitor)
        }
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 f32 char bytes byte_buf unit unit_struct newtype_struct
        tuple_struct identifier ignored_any
    }
}
