//! The law of one interaction: its limits, their slacks and multipliers, and the rows of its two
//! bodies.

use super::super::scaled::{Arms, Local, first};

/// Maximum number of pairs of limits.
pub(crate) const MAX_PAIRS: usize = 2;

/// The law of an interaction with `F` forces and `Q` limits: see [`Local`].
#[derive(Clone, Debug)]
pub struct Law<const F: usize, const Q: usize> {
    pub arms: Arms<F>,
    pub compliance: [f64; F],
    pub linear: [f64; F],
    /// Slope m of each pair of limits, `-m p + x` and `-m p - x`.
    pub slopes: [f64; MAX_PAIRS],
    pub right: [f64; Q],
}

/// Rows of consecutive bodies from `first`.
pub struct Rows<'a> {
    pub first: u32,
    pub rows: &'a mut [[f64; 3]],
}

impl<const F: usize, const Q: usize> Law<F, Q> {
    /// Pairs of limits.
    pub const PAIRS: usize = Q / 2;
    /// Whether the last limit is one of tension, `-p`.
    pub(crate) const HAS_TENSION: bool = Q % 2 == 1;

    /// The force that a pair of limits holds.
    #[inline]
    pub const fn force(pair: usize) -> usize {
        // A wheel has p, q and tau, and limits of tau.
        if F == 3 && Q == 2 { 2 } else { pair + 1 }
    }

    /// The row of a limit in `A s`.
    #[inline]
    pub fn limit(&self, q: usize, s: &[f64; F]) -> f64 {
        if Self::HAS_TENSION && q == Q - 1 {
            return -s[0];
        }
        let x = s[Self::force(q / 2)];
        let x = if q.is_multiple_of(2) { x } else { -x };
        x - self.slopes[q / 2] * s[0]
    }

    pub fn new(local: &Local) -> Self {
        let mut limits = local.limits();
        Self {
            arms: Arms::of(local),
            compliance: first(&local.compliance),
            linear: first(&local.linear),
            slopes: std::array::from_fn(|k| {
                if k < Self::PAIRS { local.slopes[Self::force(k) - 1] } else { 0.0 }
            }),
            right: std::array::from_fn(|_| limits.next().map_or(0.0, |(_, strength)| strength)),
        }
    }

    pub fn add_forces(&self, s: &[f64; F], sign: f64, out: &mut Rows) {
        self.arms.add_forces_from(out.first, s, sign, out.rows);
    }
}

/// Forces, slacks and multipliers of one interaction, or their steps. At a point w, lambda > 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Variables<const F: usize, const Q: usize> {
    /// Forces.
    pub s: [f64; F],
    /// Slacks w of the limits.
    pub w: [f64; Q],
    /// Multipliers lambda of the limits.
    pub lambda: [f64; Q],
}

impl<const F: usize, const Q: usize> Default for Variables<F, Q> {
    fn default() -> Self {
        Self { s: [0.0; F], w: [0.0; Q], lambda: [0.0; Q] }
    }
}

impl<const F: usize, const Q: usize> Variables<F, Q> {
    /// Sets slack and multiplier of a limit to this difference, `w - lambda`, and product.
    #[inline]
    pub fn set(&mut self, q: usize, difference: f64, product: f64) {
        let root = difference.hypot(2.0 * product.sqrt());
        self.w[q] = if difference > 0.0 {
            0.5 * (difference + root)
        } else {
            2.0 * product / (root - difference)
        };
        self.lambda[q] = product / self.w[q];
    }

    /// Slack and multiplier of a limit.
    #[inline]
    pub fn limit(&self, q: usize) -> (f64, f64) {
        (self.w[q], self.lambda[q])
    }

    /// Products `w lambda`.
    #[inline]
    pub fn products(&self) -> [f64; Q] {
        std::array::from_fn(|q| self.w[q] * self.lambda[q])
    }
}
