//! `clastic plot`: a figure of run directories, at a given width and size of the font.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::figures::run::{At, Listed, Run};
use crate::figures::{FIGURES, FigureError, Request, named, pages};
use crate::output::OutputError;
use crate::output::atomic::write_atomic;
use crate::output::plots::page::Style;

use super::compare::names;
use super::exit::{Exit, Failure, say};

/// Arguments of a figure.
#[derive(Args)]
pub struct PlotArgs {
    /// Directories of runs; several for curves over one another
    #[arg(value_name = "DIR", required_unless_present = "list")]
    runs: Vec<PathBuf>,
    /// Name of the figure
    #[arg(long, value_name = "NAME", required_unless_present = "list")]
    figure: Option<String>,
    /// List the figures, or the frames of the runs that are given
    #[arg(long)]
    list: bool,
    /// Moment of the specimen: start, peak, end, the number of an increment that has a frame, or the
    /// file of a frame (.npz)
    #[arg(long, value_name = "MOMENT", default_value = "end", value_parser = At::read)]
    frame: At,
    /// Moment from which displacements, rotations and strains count, as for --frame
    #[arg(long, value_name = "MOMENT", default_value = "start", value_parser = At::read)]
    since: At,
    /// Width, mm
    #[arg(long, value_name = "MM", default_value_t = 84.0, value_parser = length(20.0, 1000.0))]
    width: f64,
    /// Size of the font, pt
    #[arg(long, value_name = "PT", default_value_t = 8.0, value_parser = length(3.0, 72.0))]
    font: f64,
    /// Show only the part between two corners: in m for the specimen, in values of the axes for
    /// curves
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true, value_parser = window)]
    crop: Option<[[f64; 2]; 2]>,
    /// Draw broken bonds over fields
    #[arg(long)]
    cracks: bool,
    /// Write the title of the scene over the figure
    #[arg(long)]
    title: bool,
    /// File, whose ending (.svg, .pdf, .png) is the format [default: DIR/figures/NAME.svg]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Resolution of a .png, pixels per inch
    #[arg(long, value_name = "N", default_value_t = 300.0, value_parser = length(30.0, 2400.0))]
    dpi: f64,
}

/// A number between two limits.
fn length(low: f64, high: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text: &str| {
        let value = text.parse().ok().filter(|value| (low..=high).contains(value));
        value.ok_or_else(|| format!("write a number from {low} to {high}"))
    }
}

fn window(text: &str) -> Result<[[f64; 2]; 2], &'static str> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.as_deref() {
        Some([x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok([[*x0, *y0], [*x1, *y1]]),
        _ => Err("write the lower left and the upper right corner, as in 0,0,0.02,0.05"),
    }
}

impl From<FigureError> for Failure {
    fn from(error: FigureError) -> Self {
        let exit = match error {
            FigureError::Usage(_) => Exit::Usage,
            _ => Exit::Files,
        };
        Self { exit, message: error.to_string() }
    }
}

/// Draws a figure, or lists the figures.
pub fn plot(args: &PlotArgs) -> Result<Exit, Failure> {
    let Some(name) = args.figure.as_deref().filter(|_| !args.list) else {
        for directory in &args.runs {
            list_frames(&Run::open(directory, String::new())?)?;
        }
        for figure in FIGURES.iter().filter(|_| args.runs.is_empty()) {
            say(format_args!("{:<18} {}", figure.name, figure.about))?;
        }
        return Ok(Exit::Ok);
    };
    let figure = named(name)?;
    let path = args
        .out
        .clone()
        .unwrap_or_else(|| args.runs[0].join("figures").join(figure.name).with_extension("svg"));
    let page = pages::Format::of(path.extension().and_then(OsStr::to_str))?;
    let mut runs = Vec::new();
    for (directory, name) in args.runs.iter().zip(names(&args.runs)) {
        runs.push(Run::open(directory, name)?);
    }
    let request = Request {
        at: args.frame.clone(),
        since: args.since.clone(),
        style: Style::print(args.width, args.font),
        window: args.crop,
        title: args.title,
        cracks: args.cracks,
    };
    let svg = figure.draw(&runs, &request)?;
    let bytes = page.of_svg(svg, args.dpi)?;
    if let Some(parent) = path.parent().filter(|parent| *parent != Path::new("")) {
        fs::create_dir_all(parent).map_err(OutputError::at(parent))?;
    }
    write_atomic(&path, bytes)?;
    say(format_args!("drawn: {}", path.display()))?;
    Ok(Exit::Ok)
}

/// Lists the moments of a run that `--frame` and `--since` can name.
fn list_frames(run: &Run) -> Result<(), Failure> {
    let frames = run.list()?;
    say(format_args!("{}: {} frames", run.directory.display(), frames.len()))?;
    say(format_args!("{:>9}  {:<12} {:>12}  stage", "increment", "also", "axial strain"))?;
    for Listed { increment, names, stage, strain } in frames {
        let strain = strain.map_or_else(String::new, |strain| format!("{:.4} %", 100.0 * strain));
        let names = names.join(", ");
        say(format_args!("{increment:>9}  {names:<12} {strain:>12}  {stage}"))?;
    }
    Ok(())
}
