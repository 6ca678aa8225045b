//! A curve as an image.

use bevy::asset::RenderAssetUsages;
use bevy::image::Image;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

/// Width and height, pixels.
pub(super) const SIZE: [u32; 2] = [328, 190];
/// Room around the curve, pixels.
const MARGIN: f64 = 6.0;
const PAPER: [f64; 3] = [255.0, 255.0, 255.0];
const GRID: [f64; 3] = [226.0, 230.0, 234.0];
const ZERO: [f64; 3] = [150.0, 156.0, 162.0];
const LINE: [f64; 3] = [20.0, 64.0, 122.0];
const NOW: [f64; 3] = [215.0, 25.0, 28.0];
/// Maximum number of points that are drawn.
const POINTS: usize = 2000;

/// What is drawn: the points, the ends of the axes, and the steps of the grid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chart {
    pub points: Vec<[f64; 2]>,
    pub low: [f64; 2],
    pub high: [f64; 2],
    pub grid: [f64; 2],
}

impl Chart {
    /// The chart of some points; `None` without any. The ordinate has 0.
    pub(super) fn of(points: Vec<[f64; 2]>) -> Option<Self> {
        let first = *points.first()?;
        let (mut low, mut high) = (first, first);
        for point in &points {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        (low[1], high[1]) = (low[1].min(0.0), high[1].max(0.0));
        for axis in 0..2 {
            if high[axis] <= low[axis] {
                high[axis] = low[axis] + 1.0;
            }
        }
        let grid = [0, 1].map(|axis| step(high[axis] - low[axis]));
        Some(Self { points, low, high, grid })
    }

    fn place(&self, point: [f64; 2]) -> [f64; 2] {
        let part = [0, 1].map(|k| (point[k] - self.low[k]) / (self.high[k] - self.low[k]));
        let room = SIZE.map(|size| f64::from(size) - 2.0 * MARGIN);
        [MARGIN + part[0] * room[0], MARGIN + (1.0 - part[1]) * room[1]]
    }

    /// The pixels, RGBA.
    pub(super) fn pixels(&self) -> Vec<u8> {
        let mut canvas = Canvas::new();
        for axis in 0..2 {
            let (step, first) = (self.grid[axis], (self.low[axis] / self.grid[axis]).ceil());
            for k in 0..40 {
                let value = (first + f64::from(k)) * step;
                if value > self.high[axis] {
                    break;
                }
                let colour = if value.abs() < 1e-9 * step { ZERO } else { GRID };
                let (mut a, mut b) = (self.low, self.high);
                (a[axis], b[axis]) = (value, value);
                canvas.line(self.place(a), self.place(b), 0.5, colour);
            }
        }
        let every = self.points.len() / POINTS + 1;
        let shown: Vec<_> =
            self.points.iter().rev().step_by(every).map(|p| self.place(*p)).collect();
        for ends in shown.windows(2) {
            canvas.line(ends[0], ends[1], 0.9, LINE);
        }
        if let Some(now) = shown.first() {
            canvas.line(*now, *now, 3.2, NOW);
        }
        canvas.0
    }
}

/// A step of few digits, of which a range has three to seven.
fn step(range: f64) -> f64 {
    let size = 10.0_f64.powf((range / 3.0).log10().floor());
    let part = range / 3.0 / size;
    size * if part < 2.0 {
        1.0
    } else if part < 5.0 {
        2.0
    } else {
        5.0
    }
}

struct Canvas(Vec<u8>);

impl Canvas {
    fn new() -> Self {
        let [r, g, b] = PAPER.map(|c| c as u8);
        Self([r, g, b, 255].repeat((SIZE[0] * SIZE[1]) as usize))
    }

    /// A line with round ends and smooth edges.
    fn line(&mut self, a: [f64; 2], b: [f64; 2], half: f64, colour: [f64; 3]) {
        let ends = [0, 1].map(|k| {
            let (low, high) = (a[k].min(b[k]) - half - 1.0, a[k].max(b[k]) + half + 1.0);
            (low.max(0.0) as u32, (high.max(0.0) as u32).min(SIZE[k] - 1))
        });
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = along[0].powi(2) + along[1].powi(2);
        for y in ends[1].0..=ends[1].1 {
            for x in ends[0].0..=ends[0].1 {
                let from = [f64::from(x) + 0.5 - a[0], f64::from(y) + 0.5 - a[1]];
                let part = (from[0] * along[0] + from[1] * along[1]) / length;
                let part = if length > 0.0 { part.clamp(0.0, 1.0) } else { 0.0 };
                let apart = (from[0] - part * along[0]).hypot(from[1] - part * along[1]);
                let cover = (half + 0.5 - apart).clamp(0.0, 1.0);
                let at = 4 * (y * SIZE[0] + x) as usize;
                for (old, new) in self.0[at..at + 3].iter_mut().zip(colour) {
                    *old = (f64::from(*old) + cover * (new - f64::from(*old))).round() as u8;
                }
            }
        }
    }
}

/// An empty image.
pub(super) fn blank() -> Image {
    Image::new(
        Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        TextureDimension::D2,
        Canvas::new().0,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_goes_from_corner_to_corner() {
        let chart = Chart::of(vec![[0.0, 0.0], [3.0, 600.0]]).unwrap();
        assert_eq!(chart.grid, [1.0, 200.0]);
        let pixels = chart.pixels();
        let is_line = |x: f64, y: f64| {
            let at = 4 * (y as u32 * SIZE[0] + x as u32) as usize;
            pixels[at] < 120 && pixels[at + 2] > 100
        };
        for part in [0.25, 0.5, 0.75] {
            let [x, y] = chart.place([3.0 * part, 600.0 * part]);
            assert!(is_line(x, y));
            assert!(!is_line(x, y + 20.0));
        }
    }

    #[test]
    fn one_point_and_a_constant_have_a_chart() {
        let chart = Chart::of(vec![[2.0, 0.0]; 3]).unwrap();
        assert_eq!((chart.low, chart.high), ([2.0, 0.0], [3.0, 1.0]));
        assert_eq!(Chart::of(Vec::new()), None);
    }
}
