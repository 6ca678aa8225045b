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

use ron::extensions::Extensions;
use ron::value::RawValue;
use serde::Deserialize;

use crate::scene::unique_keys::entries;

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
    /// `clastic list` shows. Either this or `scenes`.
    pub scene: Option<PathBuf>,
    /// Several scenes, each with a name. The name [`SCENE`] of a run says which one it has.
    #[serde(default)]
    pub scenes: Ordered<PathBuf>,
    /// The run whose saved state is the specimen of the runs.
    pub prepare: Option<Preparation>,
    /// Settings that all runs have, `PATH=VALUE` as after `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Fields of the scene that a name stands for, as paths, or as `PATH=VALUE` with `{}` in the
    /// place of the value. A name without an entry is a path itself.
    #[serde(default)]
    pub settings: Ordered<Vec<String>>,
    /// Names of the runs over which `study_means.csv` averages, such as the seed.
    #[serde(default)]
    pub average_over: Vec<String>,
    /// The runs.
    pub runs: Runs,
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
    pub settings: Ordered<Vec<String>>,
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
    /// The runs of each entry, one entry after the other. A run lacks the names that only other
    /// entries have.
    Several(Vec<Runs>),
}

/// A map that keeps the order of the text, and refuses a key that is given twice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ordered<V>(pub Vec<(String, V)>);

impl<V> Ordered<V> {
    /// Value of a key.
    pub fn get(&self, key: &str) -> Option<&V> {
        self.0.iter().find(|(known, _)| known == key).map(|(_, value)| value)
    }
}

impl<'de, V: Deserialize<'de>> Deserialize<'de> for Ordered<V> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        entries(deserializer, "a map `{ \"name\": ... }`").map(Self)
    }
}

/// Why a study cannot be run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct StudyError {
    /// The file, with line and column if the mistake has a place.
    pub place: String,
    /// The mistake and its remedy.
    pub message: String,
}

impl StudyError {
    pub(super) fn new(file: &Path, message: impl Into<String>) -> Self {
        Self { place: file.display().to_string(), message: message.into() }
    }
}

impl Study {
    /// Reads a study from its text. `file` stands in messages.
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
}

/// Settings of a scene, `PATH=VALUE`, that give a name a value. `settings` has the fields of a
/// name; `None` if it does not have the name.
pub(super) fn sets(
    settings: &Ordered<Vec<String>>,
    name: &str,
    value: &str,
) -> Option<Vec<String>> {
    let set = |field: &String| match field.split_once('=') {
        Some((path, template)) => format!("{path}={}", template.replace("{}", value)),
        None => format!("{field}={value}"),
    };
    settings.get(name).map(|fields| fields.iter().map(set).collect())
}
