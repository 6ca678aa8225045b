//! Frames in a run directory.

use std::fs;
use std::path::{Path, PathBuf};

use super::Frame;
use crate::output::OutputError;
use crate::output::directory::{FRAME_END, FRAME_PEAK, FRAME_START, FRAMES, entries};
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
    if !directory.try_exists().map_err(OutputError::at(&directory))? {
        return Ok(Vec::new());
    }
    let order = |name: &str| match name {
        FRAME_START => Some(0),
        FRAME_PEAK => Some(2),
        FRAME_END => Some(3),
        _ => (name.starts_with("frame_") && name.ends_with(".npz")).then_some(1),
    };
    // Numbers are padded to six digits, so that a longer name has a larger number.
    let key = |name: String| Some((order(&name)?, name.len(), name));
    let mut found: Vec<_> = entries(&directory)?.into_iter().filter_map(key).collect();
    found.sort_unstable();
    Ok(found.into_iter().map(|(.., name)| directory.join(name)).collect())
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
