//! A specimen to scale: disks coloured by what they did, walls, broken bonds in red.
//!
//! Written by hand: one group a colour class and few digits keep thousands of disks small.

use std::fmt::Write as _;

use glam::DVec2;

use crate::output::snapshot::Snapshot;

/// Colours of the classes, from the smallest to the greatest value.
const COLORS: [&str; 8] =
    ["#f2f0eb", "#dde3e6", "#c3d0da", "#a5bacd", "#84a1bf", "#6286af", "#426a9b", "#274e83"];
/// The box into which a specimen is fitted, px.
const FIT: DVec2 = DVec2::new(900.0, 820.0);
const MARGIN: f64 = 24.0;
const HEAD: f64 = 60.0;
const FOOT: f64 = 64.0;
const NARROWEST: f64 = 620.0;
/// A disk touches a wall where its centre is nearer than this, in radii.
const TOUCHING: f64 = 1.05;

/// Draws the specimen `now`; none without disks. Rotations and displacements count from `start`.
#[must_use]
pub fn svg(now: &Snapshot, start: &Snapshot, title: &str, caption: &str) -> Option<String> {
    let (low, high) = now.bounds()?;
    let size = high - low;
    let scale = (FIT / size).min_element();
    let width = (size.x * scale + 2.0 * MARGIN).max(NARROWEST);
    let height = HEAD + size.y * scale + 2.0 * MARGIN + FOOT;
    let corner = DVec2::new(0.5 * (width - size.x * scale), HEAD + MARGIN);
    let place = |x: DVec2| corner + DVec2::new(x.x - low.x, high.y - x.y) * scale;

    let colouring = Colouring::of(now, start);
    let mut svg = String::new();
    // Writing to a string does not fail.
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
    for (class, color) in COLORS.iter().enumerate() {
        let mut members =
            (0..now.positions.len()).filter(|i| colouring.class(*i) == class).peekable();
        if members.peek().is_none() {
            continue;
        }
        let _ = writeln!(svg, "<g fill=\"{color}\" stroke=\"#777\" stroke-width=\".3\">");
        for i in members {
            let (c, r) = (place(now.positions[i]), now.radii[i] * scale);
            let _ = writeln!(svg, "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"{r:.2}\"/>", c.x, c.y);
        }
        let _ = writeln!(svg, "</g>");
    }
    let mean_radius = now.radii.iter().sum::<f64>() / now.radii.len() as f64 * scale;
    let crack_width = (0.5 * mean_radius).clamp(1.0, 4.0);
    segments(&mut svg, &now.cracks, "#e00000", crack_width, place);
    let walls: Vec<_> = now.walls.iter().map(|wall| enclosing(*wall, now)).collect();
    segments(&mut svg, &walls, "#222", 2.0, place);
    legend(&mut svg, &colouring, now.cracks.len(), height - FOOT);
    svg.push_str("</svg>\n");
    Some(svg)
}

/// A wall as long as what touches it: for contact it is an infinite line, and disks may rest on it
/// beyond the ends of its drawn segment.
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

/// A number with three digits in the unit with the prefix that suits it.
fn with_prefix(value: f64, unit: &str) -> String {
    let (prefix, size) = match value.abs() {
        0.0 => ("", 1.0),
        v if v >= 999.5 => ("k", 1e3),
        v if v >= 0.9995 => ("", 1.0),
        v if v >= 0.9995e-3 => ("m", 1e-3),
        v if v >= 0.9995e-6 => ("µ", 1e-6),
        _ => ("n", 1e-9),
    };
    let value = value / size;
    let digits = if value < 9.995 { 2 } else { usize::from(value < 99.95) };
    format!("{value:.digits$} {prefix}{unit}")
}

/// Segments as one path.
fn segments(
    svg: &mut String,
    list: &[[DVec2; 2]],
    color: &str,
    width: f64,
    place: impl Fn(DVec2) -> DVec2,
) {
    if list.is_empty() {
        return;
    }
    let _ = write!(
        svg,
        "<path clip-path=\"url(#c)\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width:.1}\" \
         stroke-linecap=\"round\" d=\""
    );
    for [a, b] in list {
        let (a, b) = (place(*a), place(*b));
        let _ = write!(svg, "M{:.2} {:.2}L{:.2} {:.2}", a.x, a.y, b.x, b.y);
    }
    let _ = writeln!(svg, "\"/>");
}

