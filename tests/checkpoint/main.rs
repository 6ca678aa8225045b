//! Checkpoint and resume: a run that stops after any increment and goes on from its checkpoint
//! leaves the same bytes as one that did not.

#[path = "../common/mod.rs"]
mod common;

mod branched;
mod changed;
mod combined;
mod damaged;
mod extended;
mod refused;
mod resumed;
mod same_bytes;
mod same_bytes_of_rigs;
mod specimens;
mod stored;
