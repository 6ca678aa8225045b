//! Tests of the scene text.

mod bad_scenes;
mod courses;
mod files;
mod mutations;
mod overrides;
mod samples;
mod solver;
mod spans;

use std::path::Path;

use super::load::{LoadError, LoadedScene, from_str};

/// Reads a text as the file `s.ron` in no particular folder.
fn read(text: &str, sets: &[&str]) -> Result<LoadedScene, LoadError> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    from_str(text, Path::new("s.ron"), Path::new(""), &sets)
}
