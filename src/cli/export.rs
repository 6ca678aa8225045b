//! `clastic export`: the frames of a run for other programs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::export;
use crate::moment::MomentError;
use crate::moment::run::{At, Run};

use super::exit::{Exit, Failure, say};

/// Arguments of an export.
#[derive(Args)]
pub struct ExportArgs {
    /// Directory of the run
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Format
    #[arg(long, value_enum)]
    format: Format,
    /// Only this moment: start, peak, end, or the number of an increment; may be repeated [default:
    /// all frames]
    #[arg(long = "frame", value_name = "MOMENT", value_parser = At::read)]
    frames: Vec<At>,
    /// Directory for the files [default: DIR/vtk or DIR/csv]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl From<MomentError> for Failure {
    fn from(error: MomentError) -> Self {
        Self { exit: Exit::Files, message: error.to_string() }
    }
}

/// A format.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// VTK XML (.vtp) with series (.pvd), for ParaView
    Vtk,
    /// Tables
    Csv,
}

/// Exports a run.
pub fn export(args: &ExportArgs) -> Result<Exit, Failure> {
    let run = Run::open(&args.directory)?;
    let mut moments = if args.frames.is_empty() {
        run.all()?
    } else {
        args.frames.iter().map(|at| run.at(at)).collect::<Result<Vec<_>, _>>()?
    };
    // A series goes forward, and has every frame once.
    moments.sort_by_key(|moment| moment.increment);
    moments.dedup_by_key(|moment| moment.increment);
    if moments.is_empty() {
        let message = format!(
            "{}: no frames; run the scene again with this clastic",
            args.directory.display()
        );
        return Err(Failure { exit: Exit::Files, message });
    }
    let name = match args.format {
        Format::Vtk => "vtk",
        Format::Csv => "csv",
    };
    let folder = args.out.clone().unwrap_or_else(|| args.directory.join(name));
    match args.format {
        Format::Vtk => export::vtk(&moments, &folder)?,
        Format::Csv => export::csv(&moments, &folder)?,
    }
    say(format_args!("{} frames: {}", moments.len(), folder.display()))?;
    Ok(Exit::Ok)
}
