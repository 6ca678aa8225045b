//! Reading of RON that does not stop at the first mistake. No library has this: `ron` and serde end
//! with the first error, and keep no place of a value for what is found wrong later.
//!
//! [`read`](read::read) is the way in, for scenes and studies. It scans a text into a tree with the
//! place of every value ([`scan`], [`tree`]), reads the tree with serde ([`tree_reader`]), records
//! each mistake with its remedy, and goes on with the probable meaning or with a made-up value. `ron`
//! reads the literals: numbers and texts.

mod access;
pub(super) mod dimension;
pub(super) mod expression;
pub(crate) mod read;
pub(super) mod scan;
pub mod spans;
pub(crate) mod suggest;
pub(super) mod tree;
mod tree_reader;
pub(super) mod units;
