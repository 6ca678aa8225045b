//! What can go wrong with output.

use std::io;
use std::path::{Path, PathBuf};

use super::directory;

/// Why something could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The directory holds something already.
    #[error("{}: not empty; choose another directory with --out, or write over it with --force", .0.display())]
    Exists(PathBuf),
    /// Another run is under way there.
    #[error("{}: a run is still writing here; wait for it or stop it, or choose another directory with --out", .0.display())]
    InUse(PathBuf),
    /// The directory holds no run.
    #[error("{}: no run is here (no {}); give the directory of a run, such as runs/NAME", .0.display(), directory::RUN)]
    NoRun(PathBuf),
    /// A file or directory cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

impl OutputError {
    /// Names the file to which an error belongs; for use in `map_err`.
    pub fn at<E: Into<io::Error>>(path: &Path) -> impl FnOnce(E) -> Self {
        |source| Self::Io { path: path.to_owned(), source: source.into() }
    }
}
