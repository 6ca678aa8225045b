//! A specimen to scale: disks coloured by rotation or displacement, walls, broken bonds as strokes.

use glam::DVec2;

use clastic_components::bond::RuptureMode;

use super::page::Style;
use super::scale::Scale;
use super::sheet::{Sample, Sheet};
use crate::output::crack::Crack;
use crate::output::snapshot::Snapshot;
use crate::scene::format::Scene;

/// Width of a crack over the mean radius.
const CRACK: f64 = 0.13;
/// Minimum width of a crack over the size of the font.
const THINNEST: f64 = 0.06;
/// Colour of a membrane.
const MEMBRANE: &str = "#0a7f3f";
/// Width of a membrane over the size of the font.
const MEMBRANE_WIDTH: f64 = 0.1;

/// What the colours of the disks show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Magnitude of the rotation, which shows shear bands best.
    Rotation,
    /// Magnitude of the displacement, for grains that roll and fall.
    Displacement,
}

impl Field {
    /// The field of the pictures of a run: rotations where the scene measures an axial strain,
    /// since a specimen is tested there, and displacements where grains flow.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        if scene.strain("axial_strain").is_some() { Self::Rotation } else { Self::Displacement }
    }
}

/// Draws the specimen `now`; `None` without disks. Rotations and displacements are relative to
/// `start`.
#[must_use]
pub fn svg(
    now: &Snapshot,
    start: &Snapshot,
    field: Field,
    title: &str,
    caption: &str,
    cracks: bool,
) -> Option<String> {
    let mut sheet = Sheet::new(now, title, caption)?;
    let (scale, values) = colouring(now, start, field);
    sheet.disks(now, scale.colors, |i| scale.class(values.get(i).copied().unwrap_or(0.0)));
    if cracks {
        draw_cracks(&mut sheet, now);
    }
    sheet.walls(now);
    draw_membranes(&mut sheet, now);
    sheet.bar(&scale);
    let mut samples = if cracks { crack_samples(&now.cracks, &sheet.style) } else { Vec::new() };
    samples.extend(membrane_sample(now, &sheet.style));
    if cracks || !samples.is_empty() {
        sheet.samples(&samples);
    }
    Some(sheet.end())
}

/// Draws the chains of membranes.
pub fn draw_membranes(sheet: &mut Sheet, now: &Snapshot) {
    let width = MEMBRANE_WIDTH * sheet.style.font;
    sheet.segments(&now.membranes, MEMBRANE, width);
}

/// Entry of the legend for membranes, if there are any.
#[must_use]
pub fn membrane_sample(now: &Snapshot, style: &Style) -> Option<Sample> {
    let stroke = Some(MEMBRANE_WIDTH * style.font);
    let text = "membrane".to_owned();
    (!now.membranes.is_empty()).then_some(Sample { color: MEMBRANE, stroke, text })
}

/// Colour of a crack.
#[must_use]
pub fn color(mode: RuptureMode) -> &'static str {
    match mode {
        RuptureMode::Tension => "#d7191c",
        RuptureMode::Shear => "#1a1a1a",
        RuptureMode::Rolling => "#d68a00",
    }
}

const MODES: [RuptureMode; 3] = [RuptureMode::Tension, RuptureMode::Shear, RuptureMode::Rolling];

/// Draws the broken bonds by mode.
pub fn draw_cracks(sheet: &mut Sheet, now: &Snapshot) {
    let mean = now.radii.iter().sum::<f64>() / now.radii.len().max(1) as f64;
    let width = (CRACK * mean * sheet.scale).max(THINNEST * sheet.style.font);
    for mode in MODES {
        let of_mode = now.cracks.iter().filter(|crack| crack.mode == mode);
        let strokes: Vec<[DVec2; 2]> = of_mode.map(|crack| crack.ends).collect();
        sheet.segments(&strokes, color(mode), width);
    }
}

