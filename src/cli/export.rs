//! `clastic export`: the frames of a run for ParaView.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::export;
use crate::frames::{Frame, series};
use crate::output::directory;
use crate::output::drive::Drive;
use crate::output::read_history::History;

use super::exit::{Exit, Failure, say};

/// Arguments of an export.
#[derive(Args)]
pub(crate) struct ExportArgs {
    /// Directory of the run
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Only this moment: start, peak, end, or the number of an increment; may be repeated [default:
    /// all frames]
    #[arg(long = "frame", value_name = "MOMENT", value_parser = At::read)]
    frames: Vec<At>,
    /// Directory for the files [default: DIR/vtk]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A moment of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
enum At {
    /// The start of the reference stage, the peak of the axial stress, or the end, by the file of
    /// its frame. Without a stress the peak is the frame nearest to the peak of the force.
    Named(&'static str),
    /// After an increment of the run.
    Increment(u64),
    /// The frame in a file.
    File(PathBuf),
}

impl At {
    /// Reads `start`, `peak`, `end`, a number, or the path of a `.npz` file.
    fn read(text: &str) -> Result<Self, String> {
        match text {
            "start" => Ok(Self::Named(directory::FRAME_START)),
            "peak" => Ok(Self::Named(directory::FRAME_PEAK)),
            "end" => Ok(Self::Named(directory::FRAME_END)),
            path if path.ends_with(".npz") => Ok(Self::File(path.into())),
            number => number.parse().map(Self::Increment).map_err(|_| {
                "write start, peak, end, the number of an increment, or the path of a frame (.npz)"
                    .to_owned()
            }),
        }
    }

    fn frame(&self, run: &Path) -> Result<Frame, Failure> {
        let (what, wanted) = match self {
            Self::File(path) => return Ok(Frame::read(path)?),
            Self::Increment(increment) => (format!("increment {increment}"), Some(*increment)),
            Self::Named(name) => {
                let path = run.join(directory::FRAMES).join(name);
                if path.exists() {
                    return Ok(Frame::read(&path)?);
                }
                let drive = match *name {
                    directory::FRAME_PEAK => Drive::first(&History::of_run(run)?),
                    _ => None,
                };
                let peak = drive.and_then(|drive| Some(drive.peak()?.increment));
                (format!("the {}", name.trim_end_matches(".npz")), peak)
            }
        };
        let all = series(run)?;
        let mut numbers: Vec<_> = all.iter().map(|frame| frame.increment.to_string()).collect();
        let is_exact = matches!(self, Self::Increment(_));
        let nearest = wanted.and_then(|wanted| {
            let away = |frame: &Frame| (frame.increment.abs_diff(wanted), frame.increment);
            let nearest = all.into_iter().min_by_key(away)?;
            Some(nearest).filter(|frame| !is_exact || frame.increment == wanted)
        });
        nearest.ok_or_else(|| {
            if numbers.len() > 20 {
                numbers.splice(10..numbers.len() - 10, ["...".to_owned()]);
            }
            let kept = match numbers.is_empty() {
                true => "it has none; run the scene again with this clastic".to_owned(),
                false => format!("it has frames of the increments {}", numbers.join(", ")),
            };
            let run = run.display();
            Failure::new(Exit::Files, format_args!("{run}: no frame of {what}; {kept}"))
        })
    }
}

pub fn export(args: &ExportArgs) -> Result<Exit, Failure> {
    let run = &args.directory;
    directory::record(run)?;
    let mut frames = if args.frames.is_empty() {
        series(run)?
    } else {
        args.frames.iter().map(|at| at.frame(run)).collect::<Result<_, _>>()?
    };
    // A series goes forward, and has every frame once.
    frames.sort_by_key(|frame| frame.increment);
    frames.dedup_by_key(|frame| frame.increment);
    if frames.is_empty() {
        let run = run.display();
        let message = format!("{run}: no frames; run the scene again with this clastic");
        return Err(Failure::new(Exit::Files, message));
    }
    let folder = args.out.clone().unwrap_or_else(|| run.join("vtk"));
    export::vtk(&frames, &folder)?;
    say(format_args!("{} frames: {}", frames.len(), folder.display()))?;
    Ok(Exit::Ok)
}
