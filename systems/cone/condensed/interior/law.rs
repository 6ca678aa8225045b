//! The law of one interaction: its limits, and the rows of its two bodies.

use super::super::scaled::{Local, add_forces, kinematics};

/// Maximum number of pairs of limits.
pub const MAX_PAIRS: usize = 2;

/// The law of an interaction with `F` forces and `Q` limits: see [`Local`].
#[derive(Clone, Debug)]
pub struct Law<const F: usize, const Q: usize> {
    pub bodies: [u32; 2],
    pub rows: [[[f64; F]; 3]; 2],
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

/// The first of these numbers.
pub fn first<const N: usize>(x: &[f64]) -> [f64; N] {
    std::array::from_fn(|k| x[k])
}

impl<const F: usize, const Q: usize> Law<F, Q> {
    /// Pairs of limits.
    pub const PAIRS: usize = Q / 2;
    /// Whether the last limit is one of tension, `-p`.
    pub const HAS_TENSION: bool = Q % 2 == 1;

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
        if q.is_multiple_of(2) {
            x - self.slopes[q / 2] * s[0]
        } else {
            -x - self.slopes[q / 2] * s[0]
        }
    }

    pub fn new(local: &Local) -> Self {
        Self {
            bodies: local.bodies.map(|i| i as u32),
            rows: local.rows.map(|rows| rows.map(|row| first(&row))),
            compliance: first(&local.compliance),
            linear: first(&local.linear),
            slopes: std::array::from_fn(|k| -local.limits[2 * k][0]),
            right: first(&local.right),
        }
    }

    pub fn kinematics(&self, u: &[[f64; 3]]) -> [f64; F] {
        kinematics(self.bodies, &self.rows, u)
    }

    pub fn add_forces(&self, s: &[f64; F], sign: f64, out: &mut Rows) {
        add_forces(self.bodies.map(|i| i - out.first), &self.rows, s, sign, out.rows);
    }
}
