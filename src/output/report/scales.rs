//! Scales of a run: of its numbers in a page, of colours and widths, and of the picture. They are
//! those of all frames, so that nothing jumps from one to the next. A stray grain or a few large
//! values do not decide about them.

use glam::DVec2;
use serde_json::{Value, json};

use super::columns::{most_steps, scale};
use crate::frames::Frame;
use crate::output::view::{near, range};

/// Part of values that lie beyond a colour scale.
const BEYOND: f64 = 0.01;

/// Minimum number of steps of a displacement in the range of its colours.
const FINE: f32 = 2000.0;

/// Minimum of a typical magnitude, as a part of the largest number, so that all numbers fit.
const SPREAD: f32 = 1.0 / 1_048_576.0;

/// Mean stress in the plane, of xx, yy and xy.
pub fn mean([xx, yy, _]: [f32; 3]) -> f32 {
    0.5 * (xx + yy)
}

/// Maximum shear stress in the plane.
pub fn shear([xx, yy, xy]: [f32; 3]) -> f32 {
    (0.5 * (xx - yy)).hypot(xy)
}

/// Typical magnitudes of a run, for `float16`, and quantiles, for colours and widths. A typical
/// magnitude is the quantile that ends the colours, but not below [`SPREAD`] of the largest one.
#[derive(Default)]
pub struct Scales {
    displacement: f32,
    /// Number of bytes of a displacement.
    pub width: usize,
    /// Typical rotation, rad.
    pub rotation: f32,
    /// Typical mean or shear stress, Pa.
    pub stress: f32,
    /// Typical velocity, m/s; 0 in static analysis.
    pub velocity: f32,
    /// Typical normal force, N. Shear forces have its steps.
    pub force: f32,
    /// Typical normal force times the mean radius, N m; 0 without moments.
    pub moment: f32,
    /// Ranges of colours by name.
    ranges: Value,
}

impl Scales {
    /// Scales of frames. Ranges of colours are those of the frames from `start` on.
    pub fn of(frames: &[Frame], start: usize) -> Self {
        let mut scales = Self::default();
        let mut seen: [Vec<f32>; 6] = Default::default();
        let mut before: Option<&Frame> = None;
        for (k, frame) in frames.iter().enumerate() {
            scales.see(frame);
            if k >= start {
                see_values(&mut seen, frame, before);
                before = Some(frame);
            }
        }
        let mut at = |k: usize, part: f64| quantile(&mut seen[k], part);
        let (low, high) = (BEYOND, 1.0 - BEYOND);
        let (turn, moved) = (at(3, high), at(0, high));
        let (speed, force, stress) = (at(2, high), at(5, high), [at(4, low), at(4, high)]);
        scales.ranges = json!({
            "displacement": [0.0, moved],
            "motion": [0.0, at(1, high)],
            "velocity": [0.0, speed],
            "rotation": [-turn, turn],
            "stress": stress,
            "force": [0.0, force],
        });
        let typical = |all: &mut f32, quantile: f32| *all = quantile.max(SPREAD * *all);
        typical(&mut scales.rotation, turn);
        typical(&mut scales.stress, stress[0].abs().max(stress[1]));
        if scales.velocity > 0.0 {
            typical(&mut scales.velocity, speed);
        }
        typical(&mut scales.force, force);
        if scales.moment > 0.0 {
            typical(&mut scales.moment, scales.force * mean_radius(frames));
        }
        // Two bytes, if the step is then a small part of the range of colours.
        let is_fine = moved * most_steps(2) as f32 >= FINE * scales.displacement;
        scales.width = if is_fine { 2 } else { 3 };
        scales
    }

    /// Largest magnitudes with those of a frame.
    fn see(&mut self, frame: &Frame) {
        let most = |all: &mut f32, x: f32| *all = all.max(x.abs());
        let (bodies, pairs) = (&frame.bodies, &frame.pairs);
        bodies.displacement_m.iter().flatten().for_each(|x| most(&mut self.displacement, *x));
        bodies.velocity_m_s.iter().for_each(|[x, y]| most(&mut self.velocity, x.hypot(*y)));
        bodies.rotation_rad.iter().for_each(|x| most(&mut self.rotation, *x));
        for stress in &bodies.stress_pa {
            most(&mut self.stress, mean(*stress));
            most(&mut self.stress, shear(*stress));
        }
        pairs.p_n.iter().chain(&pairs.q_n).for_each(|x| most(&mut self.force, *x));
        pairs.tau_nm.iter().for_each(|x| most(&mut self.moment, *x));
    }

    /// Step of displacements, m.
    pub fn step(&self) -> f64 {
        let largest = if self.displacement > 0.0 { self.displacement } else { 1.0 };
        f64::from(largest) / f64::from(most_steps(self.width))
    }

    /// The scales as the page reads them.
    pub fn json(&self) -> Value {
        json!({
            "step": self.step(),
            "width": self.width,
            "rotation": scale(self.rotation),
            "stress": scale(self.stress),
            "velocity": if self.velocity > 0.0 { Some(scale(self.velocity)) } else { None },
            "force": scale(self.force),
            "moment": if self.moment > 0.0 { Some(scale(self.moment)) } else { None },
            "ranges": self.ranges,
        })
    }
}

/// Values of a frame for colours and widths: displacement, motion since the frame before, velocity,
/// rotation, mean stress, normal force.
fn see_values(seen: &mut [Vec<f32>; 6], frame: &Frame, before: Option<&Frame>) {
    let bodies = &frame.bodies;
    for (row, u) in bodies.displacement_m.iter().enumerate() {
        seen[0].push(u[0].hypot(u[1]));
        let then = before.filter(|then| then.bodies.id.get(row) == bodies.id.get(row));
        if let Some([x, y]) = then.map(|then| then.bodies.displacement_m[row]) {
            seen[1].push((u[0] - x).hypot(u[1] - y));
        }
    }
    seen[2].extend(bodies.velocity_m_s.iter().map(|[x, y]| x.hypot(*y)));
    seen[3].extend(bodies.rotation_rad.iter().map(|x| x.abs()));
    seen[4].extend(bodies.stress_pa.iter().map(|stress| mean(*stress)));
    let forces = frame.pairs.p_n.iter().filter(|p| **p != 0.0);
    seen[5].extend(forces.map(|p| p.abs()));
}

/// Mean radius of all disks, m; 0 without any.
fn mean_radius(frames: &[Frame]) -> f32 {
    let radii = frames.iter().flat_map(|frame| &frame.bodies.radius_m);
    let (sum, number) = radii.fold((0.0, 0_usize), |(sum, n), r| (sum + f64::from(*r), n + 1));
    (sum / number.max(1) as f64) as f32
}

/// Value that the given part of all values does not exceed; 0 without any.
fn quantile(values: &mut [f32], part: f64) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let at = (part * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(at, f32::total_cmp).1
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
