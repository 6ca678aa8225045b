//! The forces of an elastic interaction without a rolling moment;
//! [`rolling_spring`](super::rolling_spring) has those with one.
//!
//! The forces (p, q) that belong to kinematics (e_n, e_t) are the projection of the elastic trial
//! `p = k_n (e_n - l_n)`, `q = k_t (e_t - l_t)` onto the limits `|q| <= c + mu p`, `p >= -f_t`, in
//! the metric of the compliances.

use super::scaled::Local;

/// An elastic interaction: stiffnesses and limits.
#[derive(Clone, Copy, Debug)]
pub struct Spring {
    /// Stiffness in normal and tangential direction, 1 over the compliance.
    stiffness: [f64; 2],
    /// Kinematics at which there is no force.
    linear: [f64; 2],
    /// Coefficient of friction.
    friction: f64,
    /// Cohesion.
    cohesion: f64,
    /// Tensile strength; infinite where the limits of the shear force imply it.
    tension: f64,
    /// Whether there is a shear force.
    shears: bool,
}

/// Forces and their derivatives by the kinematics.
#[derive(Clone, Copy, Debug)]
pub struct Response<const F: usize> {
    /// Forces.
    pub s: [f64; F],
    /// Derivatives, a symmetric matrix.
    pub d: [[f64; F]; F],
}

impl<const F: usize> Default for Response<F> {
    fn default() -> Self {
        Self { s: [0.0; F], d: [[0.0; F]; F] }
    }
}

impl<const F: usize> Response<F> {
    /// Power of the forces along a step of the kinematics, and its derivative along the step.
    #[inline]
    pub fn along(&self, de: &[f64; F]) -> (f64, f64) {
        let (mut power, mut curvature) = (0.0, 0.0);
        for f in 0..F {
            power += self.s[f] * de[f];
            curvature += self.d[f][f] * de[f] * de[f];
            for g in f + 1..F {
                curvature += 2.0 * self.d[f][g] * de[f] * de[g];
            }
        }
        (power, curvature)
    }
}

/// An interaction whose `F` forces all have a compliance.
pub trait Elastic<const F: usize>: Copy + Send + Sync {
    /// The spring of such an interaction.
    fn new(l: &Local) -> Self;

    /// Projection of the elastic trial at these kinematics onto the limits.
    fn respond(&self, e: [f64; F]) -> Response<F>;
}

impl Elastic<2> for Spring {
    fn new(l: &Local) -> Self {
        Self {
            stiffness: [1.0 / l.compliance[0], 1.0 / l.compliance[1]],
            linear: [l.linear[0], l.linear[1]],
            friction: l.slopes[0],
            cohesion: l.strengths[1],
            tension: if l.has_tension() { l.strengths[0] } else { f64::INFINITY },
            shears: l.has[1],
        }
    }

    #[inline]
    fn respond(&self, e: [f64; 2]) -> Response<2> {
        let [kn, kt] = self.stiffness;
        let pt = (e[0] - self.linear[0]) * kn;
        let qt = (e[1] - self.linear[1]) * kt;
        let size = qt.abs();
        let over = size - self.cohesion - self.friction * pt;
        if self.shears && over <= 0.0 && pt >= -self.tension {
            return Response { s: [pt, qt], d: [[kn, 0.0], [0.0, kt]] };
        }
        self.limited(pt, qt)
    }
}

