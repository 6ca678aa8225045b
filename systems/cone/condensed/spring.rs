//! The forces of an elastic interaction.
//!
//! The forces (p, q, tau) that belong to kinematics (e_n, e_t, e_r) are the projection of the elastic
//! trial `x_t = k_x (e_x - l_x)` onto the limits `|x| <= s_x + m_x p` of q and tau, and `p >= -f_t`,
//! in the metric of the compliances. Without a rolling moment it has a closed form ([`Spring`]). With
//! one ([`RollingSpring`]) each x is, for a given p, its trial clamped to its limit, so that p alone is
//! left:
//!
//! ```text
//! (p - p_t)/k_n = sum_x m_x (|x_t| - s_x - m_x p)_+ / k_x
//! ```
//!
//! The right side falls with p, and a limit is active below `(|x_t| - s_x)/m_x`: the limits are
//! active in the order of these numbers.

use super::scaled::Local;

/// An elastic interaction: stiffnesses and limits.
#[derive(Clone, Copy, Debug)]
pub struct Spring {
    /// Stiffness in normal and tangential direction, 1 over the compliance.
    stiffness: [f64; 2],
    /// Kinematics at which there is no force.
    linear: [f64; 2],
    friction: f64,
    cohesion: f64,
    /// Tensile strength; infinite where the limits of the shear force imply it.
    tension: f64,
    /// Whether there is a shear force.
    shears: bool,
}

/// Forces and their derivatives by the kinematics.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response<const F: usize> {
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
            tension: if l.has_tension { l.strengths[0] } else { f64::INFINITY },
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

/// The limit of q or of tau.
#[derive(Clone, Copy, Debug)]
struct Limit {
    /// Whether the force exists.
    exists: bool,
    strength: f64,
    slope: f64,
}

/// An elastic interaction with a rolling moment, or one without beside others that have one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RollingSpring {
    /// Stiffness of p, q and tau, 1 over the compliance.
    stiffness: [f64; 3],
    /// Kinematics at which there is no force.
    linear: [f64; 3],
    /// Limits of q and tau.
    limits: [Limit; 2],
    /// Minimum of p: minus the tensile strength, or the apex of a limit.
    lowest: f64,
}

impl Elastic<3> for RollingSpring {
    fn new(l: &Local) -> Self {
        let limits = [0, 1].map(|x| Limit {
            exists: l.has[x + 1],
            strength: l.strengths[x + 1],
            slope: l.slopes[x],
        });
        let lowest = l.lowest();
        Self { stiffness: l.compliance.map(|c| 1.0 / c), linear: l.linear, limits, lowest }
    }

    #[inline]
    fn respond(&self, e: [f64; 3]) -> Response<3> {
        let k = self.stiffness;
        let trial: [f64; 3] = std::array::from_fn(|f| (e[f] - self.linear[f]) * k[f]);
        let at = |x: usize, p: f64| self.limits[x].strength + self.limits[x].slope * p;
        let is_over = |x: usize, p: f64| self.limits[x].exists && trial[x + 1].abs() > at(x, p);
        let (mut above, mut below, mut p) = (trial[0] / k[0], 1.0 / k[0], trial[0]);
        let mut active = [false; 2];
        for _ in 0..2 {
            let reach =
                |x: usize| (trial[x + 1].abs() - self.limits[x].strength) / self.limits[x].slope;
            let next = match [0, 1].map(|x| !active[x] && is_over(x, p)) {
                [false, false] => break,
                [true, true] => usize::from(reach(1) > reach(0)),
                [first, _] => usize::from(!first),
            };
            let slope = self.limits[next].slope;
            active[next] = true;
            above += slope * (trial[next + 1].abs() - self.limits[next].strength) / k[next + 1];
            below += slope * slope / k[next + 1];
            p = above / below;
        }
        if p < self.lowest {
            return self.torn(&trial);
        }
        // Derivatives of p over 1/below: those of an active x are its slope times these.
        let mut slopes = [1.0, 0.0, 0.0];
        let mut out = Response { s: [p, 0.0, 0.0], d: [[0.0; 3]; 3] };
        for x in (0..2).filter(|x| self.limits[*x].exists) {
            let f = x + 1;
            if active[x] {
                let sign = 1.0_f64.copysign(trial[f]);
                out.s[f] = sign * at(x, p);
                slopes[f] = sign * self.limits[x].slope;
            } else {
                out.s[f] = trial[f];
                out.d[f][f] = k[f];
            }
        }
        for f in 0..3 {
            for g in 0..3 {
                out.d[f][g] += slopes[f] * slopes[g] / below;
            }
        }
        out
    }
}

