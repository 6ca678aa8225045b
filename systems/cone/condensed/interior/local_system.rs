//! The Newton system of one interaction, in closed form and without cancellation.
//!
//! ```text
//! C ds + A' dlambda = e - r         stationarity
//! A ds + dw         = -d            limits
//! lambda dw + w dlambda = -c        complementarity
//! ```
//!
//! Limits come in pairs, of `x - m p` and of `-x - m p`, one for each force x (shear, rolling
//! moment) that the normal force p allows, and there may be one of tension, of `-p`. With `theta =
//! lambda/w` and `b = c/lambda - d` the multipliers are `dlambda = theta (A ds - b)`, each x
//! follows from p, and p from
//!
//! ```text
//! (c_n + sum m a) dp = e_n - r_n + sum m (...)
//! a = m (S c_x + 4 theta_+ theta_-)/(c_x + S),   S = theta_+ + theta_-
//! ```
//!
//! in which every term of the sums is positive, so that nothing cancels however stiff a limit is.
//!
//! Near the solution w or lambda of a limit vanishes, and the smaller one needs a small *relative*
//! error or the iteration diverges. A limit with `lambda > w` is active: its multiplier follows
//! from stationarity and its slack from complementarity. For the other limits it is the other way
//! round.
//!
//! If one limit of a pair is active, the stationarity of x gives its multiplier. If both are active
//! (the apex), it gives the difference of the multipliers; their sum, like the multiplier of
//! tension, follows from the stationarity of p. These sums are the *ties* of p. With two ties the
//! stationarity of p gives their sum only, and the relation of each tie to p gives its share.

use super::law::{Law, MAX_PAIRS, Variables};

/// Minimum slope of a tie. With a smaller slope p hardly enters, and the sum follows from the
/// limits of the pair alone.
const MIN_TIE_SLOPE: f64 = 1e-6;

/// The pair of limits of a force x.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    /// `1/(c_x + S)`.
    flexibility: f64,
    /// Both theta times the flexibility.
    weights: [f64; 2],
    /// `theta_+ (c_x + 2 theta_-)/(c_x + S)`, and the same with + and - exchanged.
    pulls: [f64; 2],
    /// Derivative of the sum of the multipliers by -p: a.
    fall: f64,
}

/// The system at given slacks and multipliers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalSystem<const F: usize, const Q: usize> {
    /// Compliances of the step.
    pub compliance: [f64; F],
    /// The matrix T from kinematics to forces.
    pub stiffness: [[f64; F]; F],
    pairs: [Pair; MAX_PAIRS],
    /// Theta of the limit of tension.
    tension: f64,
}

impl<const F: usize, const Q: usize> Default for LocalSystem<F, Q> {
    fn default() -> Self {
        Self {
            compliance: [0.0; F],
            stiffness: [[0.0; F]; F],
            pairs: [Pair::default(); MAX_PAIRS],
            tension: 0.0,
        }
    }
}

impl<const F: usize, const Q: usize> LocalSystem<F, Q> {
    /// Sets up the system at a point, with compliances of at least `min_compliance`.
    #[inline]
    pub fn set(&mut self, law: &Law<F, Q>, point: &Variables<F, Q>, min_compliance: f64) {
        self.compliance = law.compliance.map(|c| c.max(min_compliance));
        let Variables { w, lambda, .. } = point;
        let mut sum = self.compliance[0];
        if Law::<F, Q>::HAS_TENSION {
            self.tension = lambda[Q - 1] / w[Q - 1];
            sum += self.tension;
        }
        // Stiffness of forces without limits of their own.
        let mut own = self.compliance.map(|c| 1.0 / c);
        let mut with_p = [0.0; F];
        for k in 0..Law::<F, Q>::PAIRS {
            let (c, m, x) = (self.compliance[Law::<F, Q>::force(k)], law.slopes[k], 2 * k);
            let (plus, minus) = (lambda[x] / w[x], lambda[x + 1] / w[x + 1]);
            let total = plus + minus;
            let flexibility = 1.0 / (c + total);
            let fall = m * (total * c + 4.0 * plus * minus) * flexibility;
            self.pairs[k] = Pair {
                flexibility,
                weights: [plus * flexibility, minus * flexibility],
                pulls: [
                    plus * (c + 2.0 * minus) * flexibility,
                    minus * (c + 2.0 * plus) * flexibility,
                ],
                fall,
            };
            sum += m * fall;
            own[Law::<F, Q>::force(k)] = flexibility;
            with_p[Law::<F, Q>::force(k)] = m * (plus - minus) * flexibility;
        }
        with_p[0] = 1.0;
        own[0] = 0.0;
        let p = 1.0 / sum;
        for f in 0..F {
            for g in 0..F {
                self.stiffness[f][g] = p * with_p[f] * with_p[g];
            }
            self.stiffness[f][f] += own[f];
        }
    }