impl Spring {
    /// Projection of the trial (pt, qt), which may be outside of the limits.
    fn limited(&self, pt: f64, qt: f64) -> Response<2> {
        let [kn, kt] = self.stiffness;
        let (mu, cohesion, tension) = (self.friction, self.cohesion, self.tension);
        if !self.shears {
            return if pt > -tension {
                Response { s: [pt, 0.0], d: [[kn, 0.0], [0.0, 0.0]] }
            } else {
                Response { s: [-tension, 0.0], d: [[0.0; 2]; 2] }
            };
        }
        let sign = if qt < 0.0 { -1.0 } else { 1.0 };
        let size = qt.abs();
        // The corner of the limits: where tension cuts the shear cone, or the cone's own apex.
        let at_tension = cohesion - mu * tension;
        let (p0, q0) =
            if at_tension >= 0.0 { (-tension, at_tension) } else { (-cohesion / mu, 0.0) };
        let over = size - cohesion - mu * pt;
        if pt < p0 && (over <= 0.0 || size <= q0) {
            return if size <= q0 && q0 > 0.0 {
                Response { s: [p0, qt], d: [[0.0, 0.0], [0.0, kt]] }
            } else {
                Response { s: [p0, sign * q0.min(size)], d: [[0.0; 2]; 2] }
            };
        }
        if over <= 0.0 {
            return Response { s: [pt, qt], d: [[kn, 0.0], [0.0, kt]] };
        }
        let sum = kt + mu * mu * kn;
        let slip = over / sum;
        let p = pt + mu * kn * slip;
        if p >= p0 {
            let (vn, vt) = (-mu * kn, sign * kt);
            let across = -vn * vt / sum;
            let d = [[kn - vn * vn / sum, across], [across, kt - vt * vt / sum]];
            return Response { s: [p, sign * (size - kt * slip)], d };
        }
        Response { s: [p0, sign * q0], d: [[0.0; 2]; 2] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stiffnesses of 2 and 1, a coefficient of friction of 0.5, cohesion of 1, strength of 0.5.
    fn bond() -> Spring {
        Spring {
            stiffness: [2.0, 1.0],
            linear: [0.0, 0.0],
            friction: 0.5,
            cohesion: 1.0,
            tension: 0.5,
            shears: true,
        }
    }

    #[test]
    fn within_the_limits_the_forces_are_elastic() {
        let Response { s, d } = bond().respond([1.0, -0.5]);
        assert_eq!((s, d), ([2.0, -0.5], [[2.0, 0.0], [0.0, 1.0]]));
    }

    /// The return to the limit of shear, `q = c + mu p`, goes along the flow rule: the slip
    /// `(|q_t| - c - mu p_t)/(k_t + mu^2 k_n)` opens the contact by mu times as much.
    #[test]
    fn sliding_returns_to_the_limit_of_shear() {
        let Response { s, .. } = bond().respond([1.0, 3.5]);
        let slip = (3.5 - 1.0 - 0.5 * 2.0) / (1.0 + 0.25 * 2.0);
        assert_eq!(s, [2.0 + 0.5 * 2.0 * slip, 3.5 - slip]);
        assert!((s[1] - (1.0 + 0.5 * s[0])).abs() < 1e-15);
    }

    #[test]
    fn tension_and_shear_are_cut_off_at_the_corner() {
        // Torn apart, without shear: the strength is left.
        assert_eq!(bond().respond([-5.0, 0.25]).s, [-0.5, 0.25]);
        // Torn and sheared: the corner, where q = c - mu f_t.
        assert_eq!(bond().respond([-5.0, -4.0]).s, [-0.5, -0.75]);
        // The apex of a contact without strength: no force.
        let contact = Spring { cohesion: 0.0, tension: f64::INFINITY, ..bond() };
        assert_eq!(contact.respond([-1.0, 0.1]).s, [0.0, 0.0]);
    }

    /// Derivatives are those of the forces wherever these are smooth.
    #[test]
    fn derivatives_are_those_of_the_forces() {
        let frictionless = Spring { shears: false, ..bond() };
        let contact = Spring { cohesion: 0.0, tension: f64::INFINITY, ..bond() };
        for spring in [bond(), frictionless, contact] {
            for e in [[1.0, -0.5], [1.0, 3.5], [1.0, -3.5], [-5.0, 0.25], [-5.0, -4.0]] {
                let [[nn, nt], [_, tt]] = spring.respond(e).d;
                let h = 1e-6;
                let slope = |by: usize, f: usize| {
                    let at = |sign: f64| {
                        let mut e = e;
                        e[by] += sign * h;
                        spring.respond(e).s[f]
                    };
                    (at(1.0) - at(-1.0)) / (2.0 * h)
                };
                // The forces are piecewise linear: differences are exact up to round-off over h.
                for (derivative, slope) in
                    [(nn, slope(0, 0)), (nt, slope(1, 0)), (nt, slope(0, 1)), (tt, slope(1, 1))]
                {
                    assert!((derivative - slope).abs() < 1e-8, "{e:?}: {derivative} {slope}");
                }
            }
        }
    }
}
