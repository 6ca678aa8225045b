//! Stress and volumetric strain against axial strain.

use super::chart::{Chart, Line};
use super::history::History;

/// Sign conventions, for captions.
pub const SIGNS: &str = "compression and contraction positive";
/// Label of the axis of strain.
pub const STRAIN: &str = "axial strain, %";

/// Stress and broken bonds against axial strain, if stress and strain are defined.
pub fn stress(title: &str, history: &History) -> Option<Chart> {
    let axial = history.curve("axial_stress_pa");
    let lateral = history.curve("lateral_stress_pa");
    if axial.is_empty() {
        return None;
    }
    let (unit, pascals) = stress_unit(axial.iter().chain(&lateral).map(|p| p.1));
    let mut lines = Vec::new();
    for (name, points) in [("axial stress", axial), ("lateral stress", lateral)] {
        if !points.is_empty() {
            let points = points.into_iter().map(|(e, s)| (100.0 * e, s / pascals)).collect();
            lines.push(Line { name: name.to_owned(), points });
        }
    }
    Some(Chart {
        title: title.to_owned(),
        caption: SIGNS.to_owned(),
        x: STRAIN.to_owned(),
        y: format!("stress, {unit}"),
        lines,
        second: broken(history),
        equal: false,
    })
}

/// Unit in which stresses of this magnitude have few digits, and its value in Pa.
pub(super) fn stress_unit(stresses: impl Iterator<Item = f64>) -> (&'static str, f64) {
    match stresses.map(f64::abs).fold(0.0, f64::max) {
        s if s >= 1e6 => ("MPa", 1e6),
        s if s >= 1e3 => ("kPa", 1e3),
        _ => ("Pa", 1.0),
    }
}

/// Broken bonds of all modes against axial strain; `None` if no bond has broken.
fn broken(history: &History) -> Option<Line> {
    let modes =
        ["broken_tension", "broken_shear", "broken_rolling"].map(|mode| history.curve(mode));
    let of_row = |(row, point): (usize, &(f64, f64))| {
        let broken: Option<f64> = modes.iter().map(|mode| mode.get(row).map(|p| p.1)).sum();
        Some((100.0 * point.0, broken?))
    };
    let points: Vec<_> = modes[0].iter().enumerate().filter_map(of_row).collect();
    let any = points.iter().any(|p| p.1 > 0.0);
    any.then(|| Line { name: "broken bonds".to_owned(), points })
}

/// Volumetric strain against axial strain.
pub fn volumetric(title: &str, history: &History) -> Option<Chart> {
    let points = history.curve("volumetric_strain");
    let points: Vec<_> = points.into_iter().map(|(a, v)| (100.0 * a, 100.0 * v)).collect();
    let line = Line { name: "volumetric strain".to_owned(), points };
    (!line.points.is_empty()).then(|| Chart {
        title: title.to_owned(),
        caption: SIGNS.to_owned(),
        x: STRAIN.to_owned(),
        y: "volumetric strain, %".to_owned(),
        lines: vec![line],
        second: None,
        equal: false,
    })
}
