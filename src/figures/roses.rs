//! Roses: number of cracks or contacts, or mean force, by direction.

use std::f64::consts::PI;
use std::fmt::Write as _;

use glam::DVec2;

use super::fabric::{Fabric, SECTORS, roses, sector};
use super::moment::Moment;
use crate::output::plots::page::{self, Style, short as number};
use crate::output::plots::scale::{round_up, with_unit};

/// Points of a fitted curve.
const POINTS: u32 = 180;

/// Values by sector over half a turn. A rose shows each on both sides.
pub struct Rose {
    /// Layers from the centre outwards: colour, meaning, and a value for every sector.
    pub layers: Vec<(&'static str, String, [f64; SECTORS])>,
    /// Value at a direction in rad that a fit gives.
    pub fit: Option<Box<dyn Fn(f64) -> f64>>,
    /// Notes on the length of a sector and on the fit.
    pub notes: Vec<String>,
}

/// The rose of contacts that carry compression between disks.
#[must_use]
pub fn contacts(moment: &Moment) -> Option<Rose> {
    let fabric = Fabric::of(moment)?;
    let total = fabric.contacts as f64;
    // Density over a whole turn, times the turn: 1 in all directions if there is no fabric.
    let density = |number: usize| number as f64 / total * SECTORS as f64;
    let values = roses(moment).map(|(number, _)| density(number));
    let (a, angle) = fabric.contact;
    Some(Rose {
        layers: vec![("#739abf", format!("{} contacts", fabric.contacts), values)],
        fit: Some(Box::new(move |t| 1.0 + a * (2.0 * (t - angle)).cos())),
        notes: vec![
            "density of contacts by direction of the normal, over its mean".to_owned(),
            format!("line: 1 + a cos 2(t - t_a), a = {a:.3}, t_a = {:.1}°", angle.to_degrees()),
        ],
    })
}

/// The rose of mean normal forces.
#[must_use]
pub fn forces(moment: &Moment) -> Option<Rose> {
    let fabric = Fabric::of(moment)?;
    let means =
        roses(moment).map(|(number, sum)| if number > 0 { sum / number as f64 } else { 0.0 });
    let overall = means.iter().sum::<f64>() / means.iter().filter(|m| **m > 0.0).count() as f64;
    let (a, angle) = fabric.force;
    Some(Rose {
        layers: vec![("#739abf", String::new(), means.map(|mean| mean / overall))],
        fit: Some(Box::new(move |t| 1.0 + a * (2.0 * (t - angle)).cos())),
        notes: vec![
            "mean normal force by direction of the normal, over its mean".to_owned(),
            format!("mean: {}", with_unit(overall, "N")),
            format!("line: 1 + a_n cos 2(t - t_n), a_n = {a:.3}, t_n = {:.1}°", angle.to_degrees()),
        ],
    })
}

/// The rose of cracks: direction of the stroke, by mode. `None` without cracks.
#[must_use]
pub fn cracks(normals: &[(DVec2, usize)]) -> Option<Rose> {
    const MODES: [(&str, &str); 3] =
        [("#d7191c", "tension"), ("#1a1a1a", "shear"), ("#d68a00", "rolling")];
    if normals.is_empty() {
        return None;
    }
    let layer = |mode: usize| {
        let mut values = [0.0; SECTORS];
        for (normal, _) in normals.iter().filter(|(_, of)| *of == mode) {
            values[sector(normal.perp().to_angle())] += 1.0;
        }
        let number = values.iter().sum::<f64>();
        let (color, name) = MODES[mode];
        (number > 0.0).then(|| (color, format!("{number} in {name}"), values))
    };
    let width = 180 / SECTORS;
    Some(Rose {
        layers: (0..3).filter_map(layer).collect(),
        fit: None,
        notes: vec![format!(
            "number of cracks by direction of the crack as it broke, in sectors of {width}°"
        )],
    })
}

impl Rose {
    /// Draws the rose.
    #[must_use]
    pub fn svg(&self, style: &Style, title: &str) -> String {
        let mut svg = String::new();
        let page = Page::new(style);
        let top = page.title(&mut svg, title);
        let radius = page.radius();
        let sums = (0..SECTORS).map(|k| self.layers.iter().map(|(_, _, v)| v[k]).sum());
        let end = round_up(sums.fold(0.0, f64::max));
        let disk = Disk {
            font: page.font,
            centre: DVec2::new(0.5 * page.width, top + 1.6 * page.font + radius),
            radius,
            end,
        };
        disk.circles(&mut svg);
        disk.sectors(&mut svg, &self.layers);
        if let Some(fit) = &self.fit {
            disk.curve(&mut svg, fit);
        }
        disk.angles(&mut svg);
        disk.values(&mut svg);
        let mut y = disk.centre.y + radius + 2.2 * page.font;
        if self.layers.len() > 1 || self.fit.is_none() {
            y = self.legend(&mut svg, &page, y);
        }
        y = self.remarks(&mut svg, &page, y);
        format!("{}{svg}</svg>\n", style.root(DVec2::new(page.width, y + page.margin)))
    }

