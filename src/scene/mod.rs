//! Scenes: the text format, its reader, and the checks before a run.
//!
//! A scene goes from text to [`LoadedScene`] in five steps, one file each: [`overrides`] edits the
//! text, `values` puts the values of `let` in place of their names, `ron` reads it into the types
//! of [`format`](mod@format), [`specimen_file`] reads a stored specimen, and [`validate`] checks
//! the meaning. A text that `ron` refuses is read a second time by `diagnose`, which does not stop
//! at the first mistake.

mod diagnose;
pub mod diagnostic;
pub mod edited;
pub(crate) mod files;
pub mod format;
pub mod load;
pub mod memory;
pub mod overrides;
mod repeats;
mod scan;
pub mod shipped;
pub mod shown;
pub mod spans;
pub mod specimen_file;
mod stand_in;
pub mod stored_state;
pub(crate) mod suggest;
#[cfg(test)]
mod tests;
mod tree_reader;
mod unique_keys;
mod units;
pub mod upgrade;
pub mod validate;
mod values;

pub use diagnostic::{Diagnostic, Finding, SceneErrors};
pub use load::{LoadError, LoadedScene, from_str, from_str_with, load, load_with};
pub use overrides::SetError;
pub use specimen_file::{StoredParticle, StoredSpecimen};
pub use stored_state::StoredState;