    /// Steps of the forces, for the kinematics less the residuals of stationarity `e` and the right
    /// sides `b` of the limits.
    #[inline]
    pub fn forces(&self, law: &Law<F, Q>, e: &[f64; F], b: &[f64; Q]) -> [f64; F] {
        let mut of_p = e[0];
        if Law::<F, Q>::HAS_TENSION {
            of_p -= self.tension * b[Q - 1];
        }
        for k in 0..Law::<F, Q>::PAIRS {
            of_p += law.slopes[k] * self.free_sum(k, e, b);
        }
        // Steps of forces without limits of their own; the other steps follow.
        let mut ds: [f64; F] = std::array::from_fn(|f| e[f] / self.compliance[f]);
        ds[0] = self.stiffness[0][0] * of_p;
        for k in 0..Law::<F, Q>::PAIRS {
            let (pair, f, x) = (&self.pairs[k], Law::<F, Q>::force(k), 2 * k);
            let [plus, minus] = pair.weights;
            ds[f] = pair.flexibility * e[f] + plus * b[x] - minus * b[x + 1]
                + law.slopes[k] * (plus - minus) * ds[0];
        }
        ds
    }

    /// Sum of the multipliers' steps of a pair where p is held.
    #[inline]
    fn free_sum(&self, k: usize, e: &[f64; F], b: &[f64; Q]) -> f64 {
        let (pair, x) = (&self.pairs[k], 2 * k);
        let lean = pair.weights[0] - pair.weights[1];
        lean * e[Law::<F, Q>::force(k)] - pair.pulls[0] * b[x] - pair.pulls[1] * b[x + 1]
    }