/// Entries of the legend: how many bonds broke in each mode, in few words where the page is narrow.
#[must_use]
pub fn crack_samples(cracks: &[Crack], style: &Style) -> Vec<Sample> {
    let entry = |mode: RuptureMode| {
        let n = cracks.iter().filter(|crack| crack.mode == mode).count();
        let mut text = format!("{n} broken in {}", mode.name());
        if Sample::width(&text, style.font) + 2.0 * style.margin > style.narrowest {
            text = format!("{n} {}", mode.name());
        }
        (n > 0).then(|| Sample { color: color(mode), stroke: Some(0.15 * style.font), text })
    };
    MODES.into_iter().filter_map(entry).collect()
}

/// Scale and values of the colours. Particles may have come or gone since the start.
fn colouring(now: &Snapshot, start: &Snapshot, field: Field) -> (Scale, Vec<f64>) {
    let since = "since the start of the reference stage";
    let before = |i: usize| start.ids.binary_search(&now.ids[i]).ok();
    if field == Field::Rotation {
        let turned =
            |(i, r): (usize, &f64)| (r - before(i).map_or(0.0, |k| start.rotations[k])).abs();
        let rotations: Vec<_> = now.rotations.iter().enumerate().map(turned).collect();
        if rotations.iter().any(|r| *r > 1e-12) {
            let name = format!("magnitude of rotation {since}");
            return (Scale::of_magnitudes(&rotations, &name, "rad"), rotations);
        }
    }
    let moved = |(i, x): (usize, &DVec2)| before(i).map_or(0.0, |k| x.distance(start.positions[k]));
    let moved: Vec<_> = now.positions.iter().enumerate().map(moved).collect();
    let name = format!("magnitude of displacement {since}");
    (Scale::of_magnitudes(&moved, &name, "m"), moved)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(columns: usize, rows: usize) -> Snapshot {
        let cell = |k: usize| DVec2::new((k % columns) as f64, (k / columns) as f64) * 1e-3;
        let n = columns * rows;
        let crack = |k: usize| {
            let mode = MODES[k % 2];
            Crack::between_disks((cell(k - 1), 0.5e-3), (cell(k), 0.5e-3), mode)
        };
        Snapshot {
            ids: (0..n as u32).collect(),
            positions: (0..n).map(cell).collect(),
            radii: vec![0.5e-3; n],
            rotations: (0..n).map(|k| k as f64 * 1e-5).collect(),
            displacements: vec![DVec2::ZERO; n],
            walls: vec![[DVec2::ZERO, DVec2::X]],
            plates: Vec::new(),
            cracks: (1..n).map(crack).collect(),
            membranes: Vec::new(),
        }
    }

    /// Colours once went by place in the tables, so that what was removed coloured all that came after it.
    #[test]
    fn a_removed_particle_changes_no_other_colour() {
        let start = grid(3, 2);
        let mut now = start.clone();
        now.rotations.iter_mut().for_each(|rotation| *rotation += 1e-3);
        now.positions.iter_mut().for_each(|x| x.y += 1e-6);
        now.ids.remove(1);
        now.positions.remove(1);
        now.rotations.remove(1);
        for (field, exact) in [(Field::Rotation, 1e-3), (Field::Displacement, 1e-6)] {
            let (_, values) = colouring(&now, &start, field);
            assert_eq!(values.len(), 5);
            assert!(values.iter().all(|v| (v - exact).abs() < 1e-12), "{values:?}");
        }
    }

    #[test]
    fn a_full_size_specimen_stays_small_and_its_bytes_are_fixed() {
        let (now, start) = (grid(41, 180), Snapshot::default());
        let draw = |cracks| {
            let svg = svg(&now, &start, Field::Rotation, "a < b", "caption", cracks);
            svg.unwrap_or_default()
        };
        let picture = draw(true);
        assert!(picture.len() < 1_000_000, "{} bytes", picture.len());
        assert_eq!(picture.matches("<circle").count(), 7380);
        assert!(picture.contains("a &lt; b"));
        assert!(picture.contains("3689 broken in tension"), "one mode in two");
        assert!(picture.contains("3690 broken in shear"));
        assert_eq!(picture, draw(true));
        assert!(!draw(false).contains("broken"));
    }

    #[test]
    fn nothing_is_drawn_without_disks() {
        let nothing = Snapshot::default();
        assert_eq!(svg(&nothing, &nothing, Field::Rotation, "", "", true), None);
    }
}