fn legend(svg: &mut String, colouring: &Colouring, cracks: usize, top: f64) {
    let swatch = 40.0;
    for (class, color) in COLORS.iter().enumerate() {
        let _ = writeln!(
            svg,
            "<rect x=\"{:.0}\" y=\"{:.0}\" width=\"{swatch}\" height=\"12\" fill=\"{color}\" \
             stroke=\"#777\" stroke-width=\".3\"/>",
            MARGIN + swatch * class as f64,
            top + 8.0,
        );
    }
    let end = MARGIN + swatch * COLORS.len() as f64 + 8.0;
    let cracks = match cracks {
        0 => String::new(),
        1 => "; red: the one broken bond".to_owned(),
        n => format!("; red: the {n} broken bonds"),
    };
    let _ = writeln!(
        svg,
        "<g font-size=\"12\" fill=\"#333\"><text x=\"{end}\" y=\"{:.0}\">0 to {} and more</text>\
         <text x=\"{MARGIN}\" y=\"{:.0}\">blue: {}{cracks}</text></g>",
        top + 18.0,
        with_prefix(colouring.top, colouring.unit),
        top + 40.0,
        colouring.name,
    );
}

/// What the colours say.
struct Colouring {
    name: &'static str,
    unit: &'static str,
    /// Upper end of the scale; the last class also holds what lies beyond.
    top: f64,
    values: Vec<f64>,
}

impl Colouring {
    /// Rotations, which show bands best; displacements where nothing turned.
    fn of(now: &Snapshot, start: &Snapshot) -> Self {
        let before = |i: usize| start.rotations.get(i).copied().unwrap_or(0.0);
        let rotations: Vec<_> =
            now.rotations.iter().enumerate().map(|(i, r)| (r - before(i)).abs()).collect();
        let turned = rotations.iter().any(|r| *r > 1e-12);
        let (name, unit, values) = if turned {
            ("magnitude of rotation since the start of the reference stage", "rad", rotations)
        } else {
            let moved = now.positions.iter().zip(&start.positions).map(|(x, x0)| x.distance(*x0));
            (
                "magnitude of displacement since the start of the reference stage",
                "m",
                moved.collect(),
            )
        };
        let mut sorted: Vec<f64> = values.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        // A few loose grains that spin must not paint all others in one colour.
        let top = sorted.get(sorted.len() * 49 / 50).or(sorted.last()).copied().unwrap_or(0.0);
        Self { name, unit, top, values }
    }

    fn class(&self, particle: usize) -> usize {
        let value = self.values.get(particle).copied().unwrap_or(0.0);
        let last = COLORS.len() - 1;
        if value > 0.0 && self.top > 0.0 {
            ((value / self.top * COLORS.len() as f64) as usize).min(last)
        } else {
            0
        }
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(columns: usize, rows: usize) -> Snapshot {
        let cell = |k: usize| DVec2::new((k % columns) as f64, (k / columns) as f64) * 1e-3;
        let n = columns * rows;
        Snapshot {
            positions: (0..n).map(cell).collect(),
            radii: vec![0.5e-3; n],
            rotations: (0..n).map(|k| k as f64 * 1e-5).collect(),
            displacements: vec![DVec2::ZERO; n],
            walls: vec![[DVec2::ZERO, DVec2::X]],
            cracks: (1..n).map(|k| [cell(k - 1), cell(k)]).collect(),
        }
    }

    #[test]
    fn a_full_size_specimen_stays_small_and_its_bytes_are_fixed() {
        let (now, start) = (grid(41, 180), Snapshot::default());
        let svg = svg(&now, &start, "a < b", "caption").unwrap_or_default();
        assert!(svg.len() < 1_000_000, "{} bytes", svg.len());
        assert_eq!(svg.matches("<circle").count(), 7380);
        assert!(svg.contains("a &lt; b"));
        assert_eq!(Some(svg), super::svg(&now, &start, "a < b", "caption"));
    }

    #[test]
    fn legend_numbers_are_readable() {
        let said = [41.5, 0.0123, 4.15e-5, 1234.0, 0.0, 0.9996].map(|v| with_prefix(v, "rad"));
        let expected = ["41.5 rad", "12.3 mrad", "41.5 µrad", "1.23 krad", "0.00 rad", "1.00 rad"];
        assert_eq!(said, expected);
    }

    #[test]
    fn walls_are_as_long_as_what_touches_them() {
        // Three disks on a floor that is drawn under the middle one alone; one in the air.
        let now = Snapshot {
            positions: [(-3.0, 1.0), (0.0, 1.0), (4.0, 1.0), (9.0, 3.0)].map(DVec2::from).to_vec(),
            radii: vec![1.0; 4],
            ..Default::default()
        };
        let floor = enclosing([DVec2::new(-0.5, 0.0), DVec2::new(0.5, 0.0)], &now);
        assert_eq!(floor, [DVec2::new(-4.0, 0.0), DVec2::new(5.0, 0.0)]);
    }

    #[test]
    fn nothing_is_drawn_without_disks() {
        assert_eq!(svg(&Snapshot::default(), &Snapshot::default(), "", ""), None);
    }
}
