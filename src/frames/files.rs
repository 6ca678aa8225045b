//! Frames in a run directory.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::Frame;
use crate::output::OutputError;
use crate::output::directory::{FRAME_END, FRAME_PEAK, FRAME_START, FRAMES};
use crate::tables::Tables;

impl Frame {
    /// Reads a frame.
    ///
    /// # Errors
    /// If the file cannot be read, or is no frame.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let bytes = fs::read(path).map_err(OutputError::at(path))?;
        let tables = Tables::decode(&bytes).map_err(OutputError::at(path))?;
        Self::from_tables(&tables).map_err(OutputError::at(path))
    }
}

/// Files of frames in a run directory: `start.npz`, then those by increment, then `peak.npz` and
/// `end.npz`. Empty if the run has none.
///
/// # Errors
/// If the directory cannot be read.
pub fn list(run: &Path) -> Result<Vec<PathBuf>, OutputError> {
    let directory = run.join(FRAMES);
    let mut found: Vec<(u8, PathBuf)> = Vec::new();
    let entries = match fs::read_dir(&directory) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(OutputError::at(&directory))?,
    };
    for entry in entries {
        let path = entry.map_err(OutputError::at(&directory))?.path();
        let order = match path.file_name().and_then(|name| name.to_str()).unwrap_or_default() {
            FRAME_START => 0,
            FRAME_PEAK => 2,
            FRAME_END => 3,
            name if name.starts_with("frame_") && name.ends_with(".npz") => 1,
            _ => continue,
        };
        found.push((order, path));
    }
    // Numbers are padded to six digits, so that a longer name has a larger number.
    found.sort_by(|(a, x), (b, y)| {
        (a, x.as_os_str().len(), x.as_os_str()).cmp(&(b, y.as_os_str().len(), y.as_os_str()))
    });
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

/// The frames of a run in the order of increments, one for each increment.
///
/// # Errors
/// If a frame cannot be read.
pub fn series(run: &Path) -> Result<Vec<Frame>, OutputError> {
    let frames: Result<Vec<_>, _> = list(run)?.iter().map(|path| Frame::read(path)).collect();
    let mut frames = frames?;
    frames.sort_by_key(|frame| frame.increment);
    frames.dedup_by_key(|frame| frame.increment);
    Ok(frames)
}
