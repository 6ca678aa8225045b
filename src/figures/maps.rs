//! Figures of the specimen to scale.

use glam::DVec2;

use super::fields::{displacements, rotations, strains};
use super::moment::{Disk, Moment};
use crate::output::plots::page::Style;
use crate::output::plots::scale::{KINDS, Scale, with_unit};
use crate::output::plots::sheet::{Sample, Sheet};
use crate::output::plots::specimen::{crack_samples, draw_cracks, draw_membranes, membrane_sample};
use crate::output::snapshot::Snapshot;

/// Colours of materials, pale so that cracks stand out.
const MATERIALS: [&str; 8] =
    ["#f3f1ec", "#9ecae1", "#fdcf9c", "#b5dfae", "#d4c5e8", "#e8dc96", "#c4c4c4", "#e3b8c4"];
const COMPRESSION: &str = "#14407a";
const TENSION: &str = "#d7191c";
/// Number of widths of lines in a picture of force chains.
const WIDTHS: usize = 12;
/// Number of coloured layers over the height of the specimen.
const LAYERS: f64 = 12.0;
/// Distance from the lower end of a layer, over its height, that is round-off of the numbers of a
/// frame: disks of one height are in one layer.
const ROUND_OFF: f64 = 1e-5;
const LAYER_COLORS: [&str; 2] = ["#a58cc0", "#c4c4c4"];

/// A moment on a page.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// The moment.
    pub now: &'a Moment,
    /// Moment from which fields count.
    pub from: &'a Moment,
    /// Size and letters.
    pub style: Style,
    /// Title, or nothing.
    pub title: &'a str,
    /// Corners of the visible rectangle, m; `None` shows all.
    pub window: Option<[[f64; 2]; 2]>,
    /// Whether broken bonds are drawn over fields.
    pub cracks: bool,
}

impl View<'_> {
    fn begin(&self, shown: &Snapshot) -> Option<Sheet> {
        let bounds = match self.window {
            Some([low, high]) => (DVec2::from(low), DVec2::from(high)),
            None => shown.bounds()?,
        };
        Some(Sheet::of_box(bounds, self.title, "", self.style))
    }

    /// The disks that a window shows, with their row.
    fn disks(
        &self,
        sheet: &mut Sheet,
        shown: &Snapshot,
        colors: &[&str],
        class: impl Fn(usize) -> usize,
    ) {
        let is_shown = |row: usize| {
            let Some([low, high]) = self.window else { return true };
            let (x, r) = (shown.positions[row], DVec2::splat(shown.radii[row]));
            (x + r).cmpge(low.into()).all() && (x - r).cmple(high.into()).all()
        };
        sheet.disks(shown, colors, |row| if is_shown(row) { class(row) } else { usize::MAX });
    }

    fn end(&self, mut sheet: Sheet, shown: &Snapshot, cracks: bool) -> String {
        let mut samples =
            if cracks { crack_samples(&shown.cracks, &self.style) } else { Vec::new() };
        samples.extend(membrane_sample(shown, &self.style));
        if cracks || !samples.is_empty() {
            sheet.samples(&samples);
        }
        sheet.end()
    }
}

/// Disks in the colours of a field.
fn field(view: &View, values: &[Option<f64>], scale: &Scale) -> Option<String> {
    let shown = view.now.snapshot();
    let mut sheet = view.begin(&shown)?;
    // Disks without a value have a colour of their own, after those of the scale.
    let colors: Vec<&str> = scale.colors.iter().copied().chain(["#fff"]).collect();
    let class = |row: usize| values[row].map_or(scale.colors.len(), |value| scale.class(value));
    view.disks(&mut sheet, &shown, &colors, class);
    if view.cracks {
        draw_cracks(&mut sheet, &shown);
    }
    sheet.walls(&shown);
    draw_membranes(&mut sheet, &shown);
    sheet.bar(scale);
    if values.iter().any(Option::is_none) {
        sheet.note("white: no value, since the disk or its neighbourhood was not there");
    }
    Some(view.end(sheet, &shown, view.cracks))
}

fn there(values: &[Option<f64>]) -> Vec<f64> {
    values.iter().flatten().copied().collect()
}

/// Magnitude of the displacement.
pub fn displacement(view: &View) -> Option<String> {
    let values: Vec<_> =
        displacements(view.now, view.from).into_iter().map(|u| u.map(DVec2::length)).collect();
    let scale = Scale::of_magnitudes(&there(&values), "magnitude of displacement", "m");
    field(view, &values, &scale)
}

