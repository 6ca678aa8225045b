//! Frames in a run directory.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::Frame;
use crate::tables::{TableError, Tables};

/// Directory of the frames in a run directory.
const DIRECTORY: &str = "frames";

/// Why a frame cannot be read or written. The message of [`Frame::read`] and [`list`] names the
/// file.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The file or one of its arrays is wrong.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The arrays hold another kind of data.
    #[error("not a frame; give a `.npz` file of the folder `frames` of a run")]
    Foreign,
    /// The file is of another version of the format.
    #[error("a frame of format {0}, which this clastic does not read; run the scene again")]
    Version(String),
    /// What is wrong with a file.
    #[error("{}: {source}", path.display())]
    In {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<FrameError>,
    },
    /// A file or directory cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
}

impl Frame {
    /// Content of the file of a frame.
    ///
    /// # Errors
    /// If the program is built without the feature `npz`.
    pub fn encode(&self) -> Result<Vec<u8>, TableError> {
        self.tables().encode()
    }

    /// The frame of the content of a file.
    ///
    /// # Errors
    /// If it is no frame, or damaged.
    pub fn decode(bytes: &[u8]) -> Result<Self, FrameError> {
        Self::from_tables(&Tables::decode(bytes)?)
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// If the file cannot be read, or is no frame. The message names the file.
    pub fn read(path: &Path) -> Result<Self, FrameError> {
        let io = |source| FrameError::Io { path: path.to_owned(), source };
        let within = |source| FrameError::In { path: path.to_owned(), source: Box::new(source) };
        Self::decode(&fs::read(path).map_err(io)?).map_err(within)
    }
}

/// Files of frames in a run directory: `start.npz`, then those by increment, then `peak.npz` and
/// `end.npz`. Empty if the run has none.
///
/// # Errors
/// If the directory cannot be read.
pub fn list(run: &Path) -> Result<Vec<PathBuf>, FrameError> {
    let directory = run.join(DIRECTORY);
    let failed = |source| FrameError::Io { path: directory.clone(), source };
    let mut found: Vec<(u8, PathBuf)> = Vec::new();
    let entries = match fs::read_dir(&directory) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(failed)?,
    };
    for entry in entries {
        let path = entry.map_err(failed)?.path();
        let order = match path.file_name().and_then(|name| name.to_str()).unwrap_or_default() {
            "start.npz" => 0,
            "peak.npz" => 2,
            "end.npz" => 3,
            name if name.starts_with("frame_") && name.ends_with(".npz") => 1,
            _ => continue,
        };
        found.push((order, path));
    }
    // Numbers have six digits; longer ones follow.
    found.sort_by(|(a, x), (b, y)| {
        (a, x.as_os_str().len(), x.as_os_str()).cmp(&(b, y.as_os_str().len(), y.as_os_str()))
    });
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

/// The frames of a run in the order of increments, one for each increment.
///
/// # Errors
/// If a frame cannot be read.
pub fn series(run: &Path) -> Result<Vec<Frame>, FrameError> {
    let frames: Result<Vec<_>, _> = list(run)?.iter().map(|path| Frame::read(path)).collect();
    let mut frames = frames?;
    frames.sort_by_key(|frame| frame.increment);
    frames.dedup_by_key(|frame| frame.increment);
    Ok(frames)
}
