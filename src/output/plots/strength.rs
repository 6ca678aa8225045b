//! Mohr circles and the linear envelope.

use std::f64::consts::PI;

use super::chart::{Chart, Line};
use crate::study::strength::{MohrCoulomb, Strength};

/// Segments of a half circle.
const SEGMENTS: u32 = 60;

/// Half circles of the stresses at the peak, in MPa, and the linear envelope if it exists. One
/// length on the two axes is one stress.
pub fn mohr(strengths: &[Strength], title: &str) -> Chart {
    let circle = |s: &Strength| {
        let (centre, radius) = (0.5e-6 * (s.peak + s.confining), 0.5e-6 * (s.peak - s.confining));
        let point = |k: u32| {
            let angle = PI * (1.0 - f64::from(k) / f64::from(SEGMENTS));
            (centre + radius * angle.cos(), radius.abs() * angle.sin())
        };
        Line {
            name: format!("{} MPa", megapascals(s.confining)),
            points: (0..=SEGMENTS).map(point).collect(),
        }
    };
    let mut lines: Vec<_> = strengths.iter().map(circle).collect();
    let mut caption = "compression positive".to_owned();
    if let Ok(fit) = MohrCoulomb::fit(strengths) {
        let slope = fit.friction_angle.to_radians().tan();
        let end = strengths.iter().map(|s| 0.5e-6 * (s.peak + s.confining)).fold(0.0, f64::max);
        let at = |sigma: f64| (sigma, 1e-6 * fit.cohesion + slope * sigma);
        let name =
            format!("c = {:.3} MPa, phi = {:.1} degrees", 1e-6 * fit.cohesion, fit.friction_angle);
        caption += &format!("; {name}");
        lines.push(Line { name, points: vec![at(0.0), at(end)] });
    }
    Chart {
        title: title.to_owned(),
        caption,
        x: "normal stress, MPa".to_owned(),
        y: "shear stress, MPa".to_owned(),
        lines,
        second: None,
        equal: true,
    }
}

/// A stress in MPa without digits of round-off.
pub fn megapascals(stress: f64) -> f64 {
    format!("{:.9e}", 1e-6 * stress).parse().unwrap_or(f64::NAN)
}
