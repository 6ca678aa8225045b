//! A picture of a specimen to scale. The SVG is written directly with few digits, so that files
//! with thousands of disks stay small.

use std::fmt::Write as _;

use glam::DVec2;

use super::page::{self, Style};
use super::scale::Scale;
use crate::output::corners::joined;
use crate::output::snapshot::Snapshot;

/// Colours of texts.
const DARK: &str = "#222";
const GREY: &str = "#555";

/// A picture that is being drawn.
pub struct Sheet {
    /// Elements so far, without the root.
    svg: String,
    /// Units of the page per m.
    pub scale: f64,
    /// Size and letters.
    pub style: Style,
    width: f64,
    /// Lower end of the drawing.
    bottom: f64,
    corner: DVec2,
    /// Upper left corner of the drawing, m.
    origin: DVec2,
}

impl Sheet {
    /// Begins the picture of a specimen; `None` without disks. Title and caption may be empty.
    #[must_use]
    pub fn new(now: &Snapshot, title: &str, caption: &str) -> Option<Self> {
        let style = Style::SCREEN;
        let (low, high) = now.bounds()?;
        let size = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let scale = (style.fit / size).min_element();
        let (margin, font) = (style.margin, style.font);
        let width = (size.x * scale + 2.0 * margin).max(style.narrowest);
        let mut svg = String::new();
        let mut at = DVec2::new(margin, margin);
        for (what, font, color) in [(title, 1.35 * font, DARK), (caption, font, GREY)] {
            for line in page::wrapped(what, font, width - 2.0 * margin) {
                at.y += font;
                page::text(&mut svg, at, font, "start", color, &line);
                at.y += 0.45 * font;
            }
        }
        let corner = DVec2::new(0.5 * (width - size.x * scale), at.y + 0.9 * margin);
        let size = size * scale;
        let clip = DVec2::splat(0.7 * margin);
        let _ = writeln!(
            svg,
            "<clipPath id=\"c\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>",
            page::short(corner.x - clip.x),
            page::short(corner.y - clip.y),
            page::short(size.x + 2.0 * clip.x),
            page::short(size.y + 2.0 * clip.y),
        );
        // Walls may reach to the edge of the clip.
        let bottom = corner.y + size.y + 0.5 * margin;
        let origin = DVec2::new(low.x, high.y);
        Some(Self { svg, scale, style, width, bottom, corner, origin })
    }

    /// Position of a point on the page.
    #[must_use]
    pub fn place(&self, x: DVec2) -> DVec2 {
        self.corner + DVec2::new(x.x - self.origin.x, self.origin.y - x.y) * self.scale
    }

    /// Draws the disks in the colours of their classes, with one SVG group per class.
    pub fn disks(&mut self, now: &Snapshot, colors: &[&str], class_of: impl Fn(usize) -> usize) {
        let line = page::short(0.023 * self.style.font);
        for (class, color) in colors.iter().enumerate() {
            let mut members = (0..now.positions.len()).filter(|i| class_of(*i) == class).peekable();
            if members.peek().is_none() {
                continue;
            }
            let _ = writeln!(
                self.svg,
                "<g clip-path=\"url(#c)\" fill=\"{color}\" stroke=\"#777\" stroke-width=\"{line}\">"
            );
            for i in members {
                let (c, r) = (self.place(now.positions[i]), now.radii[i] * self.scale);
                let _ = writeln!(
                    self.svg,
                    "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"{r:.2}\"/>",
                    c.x, c.y
                );
            }
            let _ = writeln!(self.svg, "</g>");
        }
    }

    /// Draws the walls as the scene gives them, lines joined at their corners.
    pub fn walls(&mut self, now: &Snapshot) {
        let width = 0.15 * self.style.font;
        self.segments(&joined(&now.walls), DARK, width);
        self.segments(&now.plates, DARK, width);
    }

    /// Draws segments (m) as one path, their width in units of the page.
    pub fn segments(&mut self, list: &[[DVec2; 2]], color: &str, width: f64) {
        if list.is_empty() {
            return;
        }
        let _ = write!(
            self.svg,
            "<path clip-path=\"url(#c)\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{}\" \
             stroke-linecap=\"round\" d=\"",
            page::short(width)
        );
        for [a, b] in list {
            let (a, b) = (self.place(*a), self.place(*b));
            let _ = write!(self.svg, "M{:.2} {:.2}L{:.2} {:.2}", a.x, a.y, b.x, b.y);
        }
        let _ = writeln!(self.svg, "\"/>");
    }

    /// Adds the colours of a scale with their numbers and their meaning, below the drawing.
    pub fn bar(&mut self, scale: &Scale) {
        let (font, margin) = (self.style.font, self.style.margin);
        let ([low, middle, high], name) = scale.labels();
        let n = scale.colors.len() as f64;
        // Space for half of a number on either side.
        let left = margin.max(0.5 * page::width(&low, font));
        let room = self.width - left - margin.max(0.5 * page::width(&high, font));
        let swatch = (3.0 * font).min(room / n);
        let top = self.below(0.7 * font);
        for (class, color) in scale.colors.iter().enumerate() {
            let _ = writeln!(
                self.svg,
                "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{color}\" \
                 stroke=\"#777\" stroke-width=\"{}\"/>",
                page::short(left + swatch * class as f64),
                page::short(top),
                page::short(swatch),
                page::short(font),
                page::short(0.023 * font),
            );
        }
        let base = top + 2.1 * font;
        for (share, label) in [(0.0, low), (0.5, middle), (1.0, high)] {
            let at = DVec2::new(left + swatch * n * share, base);
            page::text(&mut self.svg, at, font, "middle", DARK, &label);
        }
        self.bottom = base + 0.2 * font;
        self.note(&name);
    }