    /// Steps of forces, slacks and multipliers, for the kinematics less the residuals of stationarity
    /// `e`, the defects d of the limits, and the products c.
    #[inline]
    pub fn solve(
        &self,
        law: &Law<F, Q>,
        Variables { w, lambda, .. }: &Variables<F, Q>,
        e: &[f64; F],
        defect: &[f64; Q],
        product: &[f64; Q],
    ) -> Variables<F, Q> {
        let b = std::array::from_fn(|q| product[q] / lambda[q] - defect[q]);
        let ds = self.forces(law, e, &b);
        let (mut dw, mut dlambda) = ([0.0; Q], [0.0; Q]);
        // At first no limit counts as active.
        for q in 0..Q {
            let step = -defect[q] - law.limit(q, &ds);
            dw[q] = step;
            dlambda[q] = -(product[q] + lambda[q] * step) / w[q];
        }
        let is_active = |q: usize| lambda[q] > w[q];
        // Difference of the multipliers of a pair.
        let difference = |k: usize| {
            let f = Law::<F, Q>::force(k);
            e[f] - self.compliance[f] * ds[f]
        };
        let divide =
            |k: usize, sum: f64| [0.5 * (sum + difference(k)), 0.5 * (sum - difference(k))];
        // The part of the stationarity of p that its ties must cancel.
        let mut left = self.compliance[0] * ds[0] - e[0];
        let mut ties = [false; MAX_PAIRS];
        for k in 0..Law::<F, Q>::PAIRS {
            let x = 2 * k;
            match [is_active(x), is_active(x + 1)] {
                [true, false] => dlambda[x] = dlambda[x + 1] + difference(k),
                [false, true] => dlambda[x + 1] = dlambda[x] - difference(k),
                [true, true] if law.slopes[k] > MIN_TIE_SLOPE => {
                    ties[k] = true;
                    continue;
                }
                [true, true] => {
                    let sum = self.free_sum(k, e, &b) - self.pairs[k].fall * ds[0];
                    [dlambda[x], dlambda[x + 1]] = divide(k, sum);
                }
                [false, false] => {}
            }
            left -= law.slopes[k] * (dlambda[x] + dlambda[x + 1]);
        }
        let mut tension = false;
        if Law::<F, Q>::HAS_TENSION {
            tension = is_active(Q - 1);
            if !tension {
                left -= dlambda[Q - 1];
            }
        }
        // The relation of a tie to p: its slope m, the fall a of its sum, and its sum if p is held.
        let tie = |k: usize| Tie {
            slope: law.slopes[k],
            fall: self.pairs[k].fall,
            free: self.free_sum(k, e, &b),
        };
        let of_tension = || Tie { slope: 1.0, fall: self.tension, free: -self.tension * b[Q - 1] };
        let mut tied = |k: usize, sum: f64| {
            [dlambda[2 * k], dlambda[2 * k + 1]] = divide(k, sum);
        };
        match (ties, tension) {
            ([true, true], _) => {
                let [first, second] = sums(tie(0), tie(1), left);
                tied(0, first);
                tied(1, second);
            }
            ([true, false], true) => {
                let [first, second] = sums(tie(0), of_tension(), left);
                tied(0, first);
                dlambda[Q - 1] = second;
            }
            ([true, false], false) => tied(0, left / law.slopes[0]),
            ([false, true], _) => tied(1, left / law.slopes[1]),
            ([false, false], true) => dlambda[Q - 1] = left,
            ([false, false], false) => {}
        }
        for q in (0..Q).filter(|q| is_active(*q)) {
            dw[q] = -(product[q] + w[q] * dlambda[q]) / lambda[q];
        }
        Variables { s: ds, w: dw, lambda: dlambda }
    }
}

/// A tie of p: active limits whose multipliers have the sum `free - fall dp`. The sum enters the
/// stationarity of p with the factor `slope`.
struct Tie {
    slope: f64,
    fall: f64,
    free: f64,
}

