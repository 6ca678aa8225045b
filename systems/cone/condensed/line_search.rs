//! The line search of the Newton iteration: a Newton iteration for one number, safeguarded by a
//! bracket.

use super::scaled::Scaled;
use super::settings::LineSearchSettings;
use super::spring::Elastic;

/// The length a at which the derivative of the energy along `du` vanishes, to a few per cent of the
/// derivative at a = 0.
///
/// The derivative at a is `du.(M (u + a du) - f) + sum de.s(e + a de)`; it rises with a, and is
/// piecewise linear. `gradient` is that of the energy at `u`.
pub fn line_search<S: Elastic<F>, const F: usize>(
    program: &Scaled,
    springs: &[S],
    settings: &LineSearchSettings,
    [u, du, gradient]: [&[[f64; 3]]; 3],
    e: &[[f64; F]],
    de: &[[f64; F]],
) -> f64 {
    let dot = |x: &[[f64; 3]], y: &[[f64; 3]]| -> f64 {
        x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| x * y).sum()
    };
    let slope = dot(gradient, du);
    let (mut linear, mut quadratic) = (0.0, 0.0);
    for i in 0..program.free.len() {
        for k in (0..3).filter(|k| program.free[i][*k]) {
            linear += (program.weight[i][k] * u[i][k] - program.right[i][k]) * du[i][k];
            quadratic += program.weight[i][k] * du[i][k] * du[i][k];
        }
    }
    let derivative = |a: f64| {
        let (mut value, mut curvature) = (linear + a * quadratic, quadratic);
        for ((spring, e), de) in springs.iter().zip(e).zip(de) {
            let at = std::array::from_fn(|f| e[f] + a * de[f]);
            let (power, change) = spring.respond(at).along(de);
            value += power;
            curvature += change;
        }
        (value, curvature)
    };
    let (mut low, mut high) = (0.0, f64::INFINITY);
    let mut a = 1.0;
    for _ in 0..settings.max_evaluations {
        let (value, curvature) = derivative(a);
        if value.abs() <= settings.max_slope * slope.abs() {
            break;
        }
        if value > 0.0 {
            high = a;
        } else {
            low = a;
        }
        let newton = a - value / curvature;
        a = if newton > low && newton < high {
            newton
        } else if high.is_finite() {
            0.5 * (low + high)
        } else {
            4.0 * a
        };
    }
    a
}

#[cfg(test)]
mod tests {
    use super::super::samples::{contact, held, loaded, posed};
    use super::super::spring::Spring;
    use super::*;
    use crate::program::ConeProgram;
    use glam::DVec2;

    /// A body with weight 1 at a contact of stiffness 10 moves down by `a du`: the derivative of
    /// the energy vanishes at a depth of 0.1, whatever the length of du.
    #[test]
    fn the_minimum_of_a_parabola() {
        let program = ConeProgram {
            bodies: vec![held(), loaded(0.0, -1.0)],
            interactions: vec![contact(0, 1, DVec2::Y, 0.1, 0.0)],
            ..ConeProgram::default()
        };
        let (scaled, _, place) = posed(&program);
        let springs = [Spring::new(&scaled.locals[0])];
        for length in [0.05, 0.1, 2.0] {
            let u = [[0.0; 3]; 2];
            let (mut du, mut gradient) = (u, u);
            du[place[1]][1] = -length;
            gradient[place[1]][1] = 1.0;
            let settings = LineSearchSettings::default();
            let along = [&u[..], &du[..], &gradient[..]];
            let a = line_search(&scaled, &springs, &settings, along, &[[0.0; 2]], &[[length, 0.0]]);
            assert!((a * length - 0.1).abs() <= 0.1 * settings.max_slope, "{a} times {length}");
        }
    }
}
