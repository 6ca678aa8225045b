//! Curves of several runs in one chart.

use super::chart::{Chart, Line};
use super::history::History;
use super::stress_strain::{SIGNS, STRAIN, stress_unit};

/// Runs with their names in the legend.
pub type Runs = [(String, History)];

/// Axial stress against axial strain; `None` if no run defines them.
pub fn stress(runs: &Runs) -> Option<Chart> {
    let lines = lines(runs, "axial_stress_pa");
    let (unit, pascals) = stress_unit(lines.iter().flat_map(|line| &line.points).map(|p| p.1));
    chart("Axial stress", format!("axial stress, {unit}"), scaled(lines, pascals.recip()))
}

/// Volumetric against axial strain; `None` if no run defines them.
pub fn volumetric(runs: &Runs) -> Option<Chart> {
    let lines = scaled(lines(runs, "volumetric_strain"), 100.0);
    chart("Volumetric strain", "volumetric strain, %".to_owned(), lines)
}

fn lines(runs: &Runs, column: &str) -> Vec<Line> {
    let line = |(name, history): &(String, History)| Line {
        name: name.clone(),
        points: history.curve(column),
    };
    // Runs without the column keep an empty line, so that the colour of a run is equal in all
    // pictures.
    runs.iter().map(line).collect()
}

/// Converts strain to per cent and multiplies the other axis by a factor.
fn scaled(mut lines: Vec<Line>, factor: f64) -> Vec<Line> {
    for point in lines.iter_mut().flat_map(|line| &mut line.points) {
        *point = (100.0 * point.0, factor * point.1);
    }
    lines
}

fn chart(title: &str, y: String, lines: Vec<Line>) -> Option<Chart> {
    lines.iter().any(|line| !line.points.is_empty()).then(|| Chart {
        title: title.to_owned(),
        caption: SIGNS.to_owned(),
        x: STRAIN.to_owned(),
        y,
        lines,
        second: None,
        equal: false,
    })
}