/// Rotation with its sign.
pub fn rotation(view: &View) -> Option<String> {
    let values = rotations(view.now, view.from);
    let scale = Scale::of_signed(&there(&values), "rotation, anticlockwise positive", "rad");
    field(view, &values, &scale)
}

/// Maximum shear strain.
pub fn shear_strain(view: &View) -> Option<String> {
    let strains = strains(view.now, view.from);
    let values: Vec<_> = strains.into_iter().map(|s| Some(100.0 * s?.shear)).collect();
    let scale = Scale::of_magnitudes(&there(&values), "maximum shear strain", "%");
    field(view, &values, &scale)
}

/// Volumetric strain.
pub fn volumetric_strain(view: &View) -> Option<String> {
    let strains = strains(view.now, view.from);
    let values: Vec<_> = strains.into_iter().map(|s| Some(100.0 * s?.volumetric)).collect();
    let scale = Scale::of_signed(&there(&values), "volumetric strain, contraction positive", "%");
    field(view, &values, &scale)
}

/// Mean stress of every disk.
pub fn stress(view: &View) -> Option<String> {
    let mean = |disk: &Disk| Some(0.5 * (disk.stress[0] + disk.stress[1]));
    let values: Vec<_> = view.now.disks.iter().map(mean).collect();
    let name = "mean stress of each disk, compression positive";
    let all = there(&values);
    let [low, high] = [f64::min, f64::max].map(|of| all.iter().copied().fold(0.0, of));
    // Few disks are in tension where a specimen is pressed.
    let scale = match low < -0.02 * high {
        true => Scale::of_signed(&all, name, "Pa"),
        false => Scale::of_magnitudes(&all, name, "Pa"),
    };
    field(view, &values, &scale)
}

/// Disks in the colours of their materials, and broken bonds.
pub fn specimen(view: &View) -> Option<String> {
    let shown = view.now.snapshot();
    let mut sheet = view.begin(&shown)?;
    let material = |row: usize| view.now.disks[row].material as usize;
    view.disks(&mut sheet, &shown, &MATERIALS, |row| material(row) % MATERIALS.len());
    draw_cracks(&mut sheet, &shown);
    sheet.walls(&shown);
    draw_membranes(&mut sheet, &shown);
    let sample = |(k, name): (usize, &String)| {
        let number = (0..view.now.disks.len()).filter(|row| material(*row) == k).count();
        let color = MATERIALS[k % MATERIALS.len()];
        (number > 0).then(|| Sample {
            color,
            stroke: None,
            text: format!("{number} disks of {name}"),
        })
    };
    let names = &view.now.materials;
    let samples: Vec<_> = names.iter().enumerate().filter_map(sample).collect();
    // A single material needs no legend.
    if samples.len() > 1 {
        sheet.samples(&samples);
    }
    Some(view.end(sheet, &shown, true))
}

/// Intact bonds from centre to centre, and broken ones.
pub fn bonds(view: &View) -> Option<String> {
    let shown = view.now.snapshot();
    let mut sheet = view.begin(&shown)?;
    view.disks(&mut sheet, &shown, &["#fff"], |_| 0);
    let line = |a: u32, b: u32| Some([view.now.disk(a)?.position, view.now.far_end(a, b)?]);
    let intact = view.now.bonds.iter().filter(|bond| bond.broken.is_none());
    let lines: Vec<_> = intact.filter_map(|bond| line(bond.a, bond.b)).collect();
    let width = 0.08 * view.style.font;
    sheet.segments(&lines, COMPRESSION, width);
    draw_cracks(&mut sheet, &shown);
    sheet.walls(&shown);
    draw_membranes(&mut sheet, &shown);
    let mut samples = vec![Sample {
        color: COMPRESSION,
        stroke: Some(width),
        text: format!("{} intact bonds", lines.len()),
    }];
    samples.extend(crack_samples(&shown.cracks, &view.style));
    samples.extend(membrane_sample(&shown, &view.style));
    sheet.samples(&samples);
    Some(sheet.end())
}

