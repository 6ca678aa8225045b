//! Motion of grains relative to the affine field that fits the motion of all grains best.

use glam::DVec2;

use clastic_components::body::BodyDrive;
use clastic_components::contact::BodyTable;
use clastic_cone::program::{ConeProgram, ConeSolution};

/// With fewer grains than this, the field is their mean motion instead of an affine field.
const FEW: usize = 6;

/// The grain with the maximum motion relative to the mean field, and this motion in its radii.
#[must_use]
pub fn furthest(
    bodies: &BodyTable,
    program: &ConeProgram,
    solution: &ConeSolution,
) -> Option<(usize, f64)> {
    far_motions(bodies, program, solution)
        .into_iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Motion of every grain relative to the mean field, in its radii.
fn far_motions(bodies: &BodyTable, program: &ConeProgram, solution: &ConeSolution) -> Vec<f64> {
    let n = bodies.particles;
    let motion = motions(n, program, solution);
    // With fewer than `FEW` grains the field is fitted to the free ones only, since driven grains
    // move as imposed.
    let imposes = |d: &BodyDrive| matches!(d, BodyDrive::Imposed(_));
    let driven = |i: usize| {
        bodies.drives[i][..2].iter().any(imposes)
            || bodies.group(i).is_some_and(|group| group.drives.iter().any(imposes))
    };
    let free: Vec<usize> = (0..n).filter(|i| !driven(*i)).collect();
    let of_free = |x: &[DVec2]| -> Vec<DVec2> { free.iter().map(|i| x[*i]).collect() };
    let field = if n < FEW {
        MeanField::fit(&of_free(&bodies.positions[..n]), &of_free(&motion))
    } else {
        MeanField::fit(&bodies.positions[..n], &motion)
    };
    let far = |i: usize| (motion[i] - field.at(bodies.positions[i])).length() / bodies.radii[i];
    (0..n).map(|i| if driven(i) { 0.0 } else { far(i) }).collect()
}

/// Displacements of the particles, m.
fn motions(particles: usize, program: &ConeProgram, solution: &ConeSolution) -> Vec<DVec2> {
    let bodies = program.bodies[..particles].iter().zip(&solution.displacements);
    bodies
        .map(|(body, u)| {
            let u = body.to_global(*u);
            DVec2::new(u[0], u[1])
        })
        .collect()
}

/// An affine displacement field `u(x) = u_0 + H (x - x_0)`.
pub(crate) struct MeanField {
    origin: DVec2,
    mean: DVec2,
    /// `du/dx`.
    pub(crate) along_x: DVec2,
    /// `du/dy`.
    pub(crate) along_y: DVec2,
}

impl MeanField {
    /// Fits by least squares over all bodies. For few or collinear bodies it takes the mean only.
    fn fit(x: &[DVec2], u: &[DVec2]) -> Self {
        let (mean, affine) = Self::fits(x, u);
        affine.filter(|_| x.len() >= FEW).unwrap_or(mean)
    }

    /// The affine field that fits best by least squares; `None` for less than three bodies, or
    /// collinear ones.
    pub(crate) fn affine(x: &[DVec2], u: &[DVec2]) -> Option<Self> {
        Self::fits(x, u).1
    }

    /// The mean motion, and the affine field if there is one.
    fn fits(x: &[DVec2], u: &[DVec2]) -> (Self, Option<Self>) {
        let n = x.len().max(1) as f64;
        let origin = x.iter().sum::<DVec2>() / n;
        let mean = u.iter().sum::<DVec2>() / n;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        let (mut ux, mut uy) = (DVec2::ZERO, DVec2::ZERO);
        for (x, u) in x.iter().zip(u) {
            let d = *x - origin;
            xx += d.x * d.x;
            xy += d.x * d.y;
            yy += d.y * d.y;
            ux += d.x * (*u - mean);
            uy += d.y * (*u - mean);
        }
        let det = xx * yy - xy * xy;
        let affine = (det > 1e-6 * (xx + yy) * (xx + yy)).then(|| Self {
            origin,
            mean,
            along_x: (yy * ux - xy * uy) / det,
            along_y: (xx * uy - xy * ux) / det,
        });
        (Self { origin, mean, along_x: DVec2::ZERO, along_y: DVec2::ZERO }, affine)
    }

    fn at(&self, x: DVec2) -> DVec2 {
        let d = x - self.origin;
        self.mean + d.x * self.along_x + d.y * self.along_y
    }
}
