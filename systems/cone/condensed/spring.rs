//! The forces of an elastic interaction.
//!
//! The forces (p, q, tau) that belong to kinematics (e_n, e_t, e_r) are the projection of the elastic
//! trial `x_t = k_x (e_x - l_x)` onto the limits `|x| <= s_x + m_x p` of q and tau, and `p >= -f_t`,
//! in the metric of the compliances. For a given p each x is its trial clamped to its limit, so that
//! p alone is left:
//!
//! ```text
//! (p - p_t)/k_n = sum_x m_x (|x_t| - s_x - m_x p)_+ / k_x
//! ```
//!
//! The right side falls with p, and a limit is active below `(|x_t| - s_x)/m_x`: the limits are
//! active in the order of these numbers.

use super::scaled::Local;

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

/// The limit of q or of tau.
#[derive(Clone, Copy, Debug)]
struct Limit {
    /// Whether the force exists.
    exists: bool,
    strength: f64,
    slope: f64,
}

const NONE: Limit = Limit { exists: false, strength: 0.0, slope: 0.0 };

/// An elastic interaction: p, q and, where any interaction of the program has one, tau.
#[derive(Clone, Copy, Debug)]
pub struct Spring<const F: usize> {
    /// Stiffnesses, 1 over the compliances.
    stiffness: [f64; F],
    /// Kinematics at which there is no force.
    linear: [f64; F],
    /// Limits by force; none of p.
    limits: [Limit; F],
    /// Minimum of p: minus the tensile strength, or the apex of a limit.
    lowest: f64,
}

impl<const F: usize> Spring<F> {
    /// The spring of an interaction whose forces all have a compliance.
    pub fn new(l: &Local) -> Self {
        let (mut limits, mut lowest) = ([NONE; F], f64::NEG_INFINITY);
        for (row, strength) in l.limits.iter().zip(l.right).take(l.count) {
            let slope = -row[0];
            for f in (1..F).filter(|f| row[*f] > 0.0) {
                limits[f] = Limit { exists: true, strength, slope };
            }
            if slope > 0.0 {
                lowest = lowest.max(-strength / slope);
            }
        }
        Self {
            stiffness: std::array::from_fn(|f| 1.0 / l.compliance[f]),
            linear: std::array::from_fn(|f| l.linear[f]),
            limits,
            lowest,
        }
    }

    /// Projection of the elastic trial at these kinematics onto the limits.
    #[inline]
    pub fn respond(&self, e: [f64; F]) -> Response<F> {
        let k = self.stiffness;
        let trial: [f64; F] = std::array::from_fn(|f| (e[f] - self.linear[f]) * k[f]);
        let mut out = Response { s: trial, d: [[0.0; F]; F] };
        let mut is_within = trial[0] >= self.lowest;
        out.d[0][0] = k[0];
        for f in 1..F {
            let Limit { exists, strength, slope } = self.limits[f];
            if exists {
                out.d[f][f] = k[f];
                is_within &= trial[f].abs() <= strength + slope * trial[0];
            } else {
                out.s[f] = 0.0;
            }
        }
        if is_within { out } else { self.limited(&trial) }
    }

