//! The format of a study.
//!
//! ```ron
//! (
//!     version: 1,
//!     title: "cemented sand: two cements, three pressures, three seeds",
//!     scene: "biaxial_small",
//!     settings: {
//!         "cohesion": ["materials.sand.bond.cohesion"],
//!         "pressure": ["stages.confine.walls.left=Stress(to: {})", "stages.confine.walls.right=Stress(to: {})"],
//!     },
//!     runs: Grid({ "cohesion": [10.0e3, 50.0e3], "pressure": [20.0e3, 50.0e3, 100.0e3] }),
//! )
//! ```

use std::path::{Path, PathBuf};

use indexmap::IndexMap;
use serde::Deserialize;

use crate::scene::SceneErrors;
use crate::text::VERSION;
use crate::text::diagnostic::line_and_column;
use crate::text::read::{Verbatim, read_sound};
use crate::text::scan::scan;
use crate::text::spans::nearest;

/// A study: runs of one scene with other settings.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Version of the format: 1.
    pub version: u32,
    /// One line that says what the study shows.
    pub title: String,
    /// The scene: a file relative to that of the study, or the name of a scene that
    /// `clastic list` shows. Either this or `scenes`.
    pub scene: Option<PathBuf>,
    /// Several scenes, each with a name. The name [`SCENE`] of a run says which one it has.
    #[serde(default)]
    pub scenes: IndexMap<String, PathBuf>,
    /// The run whose saved state is the specimen of the runs.
    pub prepare: Option<Preparation>,
    /// Settings that all runs have, `PATH=VALUE` as after `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Fields of the scene that a name stands for, as paths, or as `PATH=VALUE` with `{}` in the
    /// place of the value. A name without an entry is a path itself.
    #[serde(default)]
    pub settings: IndexMap<String, Vec<String>>,
    /// Names of the runs over which `study_means.csv` averages, such as the seed.
    #[serde(default)]
    pub average_over: Vec<String>,
    /// The runs.
    pub runs: Runs,
    /// The text that was read.
    #[serde(skip)]
    pub(super) text: String,
}

/// Name whose value is the scene of a run, in a study with several scenes.
pub const SCENE: &str = "scene";

/// A run whose saved state is the specimen of others. It is made once per combination of the values
/// that it depends on.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preparation {
    /// The scene, as that of a study.
    pub scene: PathBuf,
    /// Name of the stage `Save` that keeps the state; without it the state at the end.
    pub state: Option<String>,
    /// Settings that every preparation has.
    #[serde(default)]
    pub set: Vec<String>,
    /// Names of the runs on which the preparation depends, with the fields of its scene.
    #[serde(default)]
    pub settings: IndexMap<String, Vec<String>>,
}

/// The runs of a study. A value is any value of a scene, in RON. Maps keep the order of the text.
#[derive(Debug, Deserialize)]
pub enum Runs {
    /// Every combination of the values of the names. The last name changes fastest.
    Grid(IndexMap<String, Vec<Verbatim>>),
    /// One run per entry, which gives its names their values.
    List(Vec<IndexMap<String, Verbatim>>),
    /// The runs of each entry, one entry after the other. A run lacks the names that only other
    /// entries have.
    Several(Vec<Runs>),
}

/// Why a study cannot be run.
#[derive(Clone, Debug, thiserror::Error)]
pub enum StudyError {
    /// Its text is wrong.
    #[error(transparent)]
    Text(SceneErrors),
    /// What it asks for is wrong.
    #[error("{}:{line}:{column}: {message}", file.display())]
    Plan {
        /// The file of the study.
        file: PathBuf,
        /// Line of the file, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// The field, the mistake and its remedy.
        message: String,
    },
}

impl Study {
    /// Reads a study from its text. `file` stands in messages.
    pub fn read(text: &str, file: &Path) -> Result<Self, StudyError> {
        let mut study: Self = read_sound(text, file).map_err(StudyError::Text)?;
        text.clone_into(&mut study.text);
        if study.version != VERSION {
            let message =
                format!("{} is unknown; this clastic reads version {VERSION}", study.version);
            return Err(study.wrong(file, "version", &message));
        }
        Ok(study)
    }

    /// The error about a field of the study, which its path names.
    pub(super) fn wrong(&self, file: &Path, path: &str, message: &str) -> StudyError {
        let at = scan(&self.text).0.map_or(0, |root| nearest(&root, path, false));
        let (line, column) = line_and_column(&self.text, at);
        let (file, message) = (file.to_owned(), format!("{path}: {message}"));
        StudyError::Plan { file, line, column, message }
    }
}

/// Settings of a scene, `PATH=VALUE`, that give the fields of a name a value.
pub(super) fn sets(fields: &[String], value: &str) -> impl Iterator<Item = String> {
    fields.iter().map(move |field| match field.split_once('=') {
        Some((path, template)) => format!("{path}={}", template.replace("{}", value)),
        None => format!("{field}={value}"),
    })
}
