//! Draws charts with plotters.

use std::collections::{HashMap, HashSet};
use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Chart;
use super::legend::{LEGEND_ROW, SAMPLE, arranged, rows};
use super::page;
use super::ranges::{range, thin};
use super::ticks::{self, tick};

/// Size on a screen, and the size of its font.
const SIZE: (f64, f64) = (760.0, 520.0);
const FONT: f64 = 13.0;
/// Plotters draws on whole pixels, which shows as steps in a straight line, so the drawing is
/// magnified.
const ZOOM: f64 = 8.0;
/// As many as the energy ledger has terms.
const COLORS: [RGBColor; 13] = [
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
    RGBColor(110, 170, 230),
    RGBColor(0, 90, 90),
    RGBColor(190, 160, 110),
];

/// Space around the chart and for the axes, in sizes of the font.
const MARGIN: f64 = 0.9;
const LEFT: f64 = 4.9;
const BOTTOM: f64 = 3.4;
/// Lengths of a chart in units of the drawing.
#[derive(Clone, Copy)]
struct Measures {
    /// Width and height of the page in its own units.
    page: (f64, f64),
    /// Size of the font in its own units.
    font: f64,
}

impl Measures {
    /// Width between the axes, in sizes of the font.
    fn wide(&self) -> f64 {
        self.page.0 / self.font - 3.0 * MARGIN - LEFT
    }

    /// A number of sizes of the font.
    fn em(&self, number: f64) -> u32 {
        (number * self.font * ZOOM).round() as u32
    }

    /// Size of the drawing.
    fn size(&self) -> (u32, u32) {
        let units = |x: f64| (x * ZOOM).round() as u32;
        (units(self.page.0), units(self.page.1))
    }

    fn letters(&self, number: f64) -> TextStyle<'static> {
        ("sans-serif", self.em(number)).into_font().into()
    }
}

impl Chart {
    /// The chart as SVG.
    ///
    /// # Errors
    /// If the chart cannot be drawn.
    pub fn svg(&self) -> io::Result<String> {
        let mut text = String::new();
        let measures = Measures { page: SIZE, font: FONT };
        let size = measures.size();
        {
            let root = SVGBackend::with_string(&mut text, size);
            let drawn = self.draw(&root.into_drawing_area(), measures);
            drawn.map_err(|error| io::Error::other(error.to_string()))?;
        }
        // The drawing is magnified within a page of its own size.
        let body = text.split_once('>').map_or("", |(_, body)| body);
        let body =
            body.strip_suffix("</svg>\n").unwrap_or(body).replace("\"sans-serif\"", "\"inherit\"");
        let root = page::root(measures.page);
        Ok(format!("{root}<g transform=\"scale({})\">{body}</g>\n</svg>\n", ZOOM.recip()))
    }

    /// Names and styles of the lines for the legend, each name once; empty for a single line.
    fn legend(&self, line: u32) -> Vec<(&str, ShapeStyle)> {
        let mut lines: Vec<_> = self.lines.iter().zip(self.styles(line)).collect();
        let mut known = HashSet::new();
        lines.retain(|(line, _)| known.insert(&line.name));
        let all: Vec<_> =
            lines.into_iter().map(|(line, style)| (line.name.as_str(), style)).collect();
        if all.len() > 1 { all } else { Vec::new() }
    }

    /// Styles of the lines. Lines with one name have one colour.
    fn styles(&self, line: u32) -> impl Iterator<Item = ShapeStyle> {
        let mut known = HashMap::new();
        let width = line;
        self.lines.iter().map(move |line| {
            let next = known.len();
            let at = *known.entry(&line.name).or_insert(next);
            COLORS[at % COLORS.len()].stroke_width(width)
        })
    }

    fn draw<'a>(
        &self,
        root: &DrawingArea<SVGBackend<'a>, Shift>,
        m: Measures,
    ) -> Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>> {
        let (line, thin_line) = (m.em(0.15), m.em(0.075));
        let room = m.page.0 - 2.0 * MARGIN * m.font;
        let mut area = root.margin(m.em(0.5), 0, 0, 0);
        let grey = RGBColor(90, 90, 90);
        for (what, size, color) in [(&self.title, 1.35, BLACK), (&self.caption, 1.0, grey)] {
            area = area.margin(if what.is_empty() { 0 } else { m.em(0.35) }, 0, 0, 0);
            for words in page::wrapped(what, size * m.font, room) {
                area = area.titled(&words, m.letters(size).color(&color))?;
            }
        }
        let wide = m.wide();
        let legend = arranged(self.legend(line), wide);
        // The legend is above the chart, because curves can reach every point inside it.
        let (strip, area) = area.split_vertically(m.em(rows(&legend) * LEGEND_ROW));
        for entry in legend {
            let px = |at: f64| m.em(at) as i32;
            let x = px(MARGIN + LEFT + entry.x);
            let y = px(entry.row * LEGEND_ROW + LEGEND_ROW / 2.0 + 0.3);
            strip.draw(&PathElement::new([(x, y), (x + px(SAMPLE), y)], entry.style))?;
            let place = Pos::new(HPos::Left, VPos::Center);
            let font = m.letters(1.0).pos(place);
            strip.draw(&Text::new(entry.name, (x + px(SAMPLE + 0.5), y), font))?;
        }
        let all = || self.lines.iter().flat_map(|line| &line.points);
        let (x, y) = (range(all().map(|p| p.0)), range(all().map(|p| p.1)));
        // Without the labels of the axes, as below.
        let high = f64::from(area.dim_in_pixel().1) / f64::from(m.em(1.0)) - 2.0 * MARGIN - BOTTOM;
        let mut builder = ChartBuilder::on(&area);
        builder
            .margin(m.em(MARGIN))
            .x_label_area_size(m.em(BOTTOM))
            .y_label_area_size(m.em(LEFT))
            .right_y_label_area_size(m.em(MARGIN));
        let span = |r: &std::ops::Range<f64>| r.end - r.start;
        let (x_span, y_span) = (span(&x), span(&y));
        let (x_labels, y_labels) = (ticks::beside(&x, wide), ticks::above(&y, high));
        let mut chart = builder.build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225).stroke_width(m.em(0.075)))
            .axis_style(BLACK.stroke_width(thin_line))
            .set_all_tick_mark_size(m.em(0.38))
            .x_labels(x_labels)
            .y_labels(y_labels)
            .x_desc(&self.x)
            .y_desc(&self.y)
            .axis_desc_style(m.letters(1.08))
            .label_style(m.letters(0.93))
            .x_label_formatter(&|v| tick(*v, x_span))
            .y_label_formatter(&|v| tick(*v, y_span))
            .draw()?;
        for (line, style) in self.lines.iter().zip(self.styles(line)) {
            chart.draw_series(LineSeries::new(thin(&line.points), style))?;
        }
        root.present()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Line;

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
            ..Default::default()
        };
        let (curves, texts) = heights(&chart.svg()?, &["axial stress", "lateral stress"]);
        assert_eq!(curves.len(), 2 * zigzag.len());
        let top = curves.iter().copied().fold(f64::INFINITY, f64::min);
        let above = texts.iter().filter(|y| **y + 4.0 * ZOOM < top).count();
        assert_eq!((texts.len(), above), (2, 2), "{texts:?}, {top}");

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
            let chart = Chart { title: "<t>".to_owned(), lines, ..Default::default() };
            let svg = chart.svg()?;
            assert!(svg.ends_with("</svg>\n") && !svg.contains("<t>"));
            assert_eq!(svg, chart.svg()?);
        }
        Ok(())
    }
}
