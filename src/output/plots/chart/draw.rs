//! Draws charts with plotters.

use std::collections::{HashMap, HashSet};
use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Chart;

/// Maximum number of points of a line. Closer points cannot be distinguished.
const MAX_POINTS: usize = 2000;

const SIZE: (u32, u32) = (760, 520);
/// Plotters draws on whole pixels, which shows as steps in a straight line, so the drawing is
/// magnified.
const ZOOM: u32 = 8;
const COLORS: [RGBColor; 10] = [
    RGBColor(31, 73, 125),
    RGBColor(214, 130, 20),
    RGBColor(60, 130, 60),
    RGBColor(120, 80, 160),
    RGBColor(20, 140, 150),
    RGBColor(110, 110, 110),
    RGBColor(150, 90, 60),
    RGBColor(220, 120, 170),
    RGBColor(160, 160, 40),
    RGBColor(0, 0, 0),
];
const SECONDARY: RGBColor = RGBColor(200, 40, 40);

/// Space for the axes and around the chart, px.
const MARGIN: u32 = 12;
const LEFT: u32 = 64;
const BOTTOM: u32 = 44;
/// Space for an entry of the legend, px: the sample of the line, and each character.
const SAMPLE: u32 = 18;
const CHARACTER: f64 = 7.0;
const LEGEND_ROW: u32 = 19;

impl Chart {
    /// Draws the chart.
    pub(super) fn drawn(&self) -> io::Result<String> {
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, (SIZE.0 * ZOOM, SIZE.1 * ZOOM));
            let drawn = self.draw(&root.into_drawing_area());
            drawn.map_err(|error| io::Error::other(error.to_string()))?;
        }
        // The view box keeps the magnified drawing, which is shown at its nominal size.
        let size = |zoom| format!("width=\"{}\" height=\"{}\"", SIZE.0 * zoom, SIZE.1 * zoom);
        Ok(text.replacen(&size(ZOOM), &size(1), 1))
    }

    /// Names and styles of the lines for the legend, each name once; empty for a single line.
    fn legend(&self) -> Vec<(&str, ShapeStyle)> {
        let mut lines: Vec<_> = self.lines.iter().zip(self.styles()).collect();
        let mut known = HashSet::new();
        lines.retain(|(line, _)| known.insert(&line.name));
        let second = self.second.iter().map(|line| (line, SECONDARY.stroke_width(ZOOM)));
        let all: Vec<_> = lines
            .into_iter()
            .chain(second)
            .map(|(line, style)| (line.name.as_str(), style))
            .collect();
        if all.len() > 1 { all } else { Vec::new() }
    }

    /// Styles of the lines. Lines with one name have one colour.
    fn styles(&self) -> impl Iterator<Item = ShapeStyle> {
        let mut known = HashMap::new();
        self.lines.iter().map(move |line| {
            let next = known.len();
            let at = *known.entry(&line.name).or_insert(next);
            COLORS[at % COLORS.len()].stroke_width(2 * ZOOM)
        })
    }

    fn draw<'a>(
        &self,
        root: &DrawingArea<SVGBackend<'a>, Shift>,
    ) -> Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>> {
        root.fill(&WHITE)?;
        let room = 10 * ZOOM as i32;
        let area = root
            .margin(room, 0, 0, 0)
            .titled(&self.title, font(18))?
            .margin(room / 2, 0, 0, 0)
            .titled(&self.caption, font(13).color(&RGBColor(90, 90, 90)))?;
        let right = if self.second.is_some() { 60 } else { 12 };
        let legend = arranged(self.legend(), SIZE.0 - 2 * MARGIN - LEFT - right);
        let rows = legend.last().map_or(0, |entry| entry.row + 1);
        // The legend is above the chart, because curves can reach every point inside it.
        let (strip, area) = area.split_vertically(rows * LEGEND_ROW * ZOOM);
        for entry in legend {
            let px = |at: u32| (at * ZOOM) as i32;
            let x = px(MARGIN + LEFT + entry.x);
            let y = px(entry.row * LEGEND_ROW + LEGEND_ROW / 2 + 4);
            strip.draw(&PathElement::new([(x, y), (x + px(SAMPLE), y)], entry.style))?;
            let place = Pos::new(HPos::Left, VPos::Center);
            strip.draw(&Text::new(entry.name, (x + px(SAMPLE + 6), y), font(13).pos(place)))?;
        }
        let all = || self.lines.iter().chain(&self.second).flat_map(|line| &line.points);
        let x = range(all().map(|p| p.0));
        let y = range(self.lines.iter().flat_map(|line| &line.points).map(|p| p.1));
        let (x, y) = if self.equal {
            // Without the labels of the axes, as below.
            let width = SIZE.0 - 2 * MARGIN - LEFT - right;
            let height = area.dim_in_pixel().1 / ZOOM - 2 * MARGIN - BOTTOM;
            equal(x, y, f64::from(width) / f64::from(height))
        } else {
            (x, y)
        };
        let mut builder = ChartBuilder::on(&area);
        builder
            .margin(MARGIN * ZOOM)
            .x_label_area_size(BOTTOM * ZOOM)
            .y_label_area_size(LEFT * ZOOM)
            .right_y_label_area_size(right * ZOOM);
        let second = self.second.clone().unwrap_or_default();
        let second_range = range(second.points.iter().map(|p| p.1));
        let span = |r: &std::ops::Range<f64>| r.end - r.start;
        let (x_span, y_span, second_span) = (span(&x), span(&y), span(&second_range));
        let mut chart =
            builder.build_cartesian_2d(x.clone(), y)?.set_secondary_coord(x, second_range);
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225).stroke_width(ZOOM))
            .axis_style(BLACK.stroke_width(ZOOM))
            .set_all_tick_mark_size(5 * ZOOM)
            .x_desc(&self.x)
            .y_desc(&self.y)
            .axis_desc_style(font(14))
            .label_style(font(12))
            .x_label_formatter(&|v| tick(*v, x_span))
            .y_label_formatter(&|v| tick(*v, y_span))
            .draw()?;
        for (line, style) in self.lines.iter().zip(self.styles()) {
            chart.draw_series(LineSeries::new(thin(&line.points), style))?;
        }
        if let Some(second) = &self.second {
            chart
                .configure_secondary_axes()
                .axis_style(BLACK.stroke_width(ZOOM))
                .set_all_tick_mark_size(5 * ZOOM)
                .y_desc(&second.name)
                .axis_desc_style(font(14))
                .label_style(font(12))
                .y_label_formatter(&|v| tick(*v, second_span))
                .draw()?;
            let style = SECONDARY.stroke_width(ZOOM);
            chart.draw_secondary_series(LineSeries::new(thin(&second.points), style))?;
        }
        root.present()
    }
}

fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size * ZOOM).into_font().into()
}

/// An entry of the legend and its position: px from the left end of the axis, and row.
struct Entry<'a> {
    name: &'a str,
    style: ShapeStyle,
    x: u32,
    row: u32,
}

/// Arranges the entries of a legend in rows of a given width, px.
fn arranged(entries: Vec<(&str, ShapeStyle)>, width: u32) -> Vec<Entry<'_>> {
    let (mut x, mut row) = (0, 0);
    let mut arranged = Vec::with_capacity(entries.len());
    for (name, style) in entries {
        let size = SAMPLE + 6 + (CHARACTER * name.chars().count() as f64).ceil() as u32;
        if x > 0 && x + size > width {
            (x, row) = (0, row + 1);
        }
        arranged.push(Entry { name, style, x, row });
        x += size + 20;
    }
    arranged
}

/// A range that contains all values with a margin, and is never empty.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let room = if high > low { 0.04 * (high - low) } else { low.abs().max(1.0) };
    // Most curves begin at zero, so the axis begins there if zero is near.
    (if (0.0..=room).contains(&low) { 0.0 } else { low - room })..(high + room)
}

/// The ranges with the shorter one made longer at its end, so that both have one scale on an area
/// that is `ratio` times as wide as high.
fn equal(
    x: std::ops::Range<f64>,
    y: std::ops::Range<f64>,
    ratio: f64,
) -> (std::ops::Range<f64>, std::ops::Range<f64>) {
    let scale = ((x.end - x.start) / ratio).max(y.end - y.start);
    (x.start..x.start + ratio * scale, y.start..y.start + scale)
}

