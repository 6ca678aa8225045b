//! Figures for a paper, drawn from run directories. `docs/figures.md` has the definition of each.
//!
//! A figure is an SVG whose root states its width in mm; [`pages`] makes PDF and PNG of it.

pub mod curves;
pub mod fabric;
pub mod fields;
mod frames;
pub mod maps;
pub mod mesh;
pub mod moment;
pub mod pages;
mod panels;
pub mod roses;
pub mod run;

use std::io;

use crate::frames::FrameError;
use crate::output::OutputError;
use crate::output::plots::chart::Chart;
use crate::output::plots::page::Style;
use maps::View;
use moment::Moment;
use roses::Rose;
use run::{At, Run};

/// Why a figure cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The request does not describe a figure.
    #[error("{0}")]
    Usage(String),
    /// The run lacks the data of the figure.
    #[error("{0}")]
    Absent(String),
    /// A file cannot be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A frame cannot be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The figure cannot be drawn.
    #[error("the figure cannot be drawn: {0}")]
    Drawing(#[from] io::Error),
}

/// Settings with which a figure is drawn.
#[derive(Clone, Debug)]
pub struct Request {
    /// Moment of figures of the specimen.
    pub at: At,
    /// Moment from which fields count.
    pub since: At,
    /// Size and letters.
    pub style: Style,
    /// Corners of the visible rectangle: m, or values of the axes of a curve.
    pub window: Option<[[f64; 2]; 2]>,
    /// Whether the title of the scene stands over the figure.
    pub title: bool,
    /// Whether broken bonds are drawn over fields.
    pub cracks: bool,
}

/// How a figure is drawn.
enum Kind {
    /// Curves of one run or several.
    Curves(fn(&[Run]) -> Result<Chart, FigureError>),
    /// Curves of one run.
    Curve(fn(&Run) -> Result<Chart, FigureError>),
    /// The specimen at a moment.
    Map(fn(&View) -> Option<String>),
    /// The specimen at a moment, relative to another one.
    Field(fn(&View) -> Option<String>),
    /// Directions at a moment.
    Rose(fn(&Moment) -> Option<Rose>),
    /// Directions of the cracks up to a moment.
    Cracks,
    /// Four panels on localisation.
    Localisation,
}

/// A figure.
pub struct Figure {
    /// Name.
    pub name: &'static str,
    /// What it shows, in a line.
    pub about: &'static str,
    kind: Kind,
}

const fn figure(name: &'static str, kind: Kind, about: &'static str) -> Figure {
    Figure { name, about, kind }
}

/// All figures.
pub const FIGURES: [Figure; 20] = [
    figure(
        "stress-strain",
        Kind::Curves(curves::stress),
        "stresses and broken bonds against axial strain; of several runs the axial stress",
    ),
    figure("volumetric", Kind::Curves(curves::volumetric), "volumetric against axial strain"),
    figure(
        "force-displacement",
        Kind::Curves(curves::probes),
        "force on the probes against their displacement, or displacement against time",
    ),
    figure("energies", Kind::Curve(curves::energies), "terms of the energy ledger"),
    figure(
        "fabric",
        Kind::Curve(curves::fabric),
        "anisotropy of contacts and forces, and coordination, against axial strain",
    ),
    figure("mohr", Kind::Curves(curves::mohr), "Mohr circles of the peaks of several runs"),
    figure("specimen", Kind::Map(maps::specimen), "disks and broken bonds by mode"),
    figure("bonds", Kind::Map(maps::bonds), "intact and broken bonds"),
    figure("force-chains", Kind::Map(maps::force_chains), "normal forces as widths of lines"),
    figure("stress", Kind::Map(maps::stress), "mean stress of each disk"),
    figure("fragments", Kind::Map(maps::fragments), "disks that hang together by intact bonds"),
    figure("rotation", Kind::Field(maps::rotation), "rotation since --since"),
    figure("displacement", Kind::Field(maps::displacement), "displacement since --since"),
    figure("shear-strain", Kind::Field(maps::shear_strain), "maximum shear strain since --since"),
    figure(
        "volumetric-strain",
        Kind::Field(maps::volumetric_strain),
        "volumetric strain since --since",
    ),
    figure("layers", Kind::Field(maps::layers), "disks in layers of their height at --since"),
    figure("crack-rose", Kind::Cracks, "directions of the cracks as they broke"),
    figure("contact-rose", Kind::Rose(roses::contacts), "directions of the contacts"),
    figure("force-rose", Kind::Rose(roses::forces), "mean normal force by direction"),
    figure(
        "localisation",
        Kind::Localisation,
        "cracks at the peak and at --frame, layers, and rotation since the peak: four panels",
    ),
];