    /// Adds samples of strokes or disks with their meaning, in as many rows as they need. A text that
    /// is wider than the sheet has several lines.
    pub fn samples(&mut self, list: &[Sample]) {
        let (font, margin) = (self.style.font, self.style.margin);
        let (mut x, mut y) = (margin, self.below(0.7 * font));
        let room = self.width - 2.0 * margin - 1.9 * font;
        for sample in list {
            let size = Sample::width(&sample.text, font);
            if x > margin && x + size > self.width - margin {
                (x, y) = (margin, y + 1.5 * font);
            }
            let middle = y + 0.5 * font;
            let [y_middle, thin] = [middle, 0.023 * font].map(page::short);
            let _ = if let Some(stroke) = sample.stroke {
                // Round ends are half as long as the stroke is wide.
                let end = (0.2 * font).max(0.5 * stroke);
                let (from, to) = (x + end, (x + 1.6 * font - end).max(x + end + 0.1));
                let [from, to, stroke] = [from, to, stroke].map(page::short);
                writeln!(
                    self.svg,
                    "<path stroke=\"{}\" stroke-width=\"{stroke}\" stroke-linecap=\"round\" \
                     d=\"M{from} {y_middle}H{to}\"/>",
                    sample.color,
                )
            } else {
                let [x, r] = [x + 0.7 * font, 0.5 * font].map(page::short);
                writeln!(
                    self.svg,
                    "<circle cx=\"{x}\" cy=\"{y_middle}\" r=\"{r}\" fill=\"{}\" stroke=\"#777\" \
                     stroke-width=\"{thin}\"/>",
                    sample.color,
                )
            };
            let lines = page::wrapped(&sample.text, font, room);
            for (k, line) in lines.iter().enumerate() {
                y += if k > 0 { 1.3 * font } else { 0.0 };
                let at = DVec2::new(x + 1.9 * font, y + 0.85 * font);
                page::text(&mut self.svg, at, font, "start", DARK, line);
            }
            x += size + 1.5 * font;
        }
        self.bottom = y + font;
    }

    /// Adds a line of text below the drawing so far, in as many lines as it needs.
    fn note(&mut self, what: &str) {
        let (font, margin) = (self.style.font, self.style.margin);
        for line in page::wrapped(what, font, self.width - 2.0 * margin) {
            let at = DVec2::new(margin, self.below(0.4 * font) + 0.85 * font);
            page::text(&mut self.svg, at, font, "start", DARK, &line);
            self.bottom = at.y + 0.15 * font;
        }
    }

    /// Upper end of what comes next.
    fn below(&self, gap: f64) -> f64 {
        self.bottom + gap
    }

    /// The whole picture.
    #[must_use]
    pub fn end(self) -> String {
        let size =
            DVec2::new(self.width, self.bottom + self.style.margin.max(0.6 * self.style.font));
        format!("{}{}</svg>\n", self.style.root(size), self.svg)
    }
}

/// An entry of a legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Colour.
    pub color: &'static str,
    /// Width of the stroke, in units of the page; `None` for a disk.
    pub stroke: Option<f64>,
    /// Meaning.
    pub text: String,
}

impl Sample {
    /// Width of an entry with this text.
    #[must_use]
    pub fn width(text: &str, font: f64) -> f64 {
        1.9 * font + page::width(text, font)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_platen_is_as_wide_as_given_where_grains_bulge_or_lie_inside() {
        let platen = |half: f64| Snapshot {
            positions: vec![DVec2::new(-2.0, 1.0), DVec2::new(2.0, 1.0)],
            radii: vec![1.0; 2],
            walls: vec![[DVec2::new(-half, 0.0), DVec2::new(half, 0.0)]],
            ..Default::default()
        };
        for half in [1.0, 3.2] {
            let now = platen(half);
            let mut sheet = Sheet::new(&now, "", "").unwrap_or_else(|| unreachable!());
            let ends = [-half, half].map(|x| sheet.place(DVec2::new(x, 0.0)));
            sheet.walls(&now);
            let [a, b] = ends.map(|x| format!("{:.2} {:.2}", x.x, x.y));
            let svg = sheet.end();
            assert!(svg.contains(&format!("M{a}L{b}\"")), "{svg}");
        }
        // The picture shows the whole platen, but no more than a quarter of the specimen beyond it.
        let right = |half: f64| platen(half).bounds().map(|(_, high)| high.x);
        assert_eq!([1.0, 3.2, 99.0].map(right), [Some(3.0), Some(3.2), Some(4.5)]);
    }

    #[test]
    fn long_titles_have_several_lines_and_stay_on_the_page() {
        let now = Snapshot { positions: vec![DVec2::ZERO], radii: vec![1.0], ..Default::default() };
        let title = "a title that is far too long for one line of the picture ".repeat(4);
        let svg = Sheet::new(&now, &title, "caption").map(Sheet::end).unwrap_or_default();
        let lines = svg.matches("font-size=\"17.55\"").count();
        assert_eq!(lines, 3, "{svg}");
        let place = |text: &str| svg.find(text).unwrap_or(usize::MAX);
        assert!(place("caption") < place("clipPath"));
    }
}
