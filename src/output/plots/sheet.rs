//! A picture of a specimen to scale. The SVG is written directly with few digits, so that files
//! with thousands of disks stay small.

use std::fmt::Write as _;

use glam::DVec2;

use crate::output::snapshot::Snapshot;

/// Colours of the classes, by increasing value.
pub(super) const COLORS: [&str; 8] =
    ["#f2f0eb", "#dde3e6", "#c3d0da", "#a5bacd", "#84a1bf", "#6286af", "#426a9b", "#274e83"];
/// Maximum size of the drawn specimen, px.
const FIT: DVec2 = DVec2::new(900.0, 820.0);
pub(super) const MARGIN: f64 = 24.0;
const HEAD: f64 = 60.0;
const FOOT: f64 = 64.0;
const NARROWEST: f64 = 620.0;
/// A disk counts as touching a wall if the distance of its centre is below this, in radii.
const TOUCHING: f64 = 1.05;

/// A picture that is being drawn.
pub(super) struct Sheet {
    /// SVG written so far.
    pub svg: String,
    /// px per m.
    pub scale: f64,
    /// Upper edge of the foot, px.
    pub foot: f64,
    corner: DVec2,
    /// Upper left corner of the specimen, m.
    origin: DVec2,
}

impl Sheet {
    /// Begins the picture of a specimen; `None` without disks.
    pub fn new(now: &Snapshot, title: &str, caption: &str) -> Option<Self> {
        let (low, high) = now.bounds()?;
        let size = high - low;
        let scale = (FIT / size).min_element();
        let width = (size.x * scale + 2.0 * MARGIN).max(NARROWEST);
        let height = HEAD + size.y * scale + 2.0 * MARGIN + FOOT;
        let corner = DVec2::new(0.5 * (width - size.x * scale), HEAD + MARGIN);
        let mut svg = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
             <text x=\"{MARGIN}\" y=\"28\" font-size=\"18\">{}</text>\n\
             <text x=\"{MARGIN}\" y=\"50\" font-size=\"13\" fill=\"#555\">{}</text>",
            escape(title),
            escape(caption),
        );
        let _ = writeln!(
            svg,
            "<clipPath id=\"c\"><rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/></clipPath>",
            corner.x - 0.7 * MARGIN,
            corner.y - 0.7 * MARGIN,
            size.x * scale + 1.4 * MARGIN,
            size.y * scale + 1.4 * MARGIN,
        );
        let origin = DVec2::new(low.x, high.y);
        Some(Self { svg, scale, foot: height - FOOT, corner, origin })
    }

    /// Position of a point on the sheet, px.
    pub fn place(&self, x: DVec2) -> DVec2 {
        self.corner + DVec2::new(x.x - self.origin.x, self.origin.y - x.y) * self.scale
    }

    /// Draws all disks in the colours of their classes, with one SVG group per class.
    pub fn disks(&mut self, now: &Snapshot, class_of: impl Fn(usize) -> usize) {
        for (class, color) in COLORS.iter().enumerate() {
            let mut members = (0..now.positions.len()).filter(|i| class_of(*i) == class).peekable();
            if members.peek().is_none() {
                continue;
            }
            let _ = writeln!(self.svg, "<g fill=\"{color}\" stroke=\"#777\" stroke-width=\".3\">");
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

    /// Draws the walls: lines extended to all disks that touch them, thin walls as they are.
    pub fn walls(&mut self, now: &Snapshot) {
        let walls: Vec<_> = now.walls.iter().map(|wall| enclosing(*wall, now)).collect();
        self.segments(&walls, "#222", 2.0);
        self.segments(&now.plates, "#222", 2.0);
    }

    /// Draws segments (m) as one path.
    pub fn segments(&mut self, list: &[[DVec2; 2]], color: &str, width: f64) {
        if list.is_empty() {
            return;
        }
        let _ = write!(
            self.svg,
            "<path clip-path=\"url(#c)\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.1}\" \
             stroke-linecap=\"round\" d=\""
        );
        for [a, b] in list {
            let (a, b) = (self.place(*a), self.place(*b));
            let _ = write!(self.svg, "M{:.2} {:.2}L{:.2} {:.2}", a.x, a.y, b.x, b.y);
        }
        let _ = writeln!(self.svg, "\"/>");
    }

    /// Draws the colours of the classes, up to `top`, with an explanation.
    pub fn legend(&mut self, top: &str, text: &str) {
        let swatch = 40.0;
        for (class, color) in COLORS.iter().enumerate() {
            let _ = writeln!(
                self.svg,
                "<rect x=\"{:.0}\" y=\"{:.0}\" width=\"{swatch}\" height=\"12\" fill=\"{color}\" \
                 stroke=\"#777\" stroke-width=\".3\"/>",
                MARGIN + swatch * class as f64,
                self.foot + 8.0,
            );
        }
        let end = MARGIN + swatch * COLORS.len() as f64 + 8.0;
        let _ = writeln!(
            self.svg,
            "<g font-size=\"12\" fill=\"#333\"><text x=\"{end}\" y=\"{:.0}\">0 to {top}</text>\
             <text x=\"{MARGIN}\" y=\"{:.0}\">{text}</text></g>",
            self.foot + 18.0,
            self.foot + 40.0,
        );
    }

    /// The whole picture.
    pub fn end(mut self) -> String {
        self.svg.push_str("</svg>\n");
        self.svg
    }
}

/// Class of a value between 0 and `top`. The last class also contains larger values.
pub(super) fn class(value: f64, top: f64) -> usize {
    let last = COLORS.len() - 1;
    if value > 0.0 && top > 0.0 {
        ((value / top * COLORS.len() as f64) as usize).min(last)
    } else {
        0
    }
}

/// A wall segment extended to all disks that touch the wall. For contact a wall is an infinite
/// line, and disks may rest on it beyond the ends of its drawn segment.
fn enclosing([start, end]: [DVec2; 2], now: &Snapshot) -> [DVec2; 2] {
    let length = start.distance(end);
    let along = (end - start) / length;
    let touching = now.positions.iter().zip(&now.radii).filter_map(|(x, r)| {
        let from = *x - start;
        (along.perp_dot(from).abs() <= TOUCHING * r)
            .then(|| (from.dot(along) - r, from.dot(along) + r))
    });
    let ends = touching.fold((0.0_f64, length), |(low, high), (l, h)| (low.min(l), high.max(h)));
    [start + along * ends.0, start + along * ends.1]
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_are_as_long_as_what_touches_them() {
        // Three disks on a floor whose drawn segment lies under the middle disk only, and one disk
        // in the air.
        let now = Snapshot {
            positions: [(-3.0, 1.0), (0.0, 1.0), (4.0, 1.0), (9.0, 3.0)].map(DVec2::from).to_vec(),
            radii: vec![1.0; 4],
            ..Default::default()
        };
        let floor = enclosing([DVec2::new(-0.5, 0.0), DVec2::new(0.5, 0.0)], &now);
        assert_eq!(floor, [DVec2::new(-4.0, 0.0), DVec2::new(5.0, 0.0)]);
    }
}