    /// Writes the meanings of the layers below `y` and returns where they end.
    fn legend(&self, svg: &mut String, page: &Page, mut y: f64) -> f64 {
        let Page { font, margin, width } = *page;
        let mut x = margin;
        for (color, name, _) in &self.layers {
            let size = 1.4 * font + page::width(name, font);
            if x > margin && x + size > width - margin {
                (x, y) = (margin, y + 1.4 * font);
            }
            let _ = writeln!(
                svg,
                "<rect x=\"{0}\" y=\"{1}\" width=\"{2}\" height=\"{2}\" fill=\"{color}\"/>",
                number(x),
                number(y),
                number(0.9 * font),
            );
            let at = DVec2::new(x + 1.4 * font, y + 0.85 * font);
            page::text(svg, at, font, "start", "#222", name);
            x += size + 1.5 * font;
        }
        y + 1.5 * font
    }

    /// Writes the notes below `y` and returns where they end.
    fn remarks(&self, svg: &mut String, page: &Page, mut y: f64) -> f64 {
        let Page { font, margin, width } = *page;
        for note in &self.notes {
            for line in page::wrapped(note, font, width - 2.0 * margin) {
                let at = DVec2::new(margin, y + 0.85 * font);
                page::text(svg, at, font, "start", "#222", &line);
                y += 1.35 * font;
            }
        }
        y
    }
}

/// The page of a rose, in units of the picture.
struct Page {
    font: f64,
    margin: f64,
    width: f64,
}

impl Page {
    fn new(style: &Style) -> Self {
        let font = style.font;
        let width = if style.width_mm.is_some() { style.narrowest } else { 520.0 };
        Self { font, margin: style.margin.max(0.5 * font), width }
    }

    /// Radius of the rose, with room for the labels of the angles.
    fn radius(&self) -> f64 {
        let room = 3.2 * self.font;
        0.5 * (self.width - 2.0 * (self.margin + room))
    }

    /// Writes the title and returns where it ends.
    fn title(&self, svg: &mut String, title: &str) -> f64 {
        let Self { font, margin, width } = *self;
        let mut top = margin;
        for line in page::wrapped(title, 1.2 * font, width - 2.0 * margin) {
            top += 1.2 * font;
            page::text(svg, DVec2::new(margin, top), 1.2 * font, "start", "#222", &line);
            top += 0.5 * font;
        }
        top
    }
}

/// The circle of a rose.
struct Disk {
    font: f64,
    centre: DVec2,
    radius: f64,
    /// Value at the circle.
    end: f64,
}

impl Disk {
    fn scale(&self) -> f64 {
        self.radius / self.end
    }

    /// Place of the value `r` in the direction `t`, rad.
    fn place(&self, r: f64, t: f64) -> DVec2 {
        self.centre + r * self.scale() * DVec2::new(t.cos(), -t.sin())
    }

