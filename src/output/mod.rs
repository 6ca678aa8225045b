//! The run directory: what a run leaves behind.
//!
//! | file | content |
//! |---|---|
//! | `run.json` | version, scene and its hash, settings, outcome, key results, conventions |
//! | `scene.ron` | the scene as run, overrides applied |
//! | `history.csv` | one row an increment |
//! | `events.csv` | one row a rupture |
//! | `avalanches.csv` | one row an avalanche |
//! | `timings.csv` | wall clock; it lives here alone, all other files are the same bytes on every run |
//! | `specimen.csv` | the particles at the end of a compaction, then at the start of the reference stage, before its first increment (of a scene that pours its particles there, before they fell): scenes can read it |
//! | `frames/frame_000123.csv` | all particles after increment 123, where the scene asks for frames |
//! | `frames/frame_000123.svg` | its picture |
//! | `final_particles.csv` | all particles at the end: scenes can read it |
//! | `program_000123.json` | cone program and solution of increment 123, where asked for |
//! | `mechanism.csv` | the mechanism of the first collapse |
//! | `*.svg` | pictures, drawn at the end; that of the mechanism when the specimen collapses |
//! | `checkpoint.bin` | the run between two increments, where asked for and where a run stops before its end |
//!
//! Compression and contraction are positive, rotation is positive anticlockwise, units stand in the
//! names of columns, and a value that the scene does not define is an empty field. Numbers read
//! back as they were. Rows are written whole, one write each; whole files appear under their name
//! only when they are complete. Output reads the world and changes no number of the simulation.

pub mod atomic;
pub mod avalanches;
pub mod checkpoint;
pub mod csv_file;
pub mod directory;
pub mod dump;
mod error;
pub mod events;
pub mod frames;
pub mod history;
pub mod key_results;
pub mod mechanism;
pub mod plots;
mod plugin;
pub mod porosity;
pub mod run_directory;
pub mod run_record;
pub mod snapshot;
pub mod timings;

pub use checkpoint::{Checkpoint, ResumeError};
pub use error::OutputError;
pub use key_results::Results;
pub use plugin::{OutputFailure, OutputPlugin};
pub use run_directory::{Ending, RunOptions, RunWriter};