    /// Projection of a trial that is outside of the limits.
    fn limited(&self, trial: &[f64; F]) -> Response<F> {
        let k = self.stiffness;
        let (mut above, mut below, mut p) = (trial[0] / k[0], 1.0 / k[0], trial[0]);
        let mut active = [false; F];
        // Each pass adds the first of the limits that the last p violates.
        for _ in 1..F {
            let mut next = (f64::NEG_INFINITY, 0);
            for f in (1..F).filter(|f| self.limits[*f].exists && !active[*f]) {
                let over = trial[f].abs() - self.limits[f].strength;
                let reach = over / self.limits[f].slope;
                if over > self.limits[f].slope * p && reach > next.0 {
                    next = (reach, f);
                }
            }
            let (_, f) = next;
            if f == 0 {
                break;
            }
            let Limit { strength, slope, .. } = self.limits[f];
            active[f] = true;
            above += slope * (trial[f].abs() - strength) / k[f];
            below += slope * slope / k[f];
            p = above / below;
        }
        let is_torn = p < self.lowest;
        let mut out = Response { s: [0.0; F], d: [[0.0; F]; F] };
        // The derivatives of p are these over `below`: those of a force on its limit are its slope
        // times those of p.
        let mut slopes = [0.0; F];
        (out.s[0], slopes[0]) = if is_torn { (self.lowest, 0.0) } else { (p, 1.0) };
        for f in (1..F).filter(|f| self.limits[*f].exists) {
            let Limit { strength, slope, .. } = self.limits[f];
            let most = (strength + slope * out.s[0]).max(0.0);
            let is_elastic = if is_torn { trial[f].abs() < most } else { !active[f] };
            if is_elastic {
                out.s[f] = trial[f];
                out.d[f][f] = k[f];
            } else {
                out.s[f] = most.min(trial[f].abs()).copysign(trial[f]);
                slopes[f] = slope.copysign(trial[f]) * slopes[0];
            }
        }
        let stiffness = 1.0 / below;
        for f in 0..F {
            for g in 0..F {
                out.d[f][g] += slopes[f] * slopes[g] * stiffness;
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn spring() -> impl Strategy<Value = Spring<3>> {
        let limit =
            (prop::bool::weighted(0.8), 0.0..1.0_f64, prop_oneof![Just(0.0), 0.05..1.0_f64]);
        let limit = limit.prop_map(|(exists, strength, slope)| match (exists, slope) {
            (false, _) => NONE,
            // A limit without slope is one of cohesion alone.
            (true, 0.0) => Limit { exists, strength: strength + 0.1, slope: 0.0 },
            (true, slope) => Limit { exists, strength, slope },
        });
        let input = (prop::array::uniform3(0.1..10.0_f64), [limit.clone(), limit], 0.0..1.0_f64);
        input.prop_map(|(stiffness, limits, tension)| {
            let apex = |l: &Limit| if l.slope > 0.0 { l.strength / l.slope } else { f64::INFINITY };
            let lowest = limits.iter().map(apex).fold(tension, f64::min);
            Spring {
                stiffness,
                linear: [0.0; 3],
                limits: [NONE, limits[0], limits[1]],
                lowest: -lowest,
            }
        })
    }

    fn kinematics() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(-3.0..3.0_f64)
    }

    /// Half of the distance from the trial in the metric of the compliances.
    fn distance(spring: &Spring<3>, e: &[f64; 3], s: &[f64; 3]) -> f64 {
        let of = |f: usize| 0.5 * (s[f] / spring.stiffness[f] - e[f]).powi(2) * spring.stiffness[f];
        (0..3).filter(|f| *f == 0 || spring.limits[*f].exists).map(of).sum()
    }

    fn largest(spring: &Spring<3>, x: usize, p: f64) -> f64 {
        let limit = &spring.limits[x + 1];
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
        fn derivatives_with_moments_are_those_of_the_forces(
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
        let spring = Spring {
            stiffness: [2.0, 1.0, 4.0],
            linear: [0.0; 3],
            limits: [NONE, limit(0.0, 0.5), limit(0.0, 0.25)],
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

    /// Stiffnesses of 2 and 1, a coefficient of friction of 0.5, cohesion of 1, strength of 0.5.
    fn bond() -> Spring<2> {
        let limit = Limit { exists: true, strength: 1.0, slope: 0.5 };
        Spring { stiffness: [2.0, 1.0], linear: [0.0; 2], limits: [NONE, limit], lowest: -0.5 }
    }

    /// A contact with friction and without strength.
    fn contact() -> Spring<2> {
        let limit = Limit { exists: true, strength: 0.0, slope: 0.5 };
        Spring { limits: [NONE, limit], lowest: 0.0, ..bond() }
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
        assert_eq!(contact().respond([-1.0, 0.1]).s, [0.0, 0.0]);
    }

    /// Derivatives are those of the forces wherever these are smooth.
    #[test]
    fn derivatives_are_those_of_the_forces() {
        let frictionless = Spring { limits: [NONE; 2], ..bond() };
        for spring in [bond(), frictionless, contact()] {
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
