//! The benchmark: run time against error.
//!
//! The `clastic_bench` program runs the parts:
//!
//! ```text
//! cargo run --release -p clastic_bench -- --help
//! ```
//!
//! | part | question |
//! |---|---|
//! | [`precision`] | one program: time against error, by solver and tolerance |
//! | [`increments`] | effect of the size of the increment on whole curves |
//! | [`theta`] | order of the theta-method, observed against expected |
//! | [`stages`] | time by stage and size of the program, by features of the scene |
//! | [`size`] | time and memory of an elastic increment against the number of disks |
//! | [`threads`] | one thread against two, and whether the results are the same bytes |
//!
//! Every part returns a [`Part`]: tables and charts. [`report`] writes them as CSV, SVG and
//! Markdown. Rigs are the scenes of `scenes/`, changed by settings ([`rigs`]); larger specimens are
//! mirrored tiles of the stored ones ([`specimens`]).

pub mod accuracy;
pub mod capture;
pub mod chart;
pub mod clock;
pub mod increments;
pub mod machine;
pub mod precision;
pub mod report;
pub mod rigs;
pub mod size;
pub mod specimens;
pub mod stages;
pub mod table;
pub mod theta;
pub mod threads;
pub mod written;

use clastic::output::OutputError;
use clastic::scene::LoadError;

pub use table::Part;

/// Extent of the measurements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Extent {
    /// Small specimens, few repetitions: about a minute.
    Quick,
    /// The specimens of the paper; the increment size on small ones.
    Standard,
    /// The increment size on the specimens of the paper too; 300 000 disks.
    Full,
}

/// Why a benchmark could not be run.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// A scene of the benchmark is missing or has errors.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// Something could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A rig did not behave as intended.
    #[error("{0}")]
    Run(String),
}
