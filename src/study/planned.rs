//! The runs of a study, before any of them runs.

use std::path::{Path, PathBuf};

/// The runs of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// Names that differ between runs, in the order of the study.
    pub names: Vec<String>,
    /// Runs whose state is the specimen of others, in the order in which they are needed.
    pub preparations: Vec<PlannedRun>,
    /// The runs, in the order of the study.
    pub runs: Vec<PlannedRun>,
}

/// A run of a study.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlannedRun {
    /// Path of its scene.
    pub scene: PathBuf,
    /// Values in RON, in the order of [`Plan::names`]; empty where the run does not have the name.
    pub values: Vec<String>,
    /// Settings of the scene, `PATH=VALUE`.
    pub sets: Vec<String>,
    /// The state from which it starts.
    pub start: Option<Start>,
    /// Name of its directory: the hash of its content.
    pub directory: String,
}

/// A state that a preparation leaves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Start {
    /// Index among [`Plan::preparations`].
    pub preparation: usize,
    /// Name of the file in the directory of the preparation.
    pub file: String,
}

/// A scene that a plan asks for.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// The scene as the study names it.
    pub scene: &'a Path,
    /// Settings, `PATH=VALUE`.
    pub sets: &'a [String],
    /// Whether its saved state is still to be made, so that the scene is to be read without it.
    pub is_unprepared: bool,
}

impl PlannedRun {
    /// The run in one line: its names and values.
    pub fn label(&self, names: &[String]) -> String {
        label(names, &self.values)
    }
}

/// Names with their values, without names that have none.
pub fn label(names: &[impl AsRef<str>], values: &[impl AsRef<str>]) -> String {
    let parts = names.iter().zip(values).map(|(name, value)| (name.as_ref(), value.as_ref()));
    let parts = parts.filter(|(_, value)| !value.is_empty());
    parts.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
}
