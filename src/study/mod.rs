//! Studies: many runs of one scene with other settings, as one table.
//!
//! ```text
//! Study (RON)  ->  Plan: one PlannedRun per combination, each checked  ->  runs  ->  table
//! ```
//!
//! A run lies in a directory that is named by the hash of its content: the program's version, the
//! scene with its settings, and the stored specimen. A run that exists is therefore never made
//! again, whichever study asks for it, and a study can be extended.

mod combinations;
pub mod format;
pub mod means;
pub mod plan;
pub mod planned;
pub mod table;

pub use format::{Study, StudyError};
pub use plan::plan;
pub use planned::{Plan, PlannedRun, Start, Wanted};
