//! Reading of RON that does not stop at the first mistake. No library has this: `ron` and serde end
//! with the first error.
//!
//! [`diagnose`](diagnose::diagnose) is the way in. It scans a text into a tree with the place of
//! every value ([`scan`], [`tree`]), reads the tree as a scene ([`tree_reader`]), records each
//! mistake with its remedy, and goes on with the probable meaning or with a made-up value.

mod access;
pub(super) mod context;
pub(super) mod diagnose;
pub(super) mod dimension;
pub(super) mod expression;
pub(super) mod scan;
pub mod spans;
pub(crate) mod suggest;
pub(super) mod tree;
mod tree_reader;
pub(super) mod units;
