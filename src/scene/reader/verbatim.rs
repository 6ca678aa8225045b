//! A value that is kept as its text.

use serde::Deserialize;

/// Name by which the [reader](super::tree_reader) knows such a value.
pub(super) const NAME: &str = "Verbatim";

/// The text of a value of any type.
#[derive(Clone, Debug, Deserialize)]
pub struct Verbatim(pub String);
