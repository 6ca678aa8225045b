//! The run directory: the results of a run.
//!
//! | file | content |
//! |---|---|
//! | `run.json` | version, scene and its hash, settings, outcome, key results, conventions |
//! | `scene.ron` | the scene as run, overrides applied |
//! | `history.csv` | one row per increment |
//! | `events.csv` | one row per rupture |
//! | `avalanches.csv` | one row per avalanche |
//! | `timings.csv` | wall-clock times; all other files have equal bytes in every run |
//! | `specimen.csv` | the prepared specimen, in the format of stored specimens; see below |
//! | `frames/frame_000123.npz` | frame: the state after increment 123, if the scene requests frames |
//! | `frames/start.npz`, `peak.npz`, `end.npz` | frames before the reference stage, at the peak, at the end |
//! | `frames/frame_000123.csv` | the particles of the frame |
//! | `final_particles.csv` | all particles at the end, in the format of stored specimens |
//! | `state_NAME.npz` | the state that stage `NAME`, a `Save`, has kept |
//! | `final_state.npz` | the state at the end |
//! | `program_000123.json` | cone program and solution of increment 123, if requested |
//! | `mechanism.csv` | the mechanism of the first collapse |
//! | `report.html` | curves, animation and key results as a page, written at the end |
//! | `final_checkpoint.bin` | state from which more stages or increments continue |
//! | `checkpoint.bin` | state between two increments, if requested or if a run stops early |
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
pub mod dump;
mod error;
pub(crate) mod events;
mod finish;
pub(crate) mod found;
pub mod frames;
mod hashing_writer;
pub mod history;
pub mod marks;
pub(crate) mod mechanism;
mod names;
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
pub use error::{OutputError, ResumeError};
pub use finish::{Ending, finish};
pub use plugin::{OutputFailure, OutputPlugin};
pub use run_directory::{RunDirectory, RunOptions};

#[cfg(test)]
mod tests;
