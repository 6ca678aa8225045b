//! Errors of the output.

use std::io;
use std::path::{Path, PathBuf};

use super::names;

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
    #[error("{}: no run is here (no {}); give the directory of a run, such as runs/NAME", .0.display(), names::RUN)]
    NoRun(PathBuf),
    /// A file or directory cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
}

impl OutputError {
    /// Adds the name of the file to an error; for use in `map_err`.
    pub fn at<E: Into<io::Error>>(path: &Path) -> impl FnOnce(E) -> Self {
        |source| Self::Io { path: path.to_owned(), source: source.into() }
    }
}

/// Why a run cannot be resumed.
#[derive(Debug, thiserror::Error)]
pub enum ResumeError {
    /// The checkpoint does not exist.
    #[error(
        "{}: no checkpoint is here; a run writes one with --checkpoint-every N, when Ctrl-C, SIGTERM or \
         SIGHUP interrupts it, when an increment stalls and when a stage cannot begin. Run the scene again, \
         with --force", .0.display()
    )]
    NoCheckpoint(PathBuf),
    /// The checkpoint has another version of the format.
    #[error(
        "{}: a checkpoint of format {found}, and this clastic reads format {ours}; resume it with the \
         clastic that wrote it, or run the scene again, with --force", path.display()
    )]
    Version {
        /// The checkpoint.
        path: PathBuf,
        /// Version of the checkpoint.
        found: String,
        /// Version that this program reads.
        ours: u32,
    },
    /// The content of the checkpoint is damaged.
    #[error("{}: damaged ({what}); run the scene again, with --force", path.display())]
    Damaged {
        /// The checkpoint.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The checkpoint does not belong to the scene beside it.
    #[error(
        "{}: a checkpoint of another scene than {} beside it; put back the one that was run (sha256 {expected}), \
         and change settings with --set", path.display(), names::SCENE
    )]
    OtherScene {
        /// The checkpoint.
        path: PathBuf,
        /// Hash of the scene of the checkpoint.
        expected: String,
    },
    /// A file to be continued has changed.
    #[error("{}: {what}; run the scene again, with --force", path.display())]
    Cut {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A file cannot be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
}
