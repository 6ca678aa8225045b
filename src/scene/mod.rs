//! Scenes.
pub mod format;
