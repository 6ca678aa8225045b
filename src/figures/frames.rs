//! Moments from the frames of a run.

use std::path::{Path, PathBuf};

use super::FigureError;
use super::moment::Moment;
use super::run::At;

pub fn path(_: &Path, _: &At) -> Option<PathBuf> {
    None
}

pub fn read(_: &Path, _: &At) -> Result<Moment, FigureError> {
    Err(FigureError::Absent("no frames".to_owned()))
}

pub fn all(_: &Path) -> Result<Vec<Moment>, FigureError> {
    Ok(Vec::new())
}
