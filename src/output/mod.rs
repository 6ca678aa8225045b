//! The run directory: the results of a run.
//!
//! [`directory`] names its files. Those that there may be several of are:
//!
//! | file | content |
//! |---|---|
//! | `frames/frame_000123.npz` | frame: the state after increment 123, if the scene requests frames |
//! | `frames/frame_000123.csv` | the particles of the frame |
//! | `state_NAME.npz` | the state that stage `NAME`, a `Save`, has kept |
//! | `program_000123.json` | cone program and solution of increment 123, if requested |
//!
//! `specimen.csv` is written at the end of a compaction, and again when the reference stage begins.
//! It then holds the particles before the first increment of that stage. If particles fall into
//! place during that stage, these are the positions before the fall.
//!
//! Compression, contraction and anticlockwise rotation are positive. Units are part of the names of
//! columns. A value that the scene does not define is an empty field. Numbers are written so that
//! reading gives them back exactly. Each row is written at once, and a whole file gets its name
//! when it is complete. Output reads the world and changes no number of the simulation.

pub mod atomic;
pub(crate) mod avalanches;
mod begin;
pub mod checkpoint;
#[cfg(feature = "report")]
mod corners;
pub mod csv_file;
pub mod directory;
pub mod drive;
mod dump;
mod error;
pub(crate) mod events;
mod finish;
pub(crate) mod found;
pub mod frames;
pub mod history;
pub mod marks;
pub(crate) mod mechanism;
mod platens;
mod plugin;
pub(crate) mod porosity;
pub(crate) mod prepared;
pub mod read_history;
#[cfg(feature = "report")]
pub mod report;
pub(crate) mod run_directory;
pub mod run_record;
mod save;
mod states;
pub mod timings;
pub mod view;
mod wanted;

pub use begin::{begin, resume};
pub use checkpoint::Checkpoint;
pub use error::OutputError;
pub use finish::finish;
pub use plugin::{OutputFailure, OutputPlugin};
pub use run_directory::{RunDirectory, RunOptions};

#[cfg(test)]
mod tests;
