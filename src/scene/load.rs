//! Reading a scene.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use ron::extensions::Extensions;

use super::diagnose::{Diagnosis, diagnose};
use super::diagnostic::{Finding, Placed, SceneErrors, line_and_column, place, within};
use super::format::{Scene, Specimen};
use super::overrides::{SetError, apply};
use super::spans::Spans;
use super::specimen_file::{ReadError, StoredSpecimen, read};
use super::validate::findings;

/// A scene that was read and checked.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// What it says.
    pub scene: Scene,
    /// Its text, with settings applied.
    pub text: String,
    /// Its file.
    pub path: PathBuf,
    /// The stored specimen that it names.
    pub specimen: Option<StoredSpecimen>,
}

impl LoadedScene {
    /// Line and column, from 1, of a field or of what is around it if it is left out.
    #[must_use]
    pub fn position(&self, path: &str) -> (usize, usize) {
        line_and_column(&self.text, Spans::of(&self.text).nearest(path, false))
    }

    /// Ties findings of a later step, as of spawning, to their places in the text.
    #[must_use]
    pub fn errors(&self, findings: Vec<Finding>) -> SceneErrors {
        SceneErrors::new(&self.path, &self.text, place(&self.text, findings, &[]))
    }
}

/// Why there is no scene.
#[derive(Debug)]
pub enum LoadError {
    /// The scene file cannot be read.
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A setting leads nowhere or does not fit.
    Set(SetError),
    /// The scene, or the stored specimen that it names, is wrong.
    Scene(SceneErrors),
}

impl LoadError {
    /// Exit code of a command that fails with this error: 1 file, 2 usage, 3 scene.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Read { .. } => 1,
            Self::Set(_) => 2,
            Self::Scene(_) => 3,
        }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => {
                write!(f, "{}: cannot read the scene: {source}", path.display())
            }
            Self::Set(error) => error.fmt(f),
            Self::Scene(errors) => errors.fmt(f),
        }
    }
}

impl std::error::Error for LoadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Read { source, .. } => Some(source),
            _ => None,
        }
    }
}

/// The dialect of RON that scenes are written in.
pub(super) fn ron_options() -> ron::Options {
    let extensions = Extensions::IMPLICIT_SOME
        | Extensions::UNWRAP_NEWTYPES
        | Extensions::UNWRAP_VARIANT_NEWTYPES;
    ron::Options::default().with_default_extension(extensions)
}

/// Reads and checks a scene file, after settings of the form `path=value`; see
/// [`overrides`](super::overrides).
///
/// # Errors
/// See [`LoadError`]. All mistakes of a scene are reported at once.
pub fn load(path: &Path, sets: &[String]) -> Result<LoadedScene, LoadError> {
    let read_error = |source| LoadError::Read { path: path.to_owned(), source };
    let bytes = fs::read(path).map_err(read_error)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(error.as_bytes());
        let finding = Finding::new("", "not UTF-8 text", "save the scene as UTF-8");
        LoadError::Scene(SceneErrors::new(path, &text, vec![Placed { at, finding }]))
    })?;
    from_str(&text, path, path.parent().unwrap_or(Path::new("")), sets)
}

/// Reads and checks a scene from a text. `name` stands for its file in messages; a stored
/// specimen is looked for in `base`.
///
/// # Errors
/// See [`LoadError`].
pub fn from_str(
    text: &str,
    name: &Path,
    base: &Path,
    sets: &[String],
) -> Result<LoadedScene, LoadError> {
    from_text(text, name, sets, |path| read(&base.join(path)))
}

/// Reads and checks a scene whose particles exist already: `stored` stands for the specimen file, if
/// it names one.
///
/// # Errors
/// See [`LoadError`].
pub fn from_str_with(
    text: &str,
    name: &Path,
    stored: StoredSpecimen,
    sets: &[String],
) -> Result<LoadedScene, LoadError> {
    from_text(text, name, sets, |_| Ok(stored))
}

fn from_text(
    text: &str,
    name: &Path,
    sets: &[String],
    read: impl FnOnce(&str) -> Result<StoredSpecimen, ReadError>,
) -> Result<LoadedScene, LoadError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let text = apply(text, sets).map_err(LoadError::Set)?;
    let Diagnosis { scene, mut placed, made_up, renamed } = parse(&text);
    let mut csv_errors = None;
    let mut specimen = None;
    if let Some(scene) = &scene {
        let mut found = Vec::new();
        if let Specimen::File { path, .. } = &scene.specimen {
            match read(path) {
                Ok(stored) => specimen = Some(stored),
                Err(ReadError::File(message)) => {
                    let help = "the path is relative to the scene file";
                    found.push(Finding::new("specimen.path", message, help));
                }
                Err(ReadError::Rows(errors)) => csv_errors = Some(errors),
            }
        }
        found.extend(findings(scene, specimen.as_ref(), &made_up));
        found.retain(|finding| !made_up.iter().any(|path| within(&finding.path, path)));
        placed.extend(place(&text, found, &renamed));
    }
    mention_settings(&text, &mut placed, sets);
    let mut errors = SceneErrors::new(name, &text, placed);
    if let Some(csv) = csv_errors {
        errors.list.extend(csv.list);
        errors.omitted += csv.omitted;
    }
    match scene {
        Some(scene) if errors.list.is_empty() => {
            Ok(LoadedScene { scene, text, path: name.to_owned(), specimen })
        }
        _ => Err(LoadError::Scene(errors)),
    }
}

/// Reads the text, the second time with the patience to find every mistake.
fn parse(text: &str) -> Diagnosis {
    let error = match ron_options().from_str::<Scene>(text) {
        Ok(scene) => {
            let scene = Some(scene);
            return Diagnosis { scene, placed: vec![], made_up: vec![], renamed: vec![] };
        }
        Err(error) => error,
    };
    let mut diagnosis = diagnose(text);
    if diagnosis.placed.is_empty() {
        // The second reading knows the format, not every rule of RON: then `ron` has the word.
        let lines = error.span.start.line.saturating_sub(1);
        let line: usize = text.split_inclusive('\n').take(lines).map(str::len).sum();
        let rest = text.get(line..).unwrap_or_default();
        let column = rest.char_indices().nth(error.span.start.col.saturating_sub(1));
        let at = line + column.map_or(rest.len(), |(at, _)| at);
        let finding = Finding::new("", error.code.to_string(), "");
        diagnosis.placed.push(Placed { at, finding });
    }
    diagnosis
}

/// Says which wrong values do not stand in the file but come from a setting.
fn mention_settings(text: &str, placed: &mut [Placed], sets: &[String]) {
    if placed.is_empty() || sets.is_empty() {
        return;
    }
    let spans = Spans::of(text);
    for Placed { at, finding } in placed {
        let from = sets.iter().rev().find(|set| {
            let path = set.split_once('=').map_or("", |(path, _)| path.trim());
            spans.value(path).is_some_and(|span| span.contains(at))
        });
        if let Some(set) = from {
            finding.message.push_str(&format!(" (from --set {set})"));
        }
    }
}