impl RollingSpring {
    /// The response where p is at its minimum.
    fn torn(&self, trial: &[f64; 3]) -> Response<3> {
        let mut out = Response { s: [self.lowest, 0.0, 0.0], d: [[0.0; 3]; 3] };
        for (limit, f) in self.limits.iter().zip([1, 2]).filter(|(limit, _)| limit.exists) {
            let most = (limit.strength + limit.slope * self.lowest).max(0.0);
            out.s[f] = trial[f].clamp(-most, most);
            if trial[f].abs() < most {
                out.d[f][f] = self.stiffness[f];
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

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

    fn spring() -> impl Strategy<Value = RollingSpring> {
        let limit =
            (prop::bool::weighted(0.8), 0.0..1.0_f64, prop_oneof![Just(0.0), 0.05..1.0_f64]);
        let limit = limit.prop_map(|(exists, strength, slope)| match (exists, slope) {
            (false, _) => Limit { exists, strength: 0.0, slope: 0.0 },
            // A limit without slope is one of cohesion alone.
            (true, 0.0) => Limit { exists, strength: strength + 0.1, slope: 0.0 },
            (true, slope) => Limit { exists, strength, slope },
        });
        let input = (prop::array::uniform3(0.1..10.0_f64), [limit.clone(), limit], 0.0..1.0_f64);
        input.prop_map(|(stiffness, limits, tension)| {
            let apex = |l: &Limit| if l.slope > 0.0 { l.strength / l.slope } else { f64::INFINITY };
            let lowest = limits.iter().map(apex).fold(tension, f64::min);
            RollingSpring { stiffness, linear: [0.0; 3], limits, lowest: -lowest }
        })
    }

    fn kinematics() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(-3.0..3.0_f64)
    }

    /// Half of the distance from the trial in the metric of the compliances.
    fn distance(spring: &RollingSpring, e: &[f64; 3], s: &[f64; 3]) -> f64 {
        let of = |f: usize| 0.5 * (s[f] / spring.stiffness[f] - e[f]).powi(2) * spring.stiffness[f];
        (0..3).filter(|f| *f == 0 || spring.limits[f - 1].exists).map(of).sum()
    }

    fn largest(spring: &RollingSpring, x: usize, p: f64) -> f64 {
        let limit = &spring.limits[x];
        if limit.exists { (limit.strength + limit.slope * p).max(0.0) } else { 0.0 }
    }

    proptest! {
        /// Forces are within the limits, and no others within them are nearer to the trial.
        #[test]
        fn forces_are_the_nearest_within_the_limits(
            spring in spring(),
            e in kinematics(),
            others in prop::collection::vec(kinematics(), 30),
        ) {
            let Response { s, .. } = spring.respond(e);
            prop_assert!(s[0] >= spring.lowest - 1e-12);
            for x in 0..2 {
                prop_assert!(s[x + 1].abs() <= largest(&spring, x, s[0]) + 1e-12, "{s:?}");
            }
            let best = distance(&spring, &e, &s);
            for other in others {
                for scale in [1.0, 1e-2, 1e-4] {
                    let p = (s[0] + scale * other[0]).max(spring.lowest);
                    let x = |x: usize| {
                        let most = largest(&spring, x, p);
                        (s[x + 1] + scale * other[x + 1]).clamp(-most, most)
                    };
                    let near = [p, x(0), x(1)];
                    prop_assert!(distance(&spring, &e, &near) >= best - 1e-12, "{s:?} {near:?}");
                }
            }
        }

        /// Derivatives are symmetric, and those of the forces: over a step on which the forces are
        /// linear, their change is the derivative times the step.
        #[test]
        fn derivatives_with_rolling_are_those_of_the_forces(
            spring in spring(),
            e in kinematics(),
            step in kinematics(),
        ) {
            let at = |length: f64| spring.respond(std::array::from_fn(|f| e[f] + length * step[f]));
            let ends = [at(-1e-6), at(1e-6)];
            prop_assume!(ends[0].d == ends[1].d);
            let d = ends[0].d;
            for f in 0..3 {
                let slope: f64 = (0..3).map(|g| d[f][g] * step[g]).sum();
                let found = (ends[1].s[f] - ends[0].s[f]) / 2e-6;
                prop_assert!((slope - found).abs() < 1e-7, "{f}: {slope} {found}");
                prop_assert!((0..3).all(|g| d[f][g] == d[g][f]));
            }
        }
    }

    /// On both limits at once the slips open the contact together: with `a = 1/k_n + sum m^2/k_x`,
    /// `p = (e_n + sum m (|x_t| - s_x)/k_x)/a`.
    #[test]
    fn sliding_and_rolling_return_together() {
        let limit = |strength, slope| Limit { exists: true, strength, slope };
        let spring = RollingSpring {
            stiffness: [2.0, 1.0, 4.0],
            linear: [0.0; 3],
            limits: [limit(0.0, 0.5), limit(0.0, 0.25)],
            lowest: 0.0,
        };
        let Response { s, .. } = spring.respond([1.0, 3.0, -2.0]);
        let p = (1.0 + 0.5 * 3.0 + 0.25 * 8.0 / 4.0) / (0.5 + 0.25 + 0.0625 / 4.0);
        for (found, expected) in s.into_iter().zip([p, 0.5 * p, -0.25 * p]) {
            assert!((found - expected).abs() < 1e-14, "{s:?}");
        }
        // Far apart no force is left.
        assert_eq!(spring.respond([-5.0, 0.1, 0.1]).s, [0.0; 3]);
    }
}
