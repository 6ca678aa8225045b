//! A periodic cell: the specimen repeats along two vectors, and no wall holds it.

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// A periodic cell with the vectors `(width, 0)` and `(tilt, height)`.
///
/// Particles are never put back into the cell: a contact is between a particle and the nearest
/// image of another, which is the only one within reach (a cell is at least twice as wide and as
/// high as a contact is long). The positions of the two disks give the shift of that image, so that
/// it is not stored.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct PeriodicCell {
    /// Length of the vector along x, m.
    pub width: f64,
    /// Distance between rows of images, along y, m.
    pub height: f64,
    /// Component along x of the second vector, m.
    pub tilt: f64,
    /// Shear strain since the start of the run: the sum of all increments of `du_x/dy`.
    pub shear: f64,
    /// Stress in the last increment, Pa: sigma_xx, sigma_yy, and the traction along x on a face
    /// whose outward normal is y.
    pub stress: [f64; 3],
    /// Controls of the width, the height and the shear.
    pub controls: [CellControl; 3],
    /// Whether the first two controls are those of the mean of xx and yy and of their difference yy
    /// - xx, instead of those of xx and yy.
    pub by_mean: bool,
}

/// Control of one component of the deformation of a cell during a stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum CellControl {
    /// Change of the width, change of the height, or displacement along x of the top relative to
    /// the bottom, in every increment, m. With [`by_mean`](PeriodicCell::by_mean): change of the
    /// mean or of the difference yy - xx of the strains, lengthening positive, times
    /// [`PeriodicCell::length`].
    Imposed(f64),
    /// Average stress, Pa, linear over the stage: sigma_xx, sigma_yy (compression positive), their
    /// mean or difference, or the traction along x on a face whose outward normal is y.
    Stress {
        /// Value at the start of the stage, Pa.
        from: f64,
        /// Value at the end of the stage, Pa.
        to: f64,
    },
}

impl Default for CellControl {
    fn default() -> Self {
        Self::Imposed(0.0)
    }
}

impl PeriodicCell {
    /// Area, m^2.
    pub fn area(&self) -> f64 {
        self.width * self.height
    }

    /// Length that converts strains of the cell into displacements: the square root of the area, m.
    pub fn length(&self) -> f64 {
        self.area().sqrt()
    }

    /// Maximum distance of two particles in contact, m: half the smaller side of the cell. Beyond it
    /// a particle could touch two images of another.
    pub fn max_branch(&self) -> f64 {
        0.5 * self.width.min(self.height)
    }

    /// Shift of the image of b that is nearest to a, m. `apart` is the vector from a to b, m.
    pub fn shift(&self, apart: DVec2) -> DVec2 {
        shift([self.width, self.height, self.tilt], apart)
    }

    /// Position within the cell that is equivalent to `place`, m.
    pub fn wrapped(&self, place: DVec2) -> DVec2 {
        let rows = (place.y / self.height).floor();
        let x = place.x - rows * self.tilt;
        DVec2::new(x - (x / self.width).floor() * self.width, place.y - rows * self.height)
    }

    /// Axis of the first degree of freedom of the [body](clastic_cone::program::ProgramCell) of the
    /// program that represents the cell. With `by_mean` it is the diagonal, along which width and
    /// height strain alike.
    pub fn axis(&self) -> DVec2 {
        if self.by_mean { DVec2::splat(0.5_f64.sqrt()) } else { DVec2::X }
    }

    /// Displacement of that body along each of its axes per imposed motion of a [`CellControl`].
    pub fn factors(&self, arm: f64) -> [f64; 3] {
        let length = self.length();
        let shear = length / (self.height * arm);
        if self.by_mean {
            // Along (1, 1)/sqrt(2) and (-1, 1)/sqrt(2).
            return [2.0_f64.sqrt(), 0.5_f64.sqrt(), shear];
        }
        [length / self.width, length / self.height, shear]
    }

    /// Loads of that body along x and y by unit of stress, N/Pa, N/Pa and N m/Pa. Compression is
    /// positive for sigma_xx and sigma_yy, and shortens; the traction along x on the top moves it
    /// along x.
    pub fn loads(&self, arm: f64, thickness: f64) -> [f64; 3] {
        let by_length = self.area() * thickness / self.length();
        [-by_length, -by_length, by_length * arm]
    }

    /// Loads of that body along its axes per unit of the controlled stresses.
    pub fn loads_of_controls(&self, arm: f64, thickness: f64) -> [f64; 3] {
        let loads = self.loads(arm, thickness);
        if self.by_mean {
            // (xx + yy)/sqrt(2) of the mean, (yy - xx)/sqrt(2) of the difference.
            return [loads[0] * 2.0_f64.sqrt(), loads[1] * 0.5_f64.sqrt(), loads[2]];
        }
        loads
    }

    /// Stress of the last increment of the components that are controlled, Pa.
    pub fn controlled_stress(&self, by_mean: bool) -> [f64; 3] {
        let [xx, yy, shear] = self.stress;
        if by_mean { [0.5 * (xx + yy), yy - xx, shear] } else { self.stress }
    }

    /// The cell after a displacement (m, m, rad) of the body that stands for it.
    pub fn deformed(&self, u: [f64; 3], arm: f64) -> Self {
        let length = self.length();
        let (xx, yy, xy) = (u[0] / length, u[1] / length, arm * u[2] / length);
        Self {
            width: self.width + xx * self.width,
            height: self.height + yy * self.height,
            tilt: self.tilt + xx * self.tilt + xy * self.height,
            shear: self.shear + xy,
            ..*self
        }
    }

    /// Maximum displacement of a side that is imposed in an increment, m.
    pub fn imposed(&self) -> f64 {
        let imposed = self.controls.iter().map(|control| match control {
            CellControl::Imposed(u) => u.abs(),
            CellControl::Stress { .. } => 0.0,
        });
        imposed.fold(0.0, f64::max)
    }
}

/// Shift of the image of b that is nearest to a in a cell of this width, height and tilt (m).
/// `apart` is the vector from a to b, m.
pub fn shift([width, height, tilt]: [f64; 3], apart: DVec2) -> DVec2 {
    let rows = (apart.y / height).round();
    let x = apart.x - rows * tilt;
    let columns = (x / width).round();
    // An image that is not shifted has a shift of exactly 0, without round-off.
    if rows == 0.0 && columns == 0.0 {
        return DVec2::ZERO;
    }
    -DVec2::new(columns * width + rows * tilt, rows * height)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of all images within two cells the shifted one is the nearest, wherever it is within reach,
    /// in cells of any tilt.
    #[test]
    fn the_shifted_image_is_the_nearest() {
        for tilt in [0.0, 0.3, -1.7, 5.2] {
            let cell = PeriodicCell {
                width: 1.0,
                height: 0.8,
                tilt,
                shear: 0.0,
                stress: [0.0; 3],
                controls: [CellControl::default(); 3],
                by_mean: false,
            };
            for k in 0..400 {
                let angle = f64::from(k);
                let short = 0.0099 * f64::from(k % 40) * DVec2::from_angle(angle);
                let (n, m) = (f64::from(k % 5) - 2.0, f64::from(k % 7) - 3.0);
                let lattice = DVec2::new(n * cell.width + m * cell.tilt, m * cell.height);
                let apart = short + lattice;
                assert!((apart + cell.shift(apart) - short).length() < 1e-12, "{tilt} {k}");
                let between = cell.wrapped(apart) - cell.wrapped(short);
                assert!((between + cell.shift(between)).length() < 1e-9);
            }
        }
    }
}
