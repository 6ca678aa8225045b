//! Lines over the disks: bonds, forces, broken bonds, walls, membranes, the periodic cell, and what
//! is marked.

use bevy::color::LinearRgba;
use clastic::components::bond::RuptureMode;
use clastic::frames::Frame;
use glam::DVec2;

use super::Look;
use super::colours::{Legend, Sample, colour};
use super::scale::{Scale, with_unit};
use super::strokes::Quads;
use crate::picture::Picture;

const COMPRESSION: &str = "#14407a";
const TENSION: &str = "#d7191c";
const BOND: &str = "#3f6f9f";
const WALL: &str = "#3c3c3c";
/// A wall beyond its drawn ends, where it bounds the grains too.
const BEYOND: &str = "#cfd4d8";
const MEMBRANE: &str = "#7b3294";
const CELL: &str = "#5c6b78";
const MARK: &str = "#00c060";
/// Minimum widths, pixels.
const THIN: f64 = 1.2;
const STRONG: f64 = 2.5;

/// Adds the lines that are shown, and their legends. `pixel` is the size of a pixel, m.
pub(super) fn draw(
    quads: &mut Quads,
    picture: &Picture,
    look: &Look,
    pixel: f32,
    legends: &mut Vec<Legend>,
) {
    let frame = &picture.frame;
    let pixel = f64::from(pixel);
    let radii = &frame.bodies.radius_m;
    let mean = radii.iter().map(|r| f64::from(*r)).sum::<f64>() / radii.len().max(1) as f64;
    if look.bonds {
        let number = bonds(quads, frame, (0.15 * mean).max(THIN * pixel));
        let samples = vec![Sample { colour: BOND, text: format!("{number} intact bonds") }];
        legends.push(Legend { samples, ..Legend::default() });
    }
    if look.forces {
        legends.push(forces(quads, frame, mean, pixel));
    }
    if look.cracks {
        let samples = cracks(quads, frame, (0.27 * mean).max(THIN * pixel));
        if !samples.is_empty() {
            legends.push(Legend { samples, ..Legend::default() });
        }
    }
    if look.walls {
        beyond(quads, frame, THIN * pixel);
        boundaries(quads, frame, (0.2 * mean).max(STRONG * pixel));
    }
    marks(quads, frame, look, (0.12 * mean).max(STRONG * pixel));
}

/// From the first body of a pair to the second: the centres of disks, or the foot on a wall, m.
fn ends(frame: &Frame, pair: usize) -> Option<[DVec2; 2]> {
    let pairs = &frame.pairs;
    let a = frame.row(pairs.a[pair])?;
    let b = frame.row(pairs.b[pair]).map_or(0.0, |row| frame.bodies.radius_m[row]);
    let length = frame.bodies.radius_m[a] + pairs.gap_m[pair] + b;
    let from = DVec2::from(frame.centre(a));
    let along = DVec2::from_angle(f64::from(pairs.angle_rad[pair]));
    Some([from, from + f64::from(length) * along])
}

fn bonds(quads: &mut Quads, frame: &Frame, width: f64) -> usize {
    let intact: Vec<_> = (0..frame.pairs.a.len()).filter(|k| frame.pairs.state[*k] == 1).collect();
    for ends in intact.iter().filter_map(|k| ends(frame, *k)) {
        quads.line(ends, width, colour(BOND));
    }
    intact.len()
}

/// The end of the scale of forces has the width of the mean radius. Lines of few hundredths of it
/// are not drawn.
fn forces(quads: &mut Quads, frame: &Frame, mean: f64, pixel: f64) -> Legend {
    let forces: Vec<f64> = frame.pairs.p_n.iter().map(|p| f64::from(p.abs())).collect();
    let scale = Scale::of_magnitudes(&forces, "normal force", "N");
    let colours = [COMPRESSION, TENSION].map(colour);
    let mut tension = false;
    for (pair, force) in forces.iter().enumerate() {
        let share = (force / scale.high).min(1.0);
        if share < 0.03 {
            continue;
        }
        let is_tension = frame.pairs.p_n[pair] < 0.0;
        tension |= is_tension;
        if let Some(ends) = ends(frame, pair) {
            quads.line(ends, (share * mean).max(pixel), colours[usize::from(is_tension)]);
        }
    }
    let full = with_unit(scale.high, "N");
    let mut samples = vec![Sample {
        colour: COMPRESSION,
        text: format!("compression, mean radius wide: {full}"),
    }];
    if tension {
        samples.push(Sample { colour: TENSION, text: "tension".to_owned() });
    }
    Legend { name: "normal force, N, as width".into(), samples, ..Legend::default() }
}

