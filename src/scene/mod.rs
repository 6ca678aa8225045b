//! Scenes.
pub mod format;
pub mod specimen_file;