/// The sums of two ties whose parts in the stationarity of p add up to `left`.
#[inline]
fn sums(first: Tie, second: Tie, left: f64) -> [f64; 2] {
    let between = first.free / first.fall - second.free / second.fall;
    let total = 1.0 / (first.slope * first.fall + second.slope * second.fall);
    [
        total * first.fall * (second.slope * second.fall * between + left),
        total * second.fall * (left - first.slope * first.fall * between),
    ]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::TestRunner;

    use super::super::super::scaled::Arms;
    use super::super::law::{Law, Variables};
    use super::{LocalSystem, MIN_TIE_SLOPE};

    fn power(range: std::ops::Range<f64>) -> impl Strategy<Value = f64> {
        range.prop_map(|x| 10.0_f64.powf(x))
    }

    fn law<const F: usize, const Q: usize>() -> impl Strategy<Value = Law<F, Q>> {
        let compliance = prop_oneof![Just(0.0), 1e-6..10.0_f64];
        let slope = prop_oneof![Just(0.0), Just(1e-9), 1e-3..1.0_f64];
        let input = (prop::array::uniform3(compliance), slope, 1e-3..1.0_f64);
        input.prop_map(|([n, t, r], first, second)| Law {
            arms: Arms { bodies: [0, 1], rows: [[[0.0; F]; 3]; 2] },
            // The shear force of a wheel has a compliance and no limits.
            compliance: std::array::from_fn(|f| match f {
                0 => n,
                1 if Law::<F, Q>::force(0) == 2 => 1.0,
                1 => t,
                _ => r,
            }),
            linear: [0.0; F],
            // At least one limit involves p.
            slopes: if Q % 2 == 1 || Q == 4 { [first, second] } else { [second, 0.0] },
            right: [0.0; Q],
        })
    }

    /// Not too far from the central path: products differ by a factor of 1e4 at most.
    fn point<const F: usize, const Q: usize>()
    -> impl Strategy<Value = (Variables<F, Q>, [[f64; Q]; 2])> {
        let each = |_| (power(-8.0..2.0), power(-2.0..2.0), -1.0..1.0_f64, 0.0..2.0_f64);
        (power(-10.0..0.0), std::array::from_fn::<_, Q, _>(each)).prop_map(|(mu, each)| {
            let point = Variables {
                s: [0.0; F],
                w: each.map(|(w, ..)| w),
                lambda: each.map(|(w, product, ..)| mu * product / w),
            };
            let defect = each.map(|(w, _, defect, _)| defect * w);
            let product = each.map(|(_, product, _, part)| mu * product * part);
            (point, [defect, product])
        })
    }

    /// Whether terms add up to zero, up to 1e-8 of the maximum of their magnitudes and `size`.
    fn cancel(terms: &[f64], size: f64) -> Result<(), TestCaseError> {
        let sum: f64 = terms.iter().sum();
        let maximum = terms.iter().map(|x| x.abs()).fold(size.max(1e-300), f64::max);
        prop_assert!(sum.abs() <= 1e-8 * maximum, "{terms:?}: {:e}", sum / maximum);
        Ok(())
    }

    /// The steps fulfil the three equations of the system, each to round-off of its terms.
    fn check<const F: usize, const Q: usize>() {
        let input = (law::<F, Q>(), point::<F, Q>(), prop::array::uniform3(-1.0..1.0_f64));
        let result = TestRunner::default().run(&input, |(law, (point, [defect, product]), e)| {
            let e: [f64; F] = std::array::from_fn(|f| e[f]);
            // Both limits of a pair without slope are active only if it has almost no strength.
            let active = |q: usize| point.lambda[q] > point.w[q];
            let no_strength =
                |k: usize| law.slopes[k] <= MIN_TIE_SLOPE && active(2 * k) && active(2 * k + 1);
            prop_assume!(!(0..Law::<F, Q>::PAIRS).any(no_strength));
            let mut system = LocalSystem::default();
            system.set(&law, &point, 0.0);
            let Variables { s: ds, w: dw, lambda: dlambda } =
                system.solve(&law, &point, &e, &defect, &product);
            let Variables { w, lambda, .. } = point;
            let mut rows: Vec<Vec<f64>> =
                (0..F).map(|f| vec![law.compliance[f] * ds[f], -e[f]]).collect();
            // The multiplier of an inactive limit is as exact as its slack.
            let mut size = 0.0_f64;
            for q in 0..Q {
                let of = |f: usize, s: f64| {
                    let mut forces = [0.0; F];
                    forces[f] = s;
                    law.limit(q, &forces)
                };
                let limit: Vec<f64> =
                    (0..F).map(|f| of(f, ds[f])).chain([dw[q], defect[q]]).collect();
                if lambda[q] <= w[q] {
                    let maximum = limit.iter().map(|x| x.abs()).fold(0.0, f64::max);
                    size = size.max(lambda[q] / w[q] * maximum);
                }
                for (f, row) in rows.iter_mut().enumerate() {
                    row.push(of(f, 1.0) * dlambda[q]);
                }
                cancel(&limit, 0.0)?;
                cancel(&[lambda[q] * dw[q], w[q] * dlambda[q], product[q]], 0.0)?;
            }
            rows.iter().try_for_each(|row| cancel(row, size))
        });
        assert!(result.is_ok(), "{F} forces, {Q} limits: {}", result.unwrap_err());
    }

    #[test]
    fn steps_fulfil_the_equations_however_small_slacks_are() {
        check::<1, 1>();
        check::<2, 2>();
        check::<2, 3>();
        check::<3, 4>();
        check::<3, 2>();
    }
}