/// Every n-th point, and the last one.
fn thin(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> {
    let step = points.len().div_ceil(MAX_POINTS).max(1);
    let last = if points.len() % step == 1 || step == 1 { None } else { points.last() };
    points.iter().step_by(step).chain(last).copied()
}

/// A label of a tick without digits of round-off, on an axis with the given span.
fn tick(value: f64, span: f64) -> String {
    let value = if value.abs() < 1e-9 * span { 0.0 } else { value };
    let rounded = format!("{value:.6e}").parse().unwrap_or(value) + 0.0;
    if rounded != 0.0 && !(1e-4..1e6).contains(&f64::abs(rounded)) {
        return format!("{rounded:e}");
    }
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::plots::chart::Line;

    #[test]
    fn ticks_are_short() {
        let found = [0.1 + 0.2, 1e-17, 250.0, 2e-7, -0.0].map(|v| tick(v, 1.0));
        assert_eq!(found, ["0.3", "0", "250", "2e-7", "0"]);
        assert_eq!(tick(1e-17, 1e-16), "1e-17");
    }

    #[test]
    fn thinning_keeps_the_ends() {
        for n in [1, 2, 2000, 2001, 4001, 12_345] {
            let points: Vec<_> = (0..n).map(|k| (f64::from(k), 0.0)).collect();
            let thinned: Vec<_> = thin(&points).collect();
            assert!(thinned.len() <= MAX_POINTS + 1);
            assert_eq!((thinned.first(), thinned.last()), (points.first(), points.last()));
            assert!(thinned.windows(2).all(|w| w[0].0 < w[1].0));
        }
    }

    /// Vertical positions (downwards) of the points of the curves, and of the baselines of all
    /// texts with these names.
    fn heights(svg: &str, names: &[&str]) -> (Vec<f64>, Vec<f64>) {
        let number = |text: &str| text.parse::<f64>().unwrap_or(f64::NAN);
        let attribute = |element: &str, name: &str| {
            let start = element.split_once(&format!(" {name}=\"")).map_or("", |at| at.1);
            start.split('"').next().unwrap_or_default().to_owned()
        };
        let mut curves = Vec::new();
        for line in svg.split("<polyline").skip(1) {
            let points = attribute(line, "points");
            let points: Vec<_> = points.split_whitespace().collect();
            if points.len() > 3 {
                curves.extend(points.iter().filter_map(|p| Some(number(p.split_once(',')?.1))));
            }
        }
        let mut texts = Vec::new();
        for text in svg.split("<text").skip(1) {
            let content = text.split_once('>').map_or("", |at| at.1);
            let content = content.split("</text>").next().unwrap_or_default().trim();
            if names.contains(&content) {
                texts.push(number(&attribute(text, "y")));
            }
        }
        (curves, texts)
    }

    #[test]
    fn the_legend_hides_nothing_of_the_curves() -> io::Result<()> {
        // The curves go through all corners and the middle of the sides, so no place inside is
        // free.
        let zigzag =
            [(0.0, 0.0), (0.0, 1.0), (0.5, 0.5), (1.0, 1.0), (1.0, 0.5), (1.0, 0.0), (0.0, 0.5)];
        let line = |name: &str| Line { name: name.to_owned(), points: zigzag.to_vec() };
        let mut chart = Chart {
            lines: vec![line("axial stress"), line("lateral stress")],
            second: Some(line("broken bonds")),
            ..Default::default()
        };
        let (curves, texts) =
            heights(&chart.svg()?, &["axial stress", "lateral stress", "broken bonds"]);
        assert_eq!(curves.len(), 3 * zigzag.len());
        let top = curves.iter().copied().fold(f64::INFINITY, f64::min);
        // One of the texts is the label of the second axis, which is beside the chart.
        let above = texts.iter().filter(|y| **y + 4.0 * f64::from(ZOOM) < top).count();
        assert_eq!((texts.len(), above), (4, 3), "{texts:?}, {top}");

        // Long names take as many rows as they need.
        let names: Vec<_> =
            (0..8).map(|k| format!("runs/a_long_name_of_a_directory/{k}")).collect();
        chart.lines = names.iter().map(|name| line(name)).collect();
        let names: Vec<_> = names.iter().map(String::as_str).collect();
        let (curves, texts) = heights(&chart.svg()?, &names);
        let top = curves.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(texts.len() == 8 && texts.iter().all(|y| *y < top), "{texts:?}, {top}");
        let mut rows = texts;
        rows.dedup();
        assert_eq!(rows.len(), 4);
        Ok(())
    }

    #[test]
    fn a_chart_is_drawn_whatever_the_data() -> io::Result<()> {
        let flat = Line { name: "a & b".to_owned(), points: vec![(0.0, 3.0); 3] };
        for lines in [vec![], vec![flat.clone()], vec![flat.clone(), Line::default()]] {
            let chart = Chart {
                title: "<t>".to_owned(),
                lines,
                second: Some(flat.clone()),
                ..Default::default()
            };
            let svg = chart.svg()?;
            assert!(svg.ends_with("</svg>\n") && !svg.contains("<t>"));
            assert_eq!(svg, chart.svg()?);
        }
        Ok(())
    }
}
