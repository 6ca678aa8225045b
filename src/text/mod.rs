//! Reading of RON that does not stop at the first mistake. No library has this: `ron` and serde end
//! with the first error, and keep no place of a value for what is found wrong later.
//!
//! `read::read` is the way in, for scenes and studies. It scans a text into a tree with the
//! place of every value (`scan`, `tree`), reads the tree with serde (`tree_reader`), records
//! each mistake with its remedy, and goes on with the probable meaning or with a made-up value. `ron`
//! reads the literals: numbers and texts. `values` puts the values of `let` in place of their names, and
//! `courses` points in place of the expressions of tables. A `diagnostic` is a mistake with its place.

mod access;
pub(crate) mod courses;
pub mod diagnostic;
pub(crate) mod dimension;
pub mod edited;
pub(crate) mod expression;
pub(crate) mod read;
pub(crate) mod scan;
pub mod shown;
pub mod spans;
pub(crate) mod suggest;
pub(crate) mod tree;
mod tree_reader;
pub(crate) mod units;
pub(crate) mod values;

/// Version of the formats of scenes and studies.
pub const VERSION: u32 = 1;