/// Strokes across the contacts, as long as the bonds were wide.
fn cracks(quads: &mut Quads, frame: &Frame, width: f64) -> Vec<Sample> {
    let modes = [(2, RuptureMode::Tension), (3, RuptureMode::Shear), (4, RuptureMode::Rolling)];
    let mut samples = Vec::new();
    for (state, mode) in modes {
        let hex = color(mode);
        let (mut number, colour) = (0, colour(hex));
        for k in (0..frame.pairs.a.len()).filter(|k| frame.pairs.state[*k] == state) {
            number += 1;
            let Some(a) = frame.row(frame.pairs.a[k]) else { continue };
            let b = frame.row(frame.pairs.b[k]).unwrap_or(a);
            let half = frame.bodies.radius_m[a].min(frame.bodies.radius_m[b]);
            let across = DVec2::from_angle(f64::from(frame.pairs.angle_rad[k])).perp();
            let along = f64::from(half) * across;
            if let Some(middle) = frame.contact_point(k).map(DVec2::from) {
                quads.line([middle - along, middle + along], width, colour);
            }
        }
        if number > 0 {
            let text = format!("{number} bonds broken in {}", mode.name());
            samples.push(Sample { colour: hex, text });
        }
    }
    samples
}

/// Straight walls are lines without ends: they go on over ten times the length that is drawn.
fn beyond(quads: &mut Quads, frame: &Frame, width: f64) {
    for wall in (0..frame.walls.id.len()).filter(|wall| !frame.walls.is_thin[*wall]) {
        if let [a, b] = *frame.wall_line(wall) {
            let [a, b] = [DVec2::from(a), DVec2::from(b)];
            let far = 10.0 * (b - a);
            for ends in [[a - far, a], [b, b + far]] {
                quads.line(ends, width, colour(BEYOND));
            }
        }
    }
}

fn boundaries(quads: &mut Quads, frame: &Frame, width: f64) {
    for wall in 0..frame.walls.id.len() {
        // Material is on the left of a wall that is no plate: the line lies beyond its edge.
        let beyond = if frame.walls.is_thin[wall] { 0.0 } else { 0.5 * width };
        for ends in frame.wall_line(wall).windows(2) {
            let [a, b] = [DVec2::from(ends[0]), DVec2::from(ends[1])];
            let shift = -beyond * (b - a).normalize_or_zero().perp();
            quads.line([a + shift, b + shift], width, colour(WALL));
        }
    }
    let chains = &frame.membranes;
    for chain in 0..chains.name.len() {
        let points: Vec<DVec2> =
            chains.points(chain).map(|k| DVec2::from(chains.point_m[k])).collect();
        let closes = chains.is_closed[chain].then(|| points.first()).flatten();
        let all: Vec<DVec2> = points.iter().chain(closes).copied().collect();
        for ends in all.windows(2) {
            quads.line([ends[0], ends[1]], width, colour(MEMBRANE));
        }
    }
    if let Some([cell_width, height, tilt]) = frame.cell_m {
        let (x, y) = (DVec2::new(cell_width, 0.0), DVec2::new(tilt, height));
        for ends in [DVec2::ZERO, x, x + y, y, DVec2::ZERO].windows(2) {
            dashed(quads, [ends[0], ends[1]], 0.7 * width, colour(CELL));
        }
    }
}

fn dashed(quads: &mut Quads, [a, b]: [DVec2; 2], width: f64, colour: LinearRgba) {
    const DASHES: u32 = 24;
    let at = |part: f64| a.lerp(b, part / f64::from(DASHES));
    for k in 0..DASHES {
        quads.line([at(f64::from(k)), at(f64::from(k) + 0.6)], width, colour);
    }
}

fn marks(quads: &mut Quads, frame: &Frame, look: &Look, width: f64) {
    if let Some(row) = look.marked.and_then(|id| frame.row(id)) {
        let radius = f64::from(frame.bodies.radius_m[row]) + 0.5 * width;
        quads.circle(frame.centre(row).into(), radius, width, colour(MARK));
    }
    let Some([a, b]) = look.marked_pair else { return };
    let pairs = &frame.pairs;
    let rows = (0..pairs.a.len()).filter(|k| (pairs.a[*k], pairs.b[*k]) == (a, b));
    for ends in rows.filter_map(|k| ends(frame, k)) {
        quads.line(ends, width, colour(MARK));
    }
}

/// Colour of a broken bond, as in the figures of the Python package.
fn color(mode: RuptureMode) -> &'static str {
    match mode {
        RuptureMode::Tension => "#d7191c",
        RuptureMode::Shear => "#1a1a1a",
        RuptureMode::Rolling => "#d68a00",
    }
}
