//! The moments of a run directory.

use std::path::{Path, PathBuf};

use super::{Moment, MomentError};
use crate::frames::Frame;
use crate::output::drive::Drive;
use crate::output::plots::history::History;
use crate::output::{OutputError, directory};

/// A moment of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum At {
    /// The start of the reference stage, or of the run.
    Start,
    /// The peak of the axial stress; without a stress the frame nearest to the peak of the force.
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
    /// The message says what would be right.
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

/// A moment of which a run has a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Listed {
    /// Increment after which it was taken.
    pub increment: u64,
    /// Other names: start, peak, end.
    pub names: Vec<String>,
    /// Stage.
    pub stage: String,
    /// Axial strain, if the scene defines one.
    pub strain: Option<f64>,
}

/// A run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its directory.
    pub directory: PathBuf,
    /// Its history.
    pub history: History,
}

impl Run {
    /// Opens a run directory.
    ///
    /// # Errors
    /// If it has no run.
    pub fn open(directory: &Path) -> Result<Self, OutputError> {
        Ok(Self { directory: directory.to_owned(), history: History::of_run(directory)? })
    }

    /// The state at a moment.
    ///
    /// # Errors
    /// If the run has no frame of it; the message lists those that it has.
    pub fn at(&self, at: &At) -> Result<Moment, MomentError> {
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
            let list = self.list()?;
            let named = list.iter().find(|listed| listed.names.contains(&name));
            if let Some(listed) = named.filter(|_| *at == At::Peak) {
                return self.at(&At::Increment(listed.increment));
            }
            return Err(self.no_frame(&format!("the {name}"), &self.all()?));
        }
        Ok(Moment::of_frame(&Frame::read(&path)?))
    }

    /// The moments that [`at`](Self::at) knows, by increment.
    ///
    /// # Errors
    /// If a frame cannot be read.
    pub fn list(&self) -> Result<Vec<Listed>, MomentError> {
        let mut list: Vec<Listed> = Vec::new();
        for path in crate::frames::list(&self.directory)? {
            let frame = Frame::read(&path)?;
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let name = Some(name).filter(|name| !name.starts_with("frame_"));
            match list.iter_mut().find(|listed| listed.increment == frame.increment) {
                Some(listed) => listed.names.extend(name),
                None => list.push(Listed {
                    increment: frame.increment,
                    names: name.into_iter().collect(),
                    stage: frame.stage,
                    strain: frame.axial_strain,
                }),
            }
        }
        if let Some(nearest) = self.peak_of_force(&list) {
            list[nearest].names.push("peak".to_owned());
        }
        list.sort_by_key(|listed| listed.increment);
        Ok(list)
    }

    /// Place in a list of the frame that is nearest to the peak of the force, the earlier one of two,
    /// for a run without a frame of the peak of a stress.
    fn peak_of_force(&self, list: &[Listed]) -> Option<usize> {
        if list.iter().any(|listed| listed.names.iter().any(|name| name == "peak")) {
            return None;
        }
        let peak = Drive::first(&self.history)?.peak()?.increment;
        let increment = |k: &usize| list[*k].increment;
        (0..list.len()).min_by_key(|k| (increment(k).abs_diff(peak), increment(k)))
    }

    /// All frames that the run has kept, by increment.
    ///
    /// # Errors
    /// If one cannot be read.
    pub fn all(&self) -> Result<Vec<Moment>, MomentError> {
        let frames = crate::frames::series(&self.directory)?;
        Ok(frames.iter().map(Moment::of_frame).collect())
    }

    fn no_frame(&self, of: &str, all: &[Moment]) -> MomentError {
        let mut numbers: Vec<_> = all.iter().map(|moment| moment.increment.to_string()).collect();
        if numbers.len() > 20 {
            numbers.splice(10..numbers.len() - 10, ["...".to_owned()]);
        }
        let kept = match numbers.is_empty() {
            true => "it has none; run the scene again with this clastic".to_owned(),
            false => format!("it has frames of the increments {}", numbers.join(", ")),
        };
        MomentError::Absent(format!("{}: no frame of {of}; {kept}", self.directory.display()))
    }
}
