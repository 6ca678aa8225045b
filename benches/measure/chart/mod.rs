//! Line charts in a common style.

mod draw;
mod legend;
mod page;
mod ranges;
mod ticks;

/// A line of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Name in the legend. Lines with one name have one colour and one entry.
    pub name: String,
    /// Points.
    pub points: Vec<(f64, f64)>,
}

/// Lines in one pair of axes.
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
}
