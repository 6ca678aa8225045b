//! Reading a scene.

use std::io;
use std::path::{Path, PathBuf};

use super::files::{decode, read_at_most};
use super::format::{Scene, Specimen};
use super::overrides::{SetError, apply};
use super::repeats::Written;
use super::specimen_file::{ReadError, StoredSpecimen, read};
use super::stored_state::{self, inherit};
use super::validate::findings;
use crate::text::courses::gather;
use crate::text::diagnostic::{Finding, Placed, SceneErrors, place, within};
use crate::text::edited::EditedText;
use crate::text::read;
use crate::text::scan::scan;
use crate::text::values;

/// A scene that was read and checked.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// Content of the scene.
    pub scene: Scene,
    /// Text with settings applied.
    pub text: String,
    /// Path of the file.
    pub path: PathBuf,
    /// The stored specimen that the scene names.
    pub specimen: Option<StoredSpecimen>,
}

impl LoadedScene {
    /// File of the stored specimen or saved state that the scene names.
    pub(crate) fn specimen_file(&self) -> Option<PathBuf> {
        match &self.scene.specimen {
            Specimen::File { path, .. } | Specimen::State { path, .. } => {
                Some(self.path.parent().unwrap_or(Path::new("")).join(path))
            }
            _ => None,
        }
    }
}

/// Why a scene cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The scene file cannot be read.
    #[error("{}: cannot read the scene: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The path of a setting does not exist, or its value does not fit.
    #[error(transparent)]
    Set(SetError),
    /// The scene, or the stored specimen that it names, is wrong.
    #[error(transparent)]
    Scene(SceneErrors),
}

/// Reads and checks a scene file with settings of the form `path=value`; see
/// [`overrides`](super::overrides).
///
/// # Errors
/// See [`LoadError`]. All mistakes of a scene are reported at once.
pub fn load(path: &Path, sets: &[String]) -> Result<LoadedScene, LoadError> {
    load_with(path, sets, true, |_| Vec::new())
}

/// Like [`load`], with further findings of the program that runs the scene. Of a scene that is not
/// prepared the saved state is still to be made: what depends on the state is not checked, and the
/// scene that it returns has no specimen.
///
/// # Errors
/// See [`LoadError`].
pub fn load_with(
    path: &Path,
    sets: &[String],
    is_prepared: bool,
    further: impl FnOnce(&Scene) -> Vec<Finding>,
) -> Result<LoadedScene, LoadError> {
    let read_error = |source| LoadError::Read { path: path.to_owned(), source };
    let bytes = read_at_most(path, MAX_BYTES).map_err(read_error)?;
    let refuse = |(text, placed): (String, Placed)| {
        LoadError::Scene(SceneErrors::new(path, &EditedText::of(&text), vec![placed]))
    };
    let Some(bytes) = bytes else {
        let message = format!("more than {} MB of text", MAX_BYTES / 1_000_000);
        let help = "keep many particles in a stored specimen, `File(path: ...)`";
        let finding = Finding::new("", message, help);
        return Err(refuse((String::new(), Placed { at: 0, finding })));
    };
    let text = decode(bytes, "save the scene as UTF-8").map_err(refuse)?;
    let base = path.parent().unwrap_or(Path::new(""));
    let read = |specimen: &Specimen| match specimen {
        Specimen::State { .. } if !is_prepared => Ok(None),
        _ => read_specimen(base, specimen),
    };
    from_text(&text, path, sets, read, further)
}

/// Maximum size of a scene file, bytes. Reading it takes about twenty times as much memory.
const MAX_BYTES: u64 = 100_000_000;

/// Reads and checks a scene from a text. `name` stands for the file in messages. The stored
/// specimen is read from the directory `base`.
///
/// # Errors
/// See [`LoadError`].
pub fn from_str(
    text: &str,
    name: &Path,
    base: &Path,
    sets: &[String],
) -> Result<LoadedScene, LoadError> {
    from_text(text, name, sets, |specimen| read_specimen(base, specimen), |_| Vec::new())
}

/// Reads and checks a scene whose particles exist already. `stored` replaces the specimen file, if
/// the scene names one.
///
/// # Errors
/// See [`LoadError`].
pub fn from_str_with(
    text: &str,
    name: &Path,
    stored: StoredSpecimen,
    sets: &[String],
) -> Result<LoadedScene, LoadError> {
    from_text(text, name, sets, |_| Ok(Some(stored)), |_| Vec::new())
}

