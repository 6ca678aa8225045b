//! The mechanism of a collapse: an arrow at every moving body, and disks coloured by rotation.

use glam::DVec2;

use super::scale::Scale;
use super::sheet::{Sample, Sheet};
use crate::output::mechanism::Mechanism;
use crate::output::snapshot::Snapshot;

const COLOR: &str = "#e00000";
/// Length of the longest arrow in mean radii. Its length in px has bounds, so that it is visible
/// and stays in the picture even near the edge.
const LONGEST: f64 = 3.0;
const LIMITS: [f64; 2] = [14.0, 38.0];
/// Minimum length of arrows that are drawn, px.
const SHORTEST: f64 = 0.5;
/// Length of the barbs over that of the arrow.
const BARB: f64 = 0.3;
/// Angle between barbs and shaft, rad.
const SPREAD: f64 = 0.45;

/// Draws a mechanism of the specimen `now`; none without disks.
#[must_use]
pub fn svg(mechanism: &Mechanism, now: &Snapshot, title: &str, caption: &str) -> Option<String> {
    let mut sheet = Sheet::new(now, title, caption)?;
    let rows = &mechanism.rows;
    let rotations = rows.iter().take(now.positions.len()).map(|row| row.rotation.abs());
    let rotations: Vec<f64> = rotations.collect();
    let top = rotations.iter().copied().fold(0.0, f64::max);
    let relative: Vec<f64> =
        rotations.iter().map(|r| if top > 0.0 { r / top } else { 0.0 }).collect();
    let name = "magnitude of rotation, over the maximum";
    let scale = Scale { high: 1.0, exceeded: false, ..Scale::of_magnitudes(&relative, name, "") };
    sheet.disks(now, scale.colors, |i| scale.class(relative.get(i).copied().unwrap_or(0.0)));
    sheet.walls(now);

    let mean_radius = now.radii.iter().sum::<f64>() / now.radii.len() as f64;
    let longest = (LONGEST * mean_radius).clamp(LIMITS[0] / sheet.scale, LIMITS[1] / sheet.scale);
    let maximum = rows.iter().map(|row| row.displacement.length()).fold(0.0, f64::max);
    let arrows: Vec<_> = rows
        .iter()
        .map(|row| (row.position, row.displacement * (longest / maximum)))
        // The scale is NaN if all bodies only rotate.
        .filter(|(_, shaft)| shaft.length() * sheet.scale >= SHORTEST)
        .flat_map(|(from, shaft)| arrow(from, shaft))
        .collect();
    sheet.segments(&arrows, COLOR, 1.0);
    sheet.bar(&scale);
    let text = "displacements, in proportion".to_owned();
    sheet.samples(&[Sample { color: COLOR, stroke: Some(1.0), text }]);
    Some(sheet.end())
}

/// Shaft and barbs of an arrow.
fn arrow(from: DVec2, shaft: DVec2) -> [[DVec2; 2]; 3] {
    let tip = from + shaft;
    let barb = |angle: f64| [tip, tip - BARB * DVec2::from_angle(angle).rotate(shaft)];
    [[from, tip], barb(SPREAD), barb(-SPREAD)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::mechanism::MechanismRow;
    use crate::run::key_results::MechanismRecord;

    #[test]
    fn what_moves_has_an_arrow() {
        let now = Snapshot {
            positions: vec![DVec2::ZERO, DVec2::X],
            radii: vec![0.5; 2],
            ..Default::default()
        };
        let row = |body: usize, displacement| MechanismRow {
            body,
            position: now.positions[body],
            displacement,
            rotation: 0.0,
        };
        let mut mechanism = Mechanism {
            record: MechanismRecord { increment: 1, margin: 1.0, defect: 0.0 },
            rows: vec![row(0, DVec2::ZERO), row(1, DVec2::Y)],
        };
        let arrows = |mechanism: &Mechanism| {
            let svg = svg(mechanism, &now, "", "").unwrap_or_default();
            assert_eq!(svg.matches("<circle").count(), 2);
            svg.matches('M').count().saturating_sub(1) / 3
        };
        assert_eq!(arrows(&mechanism), 1);
        mechanism.rows[1].displacement = DVec2::ZERO;
        assert_eq!(arrows(&mechanism), 0);
    }
}