/// The figure of a name.
///
/// # Errors
/// With the nearest name and the list.
pub fn named(name: &str) -> Result<&'static Figure, FigureError> {
    FIGURES.iter().find(|figure| figure.name == name).ok_or_else(|| {
        let near = |figure: &&Figure| strsim::damerau_levenshtein(name, figure.name);
        let nearest = FIGURES.iter().min_by_key(near).filter(|f| near(f) <= 4);
        let meant = nearest.map_or(String::new(), |f| format!("; did you mean `{}`?", f.name));
        let names: Vec<_> = FIGURES.iter().map(|figure| figure.name).collect();
        let names = names.join(", ");
        FigureError::Usage(format!("no figure `{name}`{meant}\nfigures are {names}"))
    })
}

impl Figure {
    /// Whether the figure takes several runs.
    #[must_use]
    pub fn takes_several(&self) -> bool {
        matches!(self.kind, Kind::Curves(_))
    }

    /// Draws the figure as SVG.
    ///
    /// # Errors
    /// If the runs lack what it shows.
    pub fn draw(&self, runs: &[Run], request: &Request) -> Result<String, FigureError> {
        let [run, ..] = runs else {
            return Err(FigureError::Usage("a figure needs a run".to_owned()));
        };
        if runs.len() > 1 && !self.takes_several() {
            let what = format!("the figure `{}` is of one run; give one directory", self.name);
            return Err(FigureError::Usage(what));
        }
        let title = if request.title { run.title.as_str() } else { "" };
        match self.kind {
            Kind::Curves(chart) => charted(chart(runs)?, title, request),
            Kind::Curve(chart) => charted(chart(run)?, title, request),
            Kind::Map(map) => {
                let now = run.at(&request.at)?;
                self.mapped(map, &now, &now, title, request)
            }
            Kind::Field(map) => {
                let (now, from) = (run.at(&request.at)?, run.at(&request.since)?);
                self.mapped(map, &now, &from, title, request)
            }
            Kind::Rose(rose) => {
                let now = run.at(&request.at)?;
                let rose = rose(&now).ok_or_else(|| {
                    FigureError::Absent("no contact between two disks carries compression".into())
                })?;
                Ok(rose.svg(&request.style, title))
            }
            Kind::Cracks => {
                let until = match &request.at {
                    At::End => u64::MAX,
                    At::Increment(increment) => *increment,
                    at => run.at(at)?.increment,
                };
                let rose = roses::cracks(&run.ruptures(until)?)
                    .ok_or_else(|| FigureError::Absent("no bond has broken".into()))?;
                Ok(rose.svg(&request.style, title))
            }
            Kind::Localisation => panels::localisation(run, title, request),
        }
    }

    fn mapped(
        &self,
        map: fn(&View) -> Option<String>,
        now: &Moment,
        from: &Moment,
        title: &str,
        request: &Request,
    ) -> Result<String, FigureError> {
        let Request { style, window, cracks, .. } = *request;
        let view = View { now, from, style, title, window, cracks };
        map(&view).ok_or_else(|| FigureError::Absent("the specimen has no disks".into()))
    }
}

fn charted(mut chart: Chart, title: &str, request: &Request) -> Result<String, FigureError> {
    title.clone_into(&mut chart.title);
    chart.window = request.window;
    if request.style.width_mm.is_some() {
        // Sign conventions belong to the caption in a paper.
        chart.caption.clear();
    }
    Ok(chart.svg_in(&request.style)?)
}
