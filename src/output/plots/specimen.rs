//! A specimen to scale: disks coloured by rotation or displacement, walls, broken bonds in red.

use super::sheet::{Sheet, class};
use crate::output::snapshot::Snapshot;

/// Draws the specimen `now`; `None` without disks. Rotations and displacements are relative to
/// `start`.
#[must_use]
pub fn svg(now: &Snapshot, start: &Snapshot, title: &str, caption: &str) -> Option<String> {
    let mut sheet = Sheet::new(now, title, caption)?;
    let colouring = Colouring::of(now, start);
    sheet.disks(now, |i| colouring.class(i));
    let mean_radius = now.radii.iter().sum::<f64>() / now.radii.len() as f64 * sheet.scale;
    let crack_width = (0.5 * mean_radius).clamp(1.0, 4.0);
    sheet.segments(&now.cracks, "#e00000", crack_width);
    sheet.walls(now);
    sheet.segments(&now.membranes, "#0a7f3f", 1.2);
    let cracks = match now.cracks.len() {
        0 => String::new(),
        1 => "; red: the one broken bond".to_owned(),
        n => format!("; red: the {n} broken bonds"),
    };
    let membrane = if now.membranes.is_empty() { "" } else { "; green: membrane" };
    let top = format!("{} and more{membrane}", with_prefix(colouring.top, colouring.unit));
    sheet.legend(&top, &format!("blue: {}{cracks}", colouring.name));
    Some(sheet.end())
}

/// A number with three digits in the unit with a suitable prefix.
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

/// Meaning and scale of the colours.
struct Colouring {
    name: &'static str,
    unit: &'static str,
    /// Upper end of the scale. The last class also contains larger values.
    top: f64,
    values: Vec<f64>,
}

impl Colouring {
    /// Rotations, which show shear bands best, or displacements if no disk has rotated.
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
        // The quantile keeps a few spinning rattlers from determining the scale.
        let top = sorted.get(sorted.len() * 49 / 50).or(sorted.last()).copied().unwrap_or(0.0);
        Self { name, unit, top, values }
    }

    fn class(&self, particle: usize) -> usize {
        class(self.values.get(particle).copied().unwrap_or(0.0), self.top)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn grid(columns: usize, rows: usize) -> Snapshot {
        let cell = |k: usize| DVec2::new((k % columns) as f64, (k / columns) as f64) * 1e-3;
        let n = columns * rows;
        Snapshot {
            ids: (0..n as u32).collect(),
            positions: (0..n).map(cell).collect(),
            radii: vec![0.5e-3; n],
            rotations: (0..n).map(|k| k as f64 * 1e-5).collect(),
            displacements: vec![DVec2::ZERO; n],
            walls: vec![[DVec2::ZERO, DVec2::X]],
            plates: Vec::new(),
            cracks: (1..n).map(|k| [cell(k - 1), cell(k)]).collect(),
            membranes: Vec::new(),
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
    fn nothing_is_drawn_without_disks() {
        assert_eq!(svg(&Snapshot::default(), &Snapshot::default(), "", ""), None);
    }
}
