//! Line charts in the style of all our curves.

use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;

/// Points in a chart at most; what lies closer together cannot be told apart.
const MOST_POINTS: usize = 2000;

/// Room of a legend, as fractions of the chart.
const LEGEND: (f64, f64) = (0.3, 0.2);

const SIZE: (u32, u32) = (760, 520);
/// Plotters draws on whole pixels, which shows as steps in a straight line: draw larger.
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
    /// Draws the chart.
    pub fn svg(&self) -> io::Result<String> {
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, (SIZE.0 * ZOOM, SIZE.1 * ZOOM));
            let drawn = self.draw(&root.into_drawing_area());
            drawn.map_err(|error| io::Error::other(error.to_string()))?;
        }
        // The view box keeps the large drawing; it is shown at its real size.
        let size = |zoom| format!("width=\"{}\" height=\"{}\"", SIZE.0 * zoom, SIZE.1 * zoom);
        Ok(text.replacen(&size(ZOOM), &size(1), 1))
    }

    /// Where a legend hides least of the lines: the first of the places with fewest points.
    fn emptiest_place(&self) -> SeriesLabelPosition {
        let places = [
            (SeriesLabelPosition::UpperLeft, (0.0, 1.0)),
            (SeriesLabelPosition::UpperRight, (1.0, 1.0)),
            (SeriesLabelPosition::LowerRight, (1.0, 0.0)),
            (SeriesLabelPosition::LowerLeft, (0.0, 0.0)),
            (SeriesLabelPosition::MiddleRight, (1.0, 0.5)),
            (SeriesLabelPosition::MiddleLeft, (0.0, 0.5)),
        ];
        let all = || self.lines.iter().chain(&self.second);
        let x = range(all().flat_map(|line| &line.points).map(|p| p.0));
        let first = range(self.lines.iter().flat_map(|line| &line.points).map(|p| p.1));
        let second = range(self.second.iter().flat_map(|line| &line.points).map(|p| p.1));
        let relative = |v: f64, r: &std::ops::Range<f64>| (v - r.start) / (r.end - r.start);
        let hidden = |corner: (f64, f64)| {
            let count = |lines: &mut dyn Iterator<Item = &Line>, y: &std::ops::Range<f64>| {
                lines
                    .flat_map(|line| thin(&line.points))
                    .filter(|p| {
                        (relative(p.0, &x) - corner.0).abs() < LEGEND.0
                            && (relative(p.1, y) - corner.1).abs() < LEGEND.1
                    })
                    .count()
            };
            count(&mut self.lines.iter(), &first) + count(&mut self.second.iter(), &second)
        };
        places
            .into_iter()
            .min_by_key(|place| hidden(place.1))
            .map_or(SeriesLabelPosition::UpperLeft, |place| place.0)
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
        let all = || self.lines.iter().chain(&self.second).flat_map(|line| &line.points);
        let x = range(all().map(|p| p.0));
        let y = range(self.lines.iter().flat_map(|line| &line.points).map(|p| p.1));
        let mut builder = ChartBuilder::on(&area);
        builder
            .margin(12 * ZOOM)
            .x_label_area_size(44 * ZOOM)
            .y_label_area_size(64 * ZOOM)
            .right_y_label_area_size(if self.second.is_some() { 60 } else { 12 } * ZOOM);
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
        for (line, color) in self.lines.iter().zip(COLORS.iter().cycle()) {
            let color = *color;
            chart
                .draw_series(LineSeries::new(thin(&line.points), color.stroke_width(2 * ZOOM)))?
                .label(&line.name)
                .legend(move |at| sample(at, color.stroke_width(2 * ZOOM)));
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
            chart
                .draw_secondary_series(LineSeries::new(
                    thin(&second.points),
                    SECONDARY.stroke_width(ZOOM),
                ))?
                .label(&second.name)
                .legend(|at| sample(at, SECONDARY.stroke_width(ZOOM)));
        }
        if self.lines.len() + usize::from(self.second.is_some()) > 1 {
            chart
                .configure_series_labels()
                .position(self.emptiest_place())
                .background_style(WHITE.mix(0.8))
                .margin(10 * ZOOM)
                .legend_area_size(26 * ZOOM)
                .label_font(font(13))
                .draw()?;
        }
        root.present()
    }
}

fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size * ZOOM).into_font().into()
}

/// A piece of a line for the legend.
fn sample((x, y): (i32, i32), style: ShapeStyle) -> PathElement<(i32, i32)> {
    PathElement::new([(x, y), (x + 18 * ZOOM as i32, y)], style)
}

/// A range that holds all values with a little room, and is never empty.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let room = if high > low { 0.04 * (high - low) } else { low.abs().max(1.0) };
    // Zero is where most curves begin: let the axis begin there as well.
    (if (0.0..=room).contains(&low) { 0.0 } else { low - room })..(high + room)
}

/// Every so many points, and the last one.
fn thin(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> {
    let step = points.len().div_ceil(MOST_POINTS).max(1);
    let last = if points.len() % step == 1 || step == 1 { None } else { points.last() };
    points.iter().step_by(step).chain(last).copied()
}

/// A tick without the digits of round-off, on an axis of the given span.
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
            assert!(thinned.len() <= MOST_POINTS + 1);
            assert_eq!((thinned.first(), thinned.last()), (points.first(), points.last()));
            assert!(thinned.windows(2).all(|w| w[0].0 < w[1].0));
        }
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
