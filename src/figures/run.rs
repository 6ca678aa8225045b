//! A run directory that figures are made of.

use std::path::{Path, PathBuf};

use glam::DVec2;

use super::FigureError;
use super::moment::Moment;
use crate::frames::Frame;
use crate::output::plots::history::History;
use crate::output::{OutputError, directory};

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
    /// The frame in a file.
    File(PathBuf),
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
            path if path.ends_with(".npz") => Ok(Self::File(path.into())),
            number => number.parse().map(Self::Increment).map_err(|_| {
                "write start, peak, end, the number of an increment, or the path of a frame (.npz)"
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

    /// The state at a moment.
    ///
    /// # Errors
    /// If the run has no frame of it; the message lists those that it has.
    pub fn at(&self, at: &At) -> Result<Moment, FigureError> {
        let frames = self.directory.join(directory::FRAMES);
        let path = match at {
            At::Start => frames.join(directory::FRAME_START),
            At::Peak => frames.join(directory::FRAME_PEAK),
            At::End => frames.join(directory::FRAME_END),
            At::File(path) => path.clone(),
            At::Increment(increment) => {
                let all = self.all()?;
                let found = all.iter().position(|moment| moment.increment == *increment);
                return match found {
                    Some(found) => Ok(all.into_iter().nth(found).unwrap_or_default()),
                    None => Err(self.no_frame(&format!("increment {increment}"), &all)),
                };
            }
        };
        if !path.exists() && !matches!(at, At::File(_)) {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            return Err(self.no_frame(&format!("the {name}"), &self.all()?));
        }
        Ok(Moment::of_frame(&Frame::read(&path)?))
    }

    /// All frames that the run has kept, by increment.
    ///
    /// # Errors
    /// If one cannot be read.
    pub fn all(&self) -> Result<Vec<Moment>, FigureError> {
        let frames = crate::frames::series(&self.directory)?;
        Ok(frames.iter().map(Moment::of_frame).collect())
    }

    fn no_frame(&self, of: &str, all: &[Moment]) -> FigureError {
        let mut numbers: Vec<_> = all.iter().map(|moment| moment.increment.to_string()).collect();
        if numbers.len() > 20 {
            numbers.splice(10..numbers.len() - 10, ["...".to_owned()]);
        }
        let kept = match numbers.is_empty() {
            true => "it has none; run the scene again with this clastic".to_owned(),
            false => format!("it has frames of the increments {}", numbers.join(", ")),
        };
        FigureError::Absent(format!("{}: no frame of {of}; {kept}", self.directory.display()))
    }

    /// Normals and modes (0 tension, 1 shear, 2 rolling) of bonds that broke up to an increment.
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
