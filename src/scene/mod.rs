//! Scenes: the text format, its reader, and the checks before a run.
//!
//! A scene goes from text to [`LoadedScene`] in five steps, one file each: [`overrides`] edits the
//! text, `values` puts the values of `let` in place of their names, and points in place of the
//! expressions of tables, `reader` reads it into the types of [`format`](mod@format),
//! [`specimen_file`] reads a stored specimen, and [`validate`] checks the meaning. All of them go on
//! past a mistake, so that a user sees every mistake at once.

mod coincident;
mod courses;
pub(crate) mod diagnostic;
pub mod edited;
pub(crate) mod files;
pub mod format;
mod limits;
pub(crate) mod load;
pub mod memory;
pub mod one_round;
pub mod overrides;
pub(crate) mod reader;
mod repeats;
pub mod shipped;
pub mod shown;
pub mod specimen_file;
pub mod stored_state;
#[cfg(test)]
mod tests;
pub mod validate;
mod values;

pub use diagnostic::{Diagnostic, Finding, SceneErrors};
pub use limits::{MAX_MEMORY, MAX_PARTICLES};
pub use load::{LoadError, LoadedScene, from_str, from_str_with, load, load_unprepared, load_with};
pub use overrides::SetError;
pub use reader::spans;
pub(crate) use reader::suggest;
use reader::{dimension, expression, scan, tree, units};
pub use stored_state::{StoredMembrane, StoredParticle, StoredSpecimen, StoredState};
