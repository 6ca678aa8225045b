//! Principal values of a symmetric tensor in the plane.

use std::f64::consts::PI;

/// Principal values of the tensor with components xx, yy and xy, and the angle of the major
/// direction from the x axis, rad, from 0 to below pi.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Principal {
    /// Maximum.
    pub major: f64,
    /// Minimum.
    pub minor: f64,
    /// Direction; `None` where the two values are equal, but for round-off.
    pub direction: Option<f64>,
}

/// Relative difference of principal values that counts as round-off of sums over many contacts.
const ROUND_OFF: f64 = 1e-12;

impl Principal {
    /// Principal values of a tensor.
    pub fn of(xx: f64, yy: f64, xy: f64) -> Self {
        let mean = 0.5 * (xx + yy);
        let radius = (0.5 * (xx - yy)).hypot(xy);
        let size = xx.abs().max(yy.abs());
        let direction = (radius > ROUND_OFF * size).then(|| axis(xx - yy, 2.0 * xy));
        Self { major: mean + radius, minor: mean - radius, direction }
    }
}

/// Angle of an axis from cosine and sine of the doubled angle, up to a positive factor, rad, from 0
/// to below pi. The angle is continuous for axes that turn through the vertical (pi/2), and jumps
/// for axes that turn through the horizontal.
pub fn axis(cos: f64, sin: f64) -> f64 {
    let angle = 0.5 * sin.atan2(cos);
    let angle = if angle < 0.0 { angle + PI } else { angle + 0.0 };
    // An angle just below zero rounds to pi, which is the axis at 0.
    if angle < PI { angle } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    use super::*;

    #[test]
    fn a_turned_tensor_has_its_values_and_its_axis() {
        for k in 0..12 {
            let angle = f64::from(k) * PI / 12.0;
            let (s, c) = angle.sin_cos();
            let (xx, yy) = (5.0 * c * c + 2.0 * s * s, 5.0 * s * s + 2.0 * c * c);
            let of = Principal::of(xx, yy, 3.0 * s * c);
            assert!((of.major - 5.0).abs() < 1e-14 && (of.minor - 2.0).abs() < 1e-14, "{of:?}");
            assert!((of.direction.unwrap() - angle).abs() < 1e-14, "{angle}: {of:?}");
        }
        assert_eq!(Principal::of(1.0, 1.0, 0.0).direction, None);
        assert_eq!(Principal::of(1.0, 1.0, 0.5).direction, Some(FRAC_PI_4));
    }

    #[test]
    fn an_axis_that_turns_through_the_vertical_does_not_jump() {
        assert_eq!(axis(-1.0, 0.0), FRAC_PI_2);
        assert_eq!(axis(-1.0, -0.0), FRAC_PI_2);
        assert!((axis(-1.0, -1e-3) - axis(-1.0, 1e-3) - 1e-3).abs() < 1e-9);
    }

    #[test]
    fn the_horizontal_has_one_angle() {
        for sin in [0.0, -0.0, -1e-300] {
            assert_eq!(axis(1.0, sin).to_bits(), 0.0_f64.to_bits(), "{sin:?}");
        }
        assert!(axis(1.0, -1e-9) < PI);
    }
}
