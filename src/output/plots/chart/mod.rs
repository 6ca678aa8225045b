//! Line charts in the style of all our curves.

#[cfg(feature = "plots")]
mod draw;

use std::io;

/// A line of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// Points.
    pub points: Vec<(f64, f64)>,
}

/// Lines over one pair of axes, and perhaps one more on a second axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Line below the title, for conventions of sign.
    pub caption: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// Lines.
    pub lines: Vec<Line>,
    /// Line on the second axis, labelled with its name.
    pub second: Option<Line>,
}

impl Chart {
    /// The chart as SVG.
    ///
    /// # Errors
    /// Where it cannot be drawn: in a build without the feature `plots` none can.
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
