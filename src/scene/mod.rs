//! Scenes: their format, and the checks before a run.
//!
//! A scene goes from text to [`LoadedScene`] in four steps: [`overrides`] edits the text,
//! [`text`](crate::text) reads it into the types of [`format`](mod@format), [`specimen_file`] reads a
//! stored specimen, and `validate` checks the meaning. All of them go on past a mistake, so that a user
//! sees every mistake at once.

mod coincident;
pub(crate) mod files;
pub mod format;
mod limits;
pub(crate) mod load;
pub mod memory;
pub mod one_round;
pub mod overrides;
mod repeats;
pub mod shipped;
pub mod specimen_file;
pub mod stored_state;
#[cfg(test)]
mod tests;
pub(crate) mod validate;

pub use crate::text::diagnostic::{Diagnostic, Finding, SceneErrors};
pub use limits::{MAX_MEMORY, MAX_PARTICLES};
pub use load::{LoadError, LoadedScene, from_str, from_str_with, load, load_with};
pub use overrides::SetError;
pub use stored_state::{StoredMembrane, StoredParticle, StoredSpecimen, StoredState};
