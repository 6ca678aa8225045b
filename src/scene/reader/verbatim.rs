//! A value that is kept as its text.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, Visitor};

/// Name by which the [reader](super::tree_reader) knows such a value.
pub(super) const NAME: &str = "clastic::Verbatim";

/// The text of a value of any type.
#[derive(Clone, Debug)]
pub struct Verbatim(pub String);

impl<'de> Deserialize<'de> for Verbatim {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_newtype_struct(NAME, Text)
    }
}

struct Text;

impl Visitor<'_> for Text {
    type Value = Verbatim;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Verbatim, E> {
        Ok(Verbatim(text.to_owned()))
    }
}
