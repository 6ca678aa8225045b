//! A run directory that figures are made of.

use std::path::{Path, PathBuf};

use glam::DVec2;

use super::moment::Moment;
use super::{FigureError, frames, saved};
use crate::output::plots::history::History;
use crate::output::{OutputError, directory};
use crate::tables::Tables;

/// A moment of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum At {
    /// The start of the reference stage, or of the run.
    Start,
    /// The peak of the axial stress.
    Peak,
    /// The end.
    End,
    /// After an increment of the run.
    Increment(u64),
    /// A saved state.
    State(PathBuf),
}

impl At {
    /// Reads `start`, `peak`, `end`, a number, or the path of a `.npz` file.
    ///
    /// # Errors
    /// With what would be right.
    pub fn read(text: &str) -> Result<Self, String> {
        match text {
            "start" => Ok(Self::Start),
            "peak" => Ok(Self::Peak),
            "end" => Ok(Self::End),
            path if path.ends_with(".npz") => Ok(Self::State(path.into())),
            number => number.parse().map(Self::Increment).map_err(|_| {
                "write start, peak, end, the number of an increment, or the path of a saved state"
                    .to_owned()
            }),
        }
    }
}

/// A run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its directory.
    pub directory: PathBuf,
    /// Name in legends.
    pub name: String,
    /// Title of the scene.
    pub title: String,
    /// Content of `run.json`.
    pub record: serde_json::Value,
    /// Its history.
    pub history: History,
}

impl Run {
    /// Opens a run directory.
    ///
    /// # Errors
    /// If it has no run.
    pub fn open(directory: &Path, name: String) -> Result<Self, OutputError> {
        let record = directory::record(directory)?;
        Ok(Self {
            directory: directory.to_owned(),
            name,
            title: record["title"].as_str().unwrap_or_default().to_owned(),
            history: History::of_run(directory)?,
            record,
        })
    }

    /// The state at a moment. Without a frame of the end it is that of `final_state.npz`.
    ///
    /// # Errors
    /// If the run has no frame of it.
    pub fn at(&self, at: &At) -> Result<Moment, FigureError> {
        match at {
            At::State(path) => state(path),
            At::End if frames::path(&self.directory, at).is_none() => {
                state(&self.directory.join(directory::FINAL_STATE))
            }
            at => frames::read(&self.directory, at),
        }
    }

    /// All states that the run has kept, by increment.
    ///
    /// # Errors
    /// If one cannot be read.
    pub fn all(&self) -> Result<Vec<Moment>, FigureError> {
        frames::all(&self.directory)
    }

    /// Normals and modes (0 tension, 1 shear, 2 rolling) of the bonds that broke up to an increment.
    ///
    /// # Errors
    /// If `events.csv` cannot be read.
    pub fn ruptures(&self, until: u64) -> Result<Vec<(DVec2, usize)>, FigureError> {
        let path = self.directory.join(directory::EVENTS);
        let mut reader = csv::Reader::from_path(&path).map_err(OutputError::at(&path))?;
        let header = reader.headers().map_err(OutputError::at(&path))?.clone();
        let column = |name: &str| header.iter().position(|field| field == name);
        let columns = ["increment", "mode", "normal_x", "normal_y"].map(column);
        let [Some(increment), Some(mode), Some(x), Some(y)] = columns else {
            let what = format!("{}: a column is missing", path.display());
            return Err(FigureError::Absent(what));
        };
        let mut list = Vec::new();
        for row in reader.records() {
            let row = row.map_err(OutputError::at(&path))?;
            let number = |k: usize| row.get(k).and_then(|field| field.parse::<f64>().ok());
            let mode =
                ["tension", "shear", "rolling"].iter().position(|m| row.get(mode) == Some(m));
            if let (Some(at), Some(x), Some(y), Some(mode)) =
                (number(increment), number(x), number(y), mode)
                && at <= until as f64
            {
                list.push((DVec2::new(x, y), mode));
            }
        }
        Ok(list)
    }
}

/// A saved state.
fn state(path: &Path) -> Result<Moment, FigureError> {
    let bytes = std::fs::read(path).map_err(OutputError::at(path))?;
    let wrong = |what: String| FigureError::Absent(format!("{}: {what}", path.display()));
    let tables = Tables::decode(&bytes).map_err(|error| wrong(error.to_string()))?;
    saved::moment(&tables).map_err(|error| wrong(error.to_string()))
}