/// Reads the file that a specimen names; `None` if it names none.
fn read_specimen(base: &Path, specimen: &Specimen) -> Result<Option<StoredSpecimen>, ReadError> {
    match specimen {
        Specimen::File { path, .. } => read(&base.join(path)).map(Some),
        Specimen::State { path, .. } => stored_state::read(&base.join(path)).map(Some),
        _ => Ok(None),
    }
}

fn from_text(
    text: &str,
    name: &Path,
    sets: &[String],
    read: impl FnOnce(&Specimen) -> Result<Option<StoredSpecimen>, ReadError>,
    further: impl FnOnce(&Scene) -> Vec<Finding>,
) -> Result<LoadedScene, LoadError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let edited = apply(text, sets).map_err(LoadError::Set)?;
    let (root, mut placed) = scan(&edited.text);
    let Some(mut root) = root else {
        return Err(LoadError::Scene(SceneErrors::new(name, &edited, placed)));
    };
    let before = if sets.is_empty() { None } else { scan(text).0 };
    let spared = before.as_ref().map(values::used).unwrap_or_default();
    let values = values::put_in(&mut root, &spared);
    let (mut scene, mut notes) = read::read::<Scene>(&root);
    notes.made_up.extend(values.made_up);
    placed.extend(values.placed.into_iter().chain(notes.placed));
    let mut csv_errors = None;
    let mut specimen = None;
    if let Some(scene) = &mut scene {
        let mut found = Vec::new();
        if let Specimen::File { .. } | Specimen::State { .. } = &scene.specimen {
            match read(&scene.specimen) {
                Ok(stored) => specimen = stored,
                Err(ReadError::File(message)) => {
                    let help = "the path is relative to the scene file";
                    found.push(Finding::new("specimen.path", message, help));
                }
                Err(ReadError::Rows(errors)) => csv_errors = Some(errors),
            }
        }
        if let Some(stored) = &mut specimen {
            inherit(scene, stored);
        }
        let mut unsure = notes.made_up.clone();
        if matches!(scene.specimen, Specimen::State { .. }) && specimen.is_none() {
            // The names of a state that cannot be read are unknown.
            unsure.push("specimen".to_owned());
            unsure.extend(scene.walls.is_empty().then(|| "walls".to_owned()));
            unsure.extend(scene.cell.is_none().then(|| "cell".to_owned()));
        }
        found.extend(findings(scene, specimen.as_ref(), &unsure));
        found.extend(further(scene));
        let written = Written::of(&root);
        let mut found = written.place(found);
        found.extend(written.findings);
        found.retain(|finding| !notes.made_up.iter().any(|path| within(&finding.path, path)));
        placed.extend(gather(place(&root, found, &notes.renamed), &values.tables));
    }
    if let Some(error) = addressed_nothing(&edited, &placed) {
        return Err(LoadError::Set(error));
    }
    let mut errors = SceneErrors::new(name, &edited, placed);
    if let Some(csv) = csv_errors {
        errors.list.extend(csv.list);
        errors.omitted += csv.omitted;
    }
    match scene {
        Some(scene) if errors.list.is_empty() => {
            let text = edited.text;
            Ok(LoadedScene { scene, text, path: name.to_owned(), specimen })
        }
        _ => Err(LoadError::Scene(errors)),
    }
}

/// A finding about a scene that was read, with its place in the text, whose file is `name`.
#[cfg(feature = "cli")]
pub(crate) fn placed(name: &Path, text: &str, finding: Finding) -> SceneErrors {
    let root = scan(text).0;
    let found = root.map(|root| place(&root, Written::of(&root).place(vec![finding]), &[]));
    SceneErrors::new(name, &EditedText::of(text), found.unwrap_or_default())
}

/// The first setting whose path names a key that does not exist and that the setting itself
/// inserted.
fn addressed_nothing(text: &EditedText, placed: &[Placed]) -> Option<SetError> {
    placed.iter().filter(|placed| placed.finding.at_key).find_map(|Placed { at, finding }| {
        let set = text.source(*at).set?.to_owned();
        let message = format!("{}: {}", finding.path, finding.message);
        Some(SetError { set, message, help: finding.help.clone() })
    })
}