    /// Draws the circles of the end and of its half.
    fn circles(&self, svg: &mut String) {
        for part in [0.5, 1.0] {
            let _ = writeln!(
                svg,
                "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"none\" stroke=\"#ccc\" \
                 stroke-width=\"{}\"/>",
                number(self.centre.x),
                number(self.centre.y),
                number(self.radius * part),
                number(0.06 * self.font)
            );
        }
    }

    /// Draws the layers, each outside of those before it.
    fn sectors(&self, svg: &mut String, layers: &[(&'static str, String, [f64; SECTORS])]) {
        let mut inner = [0.0; SECTORS];
        for (color, _, values) in layers {
            let _ = write!(
                svg,
                "<path fill=\"{color}\" stroke=\"#fff\" stroke-width=\"{}\" d=\"",
                number(0.05 * self.font)
            );
            for k in (0..2 * SECTORS).filter(|k| values[k % SECTORS] > 0.0) {
                let low = inner[k % SECTORS];
                self.sector(svg, k, low, low + values[k % SECTORS]);
            }
            let _ = writeln!(svg, "\"/>");
            for (inner, value) in inner.iter_mut().zip(values) {
                *inner += value;
            }
        }
    }

    /// Draws sector `k` and the sector opposite to it, from one radius to another.
    fn sector(&self, svg: &mut String, k: usize, low: f64, high: f64) {
        let [from, to] = [k, k + 1].map(|k| k as f64 * PI / SECTORS as f64);
        let corners = [(low, from), (high, from), (high, to), (low, to)];
        let [a, b, c, d] = corners.map(|(r, t)| {
            let x = self.place(r, t);
            format!("{:.2} {:.2}", x.x, x.y)
        });
        let (outer, back) = (number(high * self.scale()), number(low * self.scale()));
        let _ = write!(svg, "M{a}L{b}A{outer} {outer} 0 0 0 {c}L{d}");
        let _ = if low > 0.0 { write!(svg, "A{back} {back} 0 0 1 {a}Z") } else { write!(svg, "Z") };
    }

    /// Draws the curve of a fit.
    fn curve(&self, svg: &mut String, fit: &dyn Fn(f64) -> f64) {
        let points = (0..=POINTS).map(|k| {
            let t = 2.0 * PI * f64::from(k) / f64::from(POINTS);
            let x = self.place(fit(t).max(0.0), t);
            format!("{:.2} {:.2}", x.x, x.y)
        });
        let points: Vec<String> = points.collect();
        let _ = writeln!(
            svg,
            "<path fill=\"none\" stroke=\"#d7191c\" stroke-width=\"{}\" d=\"M{}\"/>",
            number(0.12 * self.font),
            points.join("L")
        );
    }

    /// Writes four angles around the circle.
    fn angles(&self, svg: &mut String) {
        let font = self.font;
        for (angle, label, anchor) in [
            (0.0, "0°", "start"),
            (90.0, "90°", "middle"),
            (180.0, "180°", "end"),
            (270.0, "270°", "middle"),
        ] {
            let outward = DVec2::from_angle(f64::to_radians(-angle));
            // Letters stand on their base line.
            let base = DVec2::new(0.0, 0.35 * font + 0.35 * font * outward.y);
            let at = self.centre + (self.radius + 0.5 * font) * outward + base;
            page::text(svg, at, font, anchor, "#222", label);
        }
    }

    /// Writes the values of the circles.
    fn values(&self, svg: &mut String) {
        let font = self.font;
        for part in [0.5, 1.0] {
            let at = self.place(part * self.end, PI / 4.0) + DVec2::new(0.2 * font, -0.2 * font);
            // A white outline, since the number may stand on a sector.
            let _ = writeln!(
                svg,
                "<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"#222\" stroke=\"#fff\" \
                 stroke-width=\"{}\" stroke-linejoin=\"round\" paint-order=\"stroke\">{}</text>",
                number(at.x),
                number(at.y),
                number(0.85 * font),
                number(0.3 * font),
                short(part * self.end),
            );
        }
    }
}

/// A number without digits of round-off.
fn short(value: f64) -> String {
    format!("{value:.4e}").parse::<f64>().unwrap_or(value).to_string()
}
