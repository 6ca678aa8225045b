//! Errors of the output.

use std::error::Error;
use std::path::{Path, PathBuf};

use super::directory;

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The directory is not empty.
    #[error("{}: not empty; choose another directory with --out, or write over it with --force", .0.display())]
    Exists(PathBuf),
    /// Another run is writing to the directory.
    #[error("{}: a run is still writing here; wait for it or stop it, or choose another directory with --out", .0.display())]
    InUse(PathBuf),
    /// The directory holds no run.
    #[error("{}: no run is here (no {}); give the directory of a run, such as runs/NAME", .0.display(), directory::RUN)]
    NoRun(PathBuf),
    /// The run cannot be resumed, since it has no checkpoint.
    #[error(
        "{}: no checkpoint is here; a run writes one with --checkpoint-every N, when Ctrl-C, SIGTERM or \
         SIGHUP interrupts it, when an increment stalls and when a stage cannot begin. Run the scene again, \
         with --force", .0.display()
    )]
    NoCheckpoint(PathBuf),
    /// A file or directory cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// Error of the system, or what is wrong with the content.
        source: Box<dyn Error + Send + Sync>,
    },
}

impl OutputError {
    /// Adds the name of the file to an error; for use in `map_err`.
    pub fn at<E: Into<Box<dyn Error + Send + Sync>>>(path: &Path) -> impl FnOnce(E) -> Self {
        |source| Self::Io { path: path.to_owned(), source: source.into() }
    }
}
