//! The legend of a chart, in rows above it.

use plotters::style::ShapeStyle;

use super::page;

/// Length of the line beside a name, in sizes of the font.
pub(super) const SAMPLE: f64 = 1.4;
/// Height of a row, in sizes of the font.
pub(super) const LEGEND_ROW: f64 = 1.46;

/// An entry of the legend and its position: sizes of the font from the left end of the axis, and
/// row.
pub(super) struct Entry<'a> {
    pub(super) name: &'a str,
    pub(super) style: ShapeStyle,
    pub(super) x: f64,
    pub(super) row: f64,
}

/// Arranges the entries of a legend in rows of a given width, in sizes of the font.
pub(super) fn arranged(entries: Vec<(&str, ShapeStyle)>, width: f64) -> Vec<Entry<'_>> {
    let (mut x, mut row) = (0.0, 0.0);
    let mut arranged = Vec::with_capacity(entries.len());
    for (name, style) in entries {
        let size = SAMPLE + 0.5 + page::width(name, 1.0);
        if x > 0.0 && x + size > width {
            (x, row) = (0.0, row + 1.0);
        }
        arranged.push(Entry { name, style, x, row });
        x += size + 1.5;
    }
    arranged
}

/// Number of rows of a legend.
pub(super) fn rows(legend: &[Entry]) -> f64 {
    legend.last().map_or(0.0, |entry| entry.row + 1.0)
}
