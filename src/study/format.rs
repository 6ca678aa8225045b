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

use std::fmt;
use std::path::{Path, PathBuf};

use ron::extensions::Extensions;
use ron::value::RawValue;
use serde::Deserialize;

use super::ordered::Ordered;

/// Version of the format that this build reads.
pub const VERSION: u32 = 1;

/// A study: runs of one scene with other settings.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Version of the format: 1.
    pub version: u32,
    /// One line that says what the study shows.
    pub title: String,
    /// The scene: a file relative to that of the study, or the name of a scene that
    /// `clastic list` shows.
    pub scene: PathBuf,
    /// Settings that all runs have, `PATH=VALUE` as after `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Fields of the scene that a name stands for, as paths, or as `PATH=VALUE` with `{}` in the
    /// place of the value. A name without an entry is a path itself.
    #[serde(default)]
    pub settings: Ordered<Vec<String>>,
    /// The runs.
    pub runs: Runs,
}

/// The runs of a study. A value is any value of a scene, in RON.
#[derive(Debug, Deserialize)]
pub enum Runs {
    /// Every combination of the values of the names. The last name changes fastest.
    Grid(Ordered<Vec<Box<RawValue>>>),
    /// One run per entry, which gives its names their values.
    List(Vec<Ordered<Box<RawValue>>>),
    /// One run per row of a CSV file, relative to that of the study. Its columns are names.
    Table(PathBuf),
}

/// Why a study cannot be run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StudyError {
    /// The file, with line and column if the mistake has a place.
    pub place: String,
    /// The mistake and its remedy.
    pub message: String,
}

impl fmt::Display for StudyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}

impl std::error::Error for StudyError {}

impl StudyError {
    pub(super) fn new(file: &Path, message: impl Into<String>) -> Self {
        Self { place: file.display().to_string(), message: message.into() }
    }
}

impl Study {
    /// Reads a study from its text. `file` stands in messages.
    ///
    /// # Errors
    /// If the text is no study of this version.
    pub fn read(text: &str, file: &Path) -> Result<Self, StudyError> {
        let options = ron::Options::default()
            .with_default_extension(Extensions::IMPLICIT_SOME | Extensions::UNWRAP_NEWTYPES);
        let study: Self = options.from_str(text).map_err(|error| StudyError {
            place: format!("{}:{}", file.display(), error.span.start),
            message: error.code.to_string(),
        })?;
        if study.version != VERSION {
            let message = format!(
                "version: {} is unknown; this clastic reads version {VERSION}",
                study.version
            );
            return Err(StudyError::new(file, message));
        }
        Ok(study)
    }

    /// Settings of the scene, `PATH=VALUE`, that give a name a value.
    pub(super) fn sets(&self, name: &str, value: &str) -> Vec<String> {
        let fields = self.settings.0.iter().find(|(known, _)| known == name);
        let set = |field: &String| match field.split_once('=') {
            Some((path, template)) => format!("{path}={}", template.replace("{}", value)),
            None => format!("{field}={value}"),
        };
        match fields {
            Some((_, fields)) => fields.iter().map(set).collect(),
            None => vec![format!("{name}={value}")],
        }
    }
}
