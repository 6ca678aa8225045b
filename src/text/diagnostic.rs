//! Mistakes of a scene and their places.

use std::fmt;
use std::path::{Path, PathBuf};

use super::edited::EditedText;
use super::shown::brief;
use super::spans::nearest;
use super::tree::Node;

/// Maximum number of diagnostics that are shown.
pub(crate) const MAX_SHOWN: usize = 20;

/// A field of a scene with an invalid value, not yet assigned to a place in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Path of the field; see [`spans`](super::spans).
    pub path: String,
    /// The mistake, with the offending value.
    pub message: String,
    /// The remedy.
    pub help: Option<String>,
    /// Whether the finding concerns the key of the field instead of its value.
    pub at_key: bool,
}

impl Finding {
    /// A finding about the value of a field.
    pub fn new(
        path: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        let help = Some(help.into()).filter(|help| !help.is_empty());
        Self { path: path.into(), message: message.into(), help, at_key: false }
    }

    /// The same about the key of the field.
    pub(crate) fn at_key(self) -> Self {
        Self { at_key: true, ..self }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        say(f, &self.path, &self.message, self.help.as_deref())
    }
}

/// A finding with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// File: the scene, or the stored specimen that it names.
    pub file: PathBuf,
    /// Line of the file, from 1. For a mistake in a setting it is the line that the setting
    /// changes.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The setting, `path=value`, that inserted the text; `None` for text of the file.
    pub set: Option<String>,
    /// Path of the field, or name of the column of a stored specimen.
    pub path: String,
    /// The mistake, with the offending value.
    pub message: String,
    /// The remedy.
    pub help: Option<String>,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.set {
            Some(set) => write!(f, "--set {}: ", brief(set))?,
            None => write!(f, "{}:{}:{}: ", self.file.display(), self.line, self.column)?,
        }
        say(f, &self.path, &self.message, self.help.as_deref())
    }
}

fn say(f: &mut fmt::Formatter<'_>, path: &str, message: &str, help: Option<&str>) -> fmt::Result {
    if !path.is_empty() {
        write!(f, "{}: ", brief(path))?;
    }
    f.write_str(&brief(message))?;
    help.map_or(Ok(()), |help| write!(f, "; {}", brief(help)))
}

/// All mistakes of a scene, in the order of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneErrors {
    /// The scene file.
    pub file: PathBuf,
    /// The diagnostics, at most `MAX_SHOWN` of them.
    pub list: Vec<Diagnostic>,
    /// Number of further mistakes that were found.
    pub omitted: usize,
}

impl fmt::Display for SceneErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (file, omitted) = (self.file.display(), self.omitted);
        let more = (omitted > 0).then(|| format!("{file}: and {omitted} more"));
        let lines = self.list.iter().map(Diagnostic::to_string).chain(more);
        f.write_str(&lines.collect::<Vec<_>>().join("\n"))
    }
}

impl std::error::Error for SceneErrors {}

/// A finding at a byte of a text.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub at: usize,
    pub finding: Finding,
}

/// Assigns findings to places in a tree. `renamed` contains the misspelt fields of the text: the
/// correct path and the path as written, outer fields first.
pub(crate) fn place(
    root: &Node,
    findings: Vec<Finding>,
    renamed: &[(String, String)],
) -> Vec<Placed> {
    let written = |path: &str| {
        renamed.iter().rev().fold(path.to_owned(), |path, (meant, written)| {
            let rest = path.strip_prefix(meant).filter(|_| within(&path, meant));
            rest.map_or(path.clone(), |rest| format!("{written}{rest}"))
        })
    };
    let at = |finding: &Finding| nearest(root, &written(&finding.path), finding.at_key);
    findings.into_iter().map(|finding| Placed { at: at(&finding), finding }).collect()
}

/// Whether a path equals another path or is a part of it.
pub(crate) fn within(path: &str, whole: &str) -> bool {
    let rest = path.strip_prefix(whole);
    rest.is_some_and(|rest| whole.is_empty() || rest.is_empty() || rest.starts_with(['.', '[']))
}

impl SceneErrors {
    /// Sorts findings by their place, and counts lines and columns for those that are shown.
    pub(crate) fn new(file: &Path, text: &EditedText, mut placed: Vec<Placed>) -> Self {
        placed.sort_by_key(|placed| placed.at);
        let omitted = placed.len().saturating_sub(MAX_SHOWN);
        placed.truncate(MAX_SHOWN);
        let list = placed
            .into_iter()
            .map(|Placed { at, finding: Finding { path, message, help, .. } }| {
                let source = text.source(at);
                let (line, column) = line_and_column(&text.file, source.at);
                let set = source.set.map(str::to_owned);
                Diagnostic { file: file.to_owned(), line, column, set, path, message, help }
            })
            .collect();
        Self { file: file.to_owned(), list, omitted }
    }
}

/// Line and column, from 1, of a byte of a text.
pub(crate) fn line_and_column(text: &str, at: usize) -> (usize, usize) {
    let before = text.get(..at).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (1 + before.matches('\n').count(), 1 + before[start..].chars().count())
}