/// Normal forces as lines from centre to centre, their width in proportion.
pub fn force_chains(view: &View) -> Option<String> {
    let shown = view.now.snapshot();
    let mut sheet = view.begin(&shown)?;
    view.disks(&mut sheet, &shown, &["#fff"], |_| 0);
    let forces: Vec<f64> = view.now.pairs.iter().map(|pair| pair.normal_force.abs()).collect();
    // The end of the scale has the width of the mean radius.
    let end = Scale::of_magnitudes(&forces, "normal force", "N");
    let mean = shown.radii.iter().sum::<f64>() / shown.radii.len().max(1) as f64;
    let widest = mean * sheet.scale;
    let mut lines = vec![Vec::new(); 2 * WIDTHS];
    for pair in &view.now.pairs {
        let share = pair.normal_force.abs() / end.high;
        let class = ((share * WIDTHS as f64).round() as usize).min(WIDTHS);
        let ends = view.now.disk(pair.a).zip(view.now.far_end(pair.a, pair.b));
        // Lines thinner than half of a class are not drawn.
        if let (Some((a, far)), 1..) = (ends, class) {
            let of_sign = if pair.normal_force < 0.0 { WIDTHS } else { 0 };
            lines[of_sign + class - 1].push([a.position, far]);
        }
    }
    let width = |class: usize| widest * (class + 1) as f64 / WIDTHS as f64;
    for (class, lines) in lines.iter().enumerate() {
        let color = if class < WIDTHS { COMPRESSION } else { TENSION };
        sheet.segments(lines, color, width(class % WIDTHS));
    }
    sheet.walls(&shown);
    draw_membranes(&mut sheet, &shown);
    // The sample is not wider than a line of the legend.
    let parts = (widest / (1.2 * view.style.font)).log2().ceil().max(0.0).exp2();
    let sample = |color, text: String| Sample { color, stroke: Some(widest / parts), text };
    let full = with_unit(end.high / parts, "N");
    let mut samples = vec![sample(COMPRESSION, format!("normal force of {full} in compression"))];
    if lines[WIDTHS..].iter().any(|lines| !lines.is_empty()) {
        samples.push(sample(TENSION, format!("of {full} in tension")));
    }
    samples.extend(membrane_sample(&shown, &view.style));
    sheet.samples(&samples);
    let more = if end.exceeded { "; larger forces are not wider" } else { "" };
    sheet.note(&format!("width in proportion to the force{more}"));
    Some(sheet.end())
}

/// Disks in layers of their height in the moment from which fields count.
pub fn layers(view: &View) -> Option<String> {
    let shown = view.now.snapshot();
    let mut sheet = view.begin(&shown)?;
    let (low, high) = view.from.snapshot().bounds()?;
    let layer = |row: usize| {
        let before = view.from.disk(view.now.disks[row].id)?.position.y;
        Some(((before - low.y) / (high.y - low.y) * LAYERS + ROUND_OFF) as usize % 2)
    };
    let colors = [LAYER_COLORS[0], LAYER_COLORS[1], "#fff"];
    view.disks(&mut sheet, &shown, &colors, |row| layer(row).unwrap_or(2));
    if view.cracks {
        draw_cracks(&mut sheet, &shown);
    }
    sheet.walls(&shown);
    draw_membranes(&mut sheet, &shown);
    Some(view.end(sheet, &shown, view.cracks))
}

/// Disks in the colours of their fragments.
pub fn fragments(view: &View) -> Option<String> {
    let shown = view.now.snapshot();
    let mut sheet = view.begin(&shown)?;
    let (fragments, sizes) = view.now.fragments();
    // The largest is grey, as the rest of the specimen; disks alone are white.
    let colors: Vec<&str> = ["#d9d9d9", "#fff"].into_iter().chain(KINDS).collect();
    let class = |row: usize| match fragments[row] {
        fragment if sizes[fragment] == 1 => 1,
        0 => 0,
        fragment => 2 + (fragment - 1) % KINDS.len(),
    };
    view.disks(&mut sheet, &shown, &colors, class);
    if view.cracks {
        draw_cracks(&mut sheet, &shown);
    }
    sheet.walls(&shown);
    draw_membranes(&mut sheet, &shown);
    let whole = sizes.iter().filter(|size| **size > 1).count();
    let alone = sizes.len() - whole;
    let largest = sizes.first().copied().unwrap_or(0);
    let share = 100.0 * largest as f64 / fragments.len().max(1) as f64;
    let sample = |color, text: String| Sample { color, stroke: None, text };
    let mut samples = Vec::new();
    if whole > 0 {
        samples
            .push(sample(colors[0], format!("largest fragment: {largest} disks ({share:.1} %)")));
    }
    if whole > 1 {
        samples.push(sample(KINDS[0], format!("{} more fragments (colours recur)", whole - 1)));
    }
    if alone > 0 {
        samples.push(sample("#fff", format!("{alone} disks without an intact bond")));
    }
    sheet.samples(&samples);
    Some(view.end(sheet, &shown, view.cracks))
}
