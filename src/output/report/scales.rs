//! Scales of a run: steps of its numbers in a page, ranges of colours and widths, and the picture. They
//! are those of all frames, so that nothing jumps from one to the next. A stray grain or a few large
//! values do not decide about them.

use glam::DVec2;
use serde_json::{Value, json};

use super::columns::step;
use super::movie::Strains;
use crate::frames::Frame;
use crate::output::view::{near, range};

/// Part of values that lie beyond a colour scale.
const BEYOND: f64 = 0.01;

/// Largest step of numbers, as a part of their typical magnitude.
const STEP: f32 = 1.0 / 16_384.0;

/// The same of displacements, of which the page takes differences.
const FINE: f32 = 1.0 / 65_536.0;

/// Mean stress in the plane, of xx, yy and xy.
pub fn mean([xx, yy, _]: [f32; 3]) -> f32 {
    0.5 * (xx + yy)
}

/// Maximum shear stress in the plane.
pub fn shear([xx, yy, xy]: [f32; 3]) -> f32 {
    (0.5 * (xx - yy)).hypot(xy)
}

/// Steps of the numbers of a run, and ranges for colours and widths. The typical magnitude of
/// numbers is the one that ends their range.
pub struct Scales {
    pub displacement: f32,
    pub rotation: f32,
    pub stress: f32,
    pub velocity: f32,
    pub strain: f32,
    /// Of normal and shear forces.
    pub force: f32,
    /// That of forces times the mean radius.
    pub moment: f32,
    /// Ranges by name.
    pub ranges: Value,
}

impl Scales {
    /// Scales of frames with their [`Strains`] from the one with the index `start` on.
    pub fn of(frames: &[Frame], strains: &[Strains], start: usize) -> Self {
        let (low, high) = (BEYOND, 1.0 - BEYOND);
        let all = &frames[start.min(frames.len())..];
        let bodies = || all.iter().map(|frame| &frame.bodies);
        let length = |[x, y]: &[f32; 2]| x.hypot(*y);
        let moved = bodies().flat_map(|of| of.displacement_m.iter().map(length));
        let speeds = bodies().flat_map(|of| of.velocity_m_s.iter().map(length));
        let turns = bodies().flat_map(|of| of.rotation_rad.iter().map(|x| x.abs()));
        let forces = all.iter().flat_map(|frame| &frame.pairs.p_n);
        let [displacement] = quantiles(moved, [high]);
        let [motion] = quantiles(all.windows(2).flat_map(motions), [high]);
        let [velocity] = quantiles(speeds, [high]);
        let [rotation] = quantiles(turns, [high]);
        let stress =
            quantiles(bodies().flat_map(|of| of.stress_pa.iter().map(|s| mean(*s))), [low, high]);
        let [force] = quantiles(forces.filter(|p| **p != 0.0).map(|p| p.abs()), [high]);
        let strain = [0, 1].map(|since| {
            let known = strains.iter().skip(start + 1).flat_map(|of| &of[since]);
            quantiles(known.copied().filter(|x| !x.is_nan()), [high])[0]
        });
        let stresses = step(stress[0].abs().max(stress[1]), STEP);
        Self {
            displacement: step(displacement, FINE),
            rotation: step(rotation, STEP),
            stress: stresses,
            velocity: step(velocity, STEP),
            strain: step(strain[0].max(strain[1]), STEP),
            force: step(force, STEP),
            moment: step(force * mean_radius(frames), STEP),
            ranges: json!({
                "displacement": [0.0, displacement],
                "motion": [0.0, motion],
                "velocity": [0.0, velocity],
                "rotation": [-rotation, rotation],
                "strain": [0.0, strain[0]],
                "strainStep": [0.0, strain[1]],
                "stress": stress,
                "force": [0.0, force],
            }),
        }
    }
}

/// Motion from a frame to the next of the bodies in the same rows.
fn motions(pair: &[Frame]) -> impl Iterator<Item = f32> + '_ {
    let [then, now] = [&pair[0].bodies, &pair[1].bodies];
    let rows = (0..now.id.len()).filter(|row| then.id.get(*row) == Some(&now.id[*row]));
    rows.map(|row| {
        let ([x, y], [x0, y0]) = (now.displacement_m[row], then.displacement_m[row]);
        (x - x0).hypot(y - y0)
    })
}

/// Mean radius of all disks, m; 0 without any.
fn mean_radius(frames: &[Frame]) -> f32 {
    let radii = frames.iter().flat_map(|frame| &frame.bodies.radius_m);
    let (sum, number) = radii.fold((0.0, 0_usize), |(sum, n), r| (sum + f64::from(*r), n + 1));
    (sum / number.max(1) as f64) as f32
}

/// Values that these parts of all values do not exceed; 0 without any.
fn quantiles<const N: usize>(values: impl Iterator<Item = f32>, parts: [f64; N]) -> [f32; N] {
    let mut values: Vec<f32> = values.collect();
    parts.map(|part| {
        let Some(last) = values.len().checked_sub(1) else { return 0.0 };
        let at = (part * last as f64).round() as usize;
        *values.select_nth_unstable_by(at, f32::total_cmp).1
    })
}

/// The box that shows the specimen in these frames without its stray grains, and its walls up to a
/// quarter of it beyond: left, bottom, right, top from the origin, m.
pub fn view(frames: &[Frame], origin: [f64; 2]) -> [f64; 4] {
    let from = |x: [f64; 2]| DVec2::from(x) - DVec2::from(origin);
    let rows = frames.iter().flat_map(|frame| (0..frame.bodies.id.len()).map(move |k| (frame, k)));
    let disks = rows.map(|(frame, k)| (from(frame.centre(k)), f64::from(frame.bodies.radius_m[k])));
    let range = |axis: usize| {
        let ends = |sign: f64| disks.clone().map(|(x, r)| x[axis] + sign * r).collect();
        range(ends(-1.0), ends(1.0)).unwrap_or_default()
    };
    let ([left, right], [bottom, top]) = (range(0), range(1));
    let disks = (DVec2::new(left, bottom), DVec2::new(right, top));
    let walls = frames.iter().flat_map(|frame| (0..frame.walls.id.len()).map(move |k| (frame, k)));
    let ends = |thin: bool| -> Vec<[DVec2; 2]> {
        let walls = walls.clone().filter(|(frame, k)| frame.walls.is_thin[*k] == thin);
        let pieces = walls.flat_map(|(frame, k)| frame.wall_line(k).windows(2));
        pieces.map(|ends| [from(ends[0]), from(ends[1])]).collect()
    };
    let (lines, plates) = (ends(false), ends(true));
    let all = near(disks, &lines).chain(plates.iter().flatten().copied());
    let (low, high) = all.fold(disks, |(low, high), x| (low.min(x), high.max(x)));
    [low.x, low.y, high.x, high.y]
}
