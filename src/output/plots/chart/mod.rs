//! Line charts in a common style.

#[cfg(feature = "plots")]
mod draw;
#[cfg(feature = "plots")]
mod legend;
#[cfg(feature = "plots")]
mod page;
#[cfg(feature = "plots")]
mod ranges;
#[cfg(feature = "plots")]
mod ticks;

use std::io;

/// A line of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Name in the legend. Lines with one name have one colour and one entry.
    pub name: String,
    /// Points.
    pub points: Vec<(f64, f64)>,
}

/// Lines in one pair of axes, and optionally one line on a second vertical axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Line below the title, for sign conventions.
    pub caption: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// Lines.
    pub lines: Vec<Line>,
    /// Line on the second axis, labelled with its name.
    pub second: Option<Line>,
    /// Whether one length on the two axes is one value.
    pub equal: bool,
}

impl Chart {
    /// The chart as SVG.
    ///
    /// # Errors
    /// If the chart cannot be drawn, as in a build without the feature `plots`.
    pub fn svg(&self) -> io::Result<String> {
        #[cfg(feature = "plots")]
        return self.drawn();
        #[cfg(not(feature = "plots"))]
        Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "this build of clastic draws no charts: it lacks the feature `plots`",
        ))
    }
}
