//! Coulomb's law of one interaction, its numbers at a point, and its part of the linear system.

use super::super::condensed::interior::Variables;
use super::super::condensed::scaled::{Arms, Local};

/// Maximum number of limits of an interaction: one of p, two of q, two of tau.
pub(crate) const LIMITS: usize = 5;

/// The law of an interaction in units of the scales. With a its dilation under Coulomb's
/// law,
///
/// ```text
/// g + C_n p - e_n - lambda_n - a (mu (lambda_+ + lambda_-) + m (kappa_+ + kappa_-)) = 0
/// C_t (q - q_0) - e_t + lambda_+ - lambda_- = 0
/// C_r (tau - tau_0) - e_r + kappa_+ - kappa_- = 0
/// w_n = f_t + p,   w_+- = c + mu p -+ q,   v_+- = m_0 + m p -+ tau
/// w lambda = 0,   w >= 0,   lambda >= 0
/// ```
pub struct Cell {
    local: Local,
    dilation: f64,
    /// Usual compliances: a part of them regularises the matrix. They are no part of the law.
    usual: [f64; 3],
    /// The matrix from kinematics to forces at the point of the last linearisation; it is not
    /// symmetric.
    pub stiffness: [[f64; 3]; 3],
    /// Multiplier over slack of every limit there.
    theta: [f64; LIMITS],
}

/// The entries of an interaction in a point, a step or a residual. In a residual they are the
/// defects of stationarity, of the limits and of the products.
pub type Entry = Variables<3, LIMITS>;

impl Cell {
    pub fn new(local: Local, dilation: f64, usual: [f64; 3]) -> Self {
        Self { local, dilation, usual, stiffness: [[0.0; 3]; 3], theta: [0.0; LIMITS] }
    }

    /// Its bodies and their rows.
    pub fn arms(&self) -> &Arms<3> {
        &self.local.arms
    }

    /// The numbers of its limits.
    pub(crate) fn each_limit(&self) -> impl Iterator<Item = usize> {
        (0..LIMITS).filter(|q| self.local.has[q.div_ceil(2)])
    }

    /// The part of the strengths that forces use up: the slacks are `strength - of_limits(s)`.
    #[inline]
    fn of_limits(&self, s: &[f64; 3]) -> [f64; LIMITS] {
        let ([p, q, tau], [mu, m]) = (*s, self.local.slopes);
        [-p, q - mu * p, -q - mu * p, tau - m * p, -tau - m * p]
    }

    #[inline]
    fn strength(&self, q: usize) -> f64 {
        self.local.strengths[q.div_ceil(2)]
    }

    /// Clamps forces to their limits, the normal force first.
    pub fn clamp(&self, s: &[f64; 3]) -> [f64; 3] {
        let Local { has, slopes, strengths, .. } = &self.local;
        let mut p = s[0].max(-strengths[0]);
        for k in (0..2).filter(|k| slopes[*k] > 0.0) {
            p = p.max(-strengths[k + 1] / slopes[k]);
        }
        let within = |k: usize| {
            let most = (strengths[k + 1] + slopes[k] * p).max(0.0);
            if has[k + 1] { s[k + 1].clamp(-most, most) } else { 0.0 }
        };
        [p, within(0), within(1)]
    }

    /// Opening of the gap by slips and rotations of these magnitudes.
    #[inline]
    fn opening(&self, slip: f64, rotation: f64) -> f64 {
        let [mu, m] = self.local.slopes;
        self.dilation * (mu * slip + m * rotation)
    }

    /// Slacks and multipliers near those of the forces and kinematics, with all products `product`.
    pub fn near(&self, s: [f64; 3], e: &[f64; 3], product: f64) -> Entry {
        let Local { linear, compliance, .. } = &self.local;
        let [st, sr] = [1, 2].map(|f| e[f] - linear[f] - compliance[f] * s[f]);
        let sn = linear[0] + compliance[0] * s[0] - e[0] - self.opening(st.abs(), sr.abs());
        let raw = [sn, st.max(0.0), (-st).max(0.0), sr.max(0.0), (-sr).max(0.0)];
        let taken = self.of_limits(&s);
        let mut out = Entry { s, w: [1.0; LIMITS], lambda: [0.0; LIMITS] };
        for q in self.each_limit() {
            out.set(q, self.strength(q) - taken[q] - raw[q], product);
        }
        out
    }

    /// Defects of the law at a point with kinematics `e`.
    #[inline]
    pub fn residual(&self, x: &Entry, e: &[f64; 3]) -> Entry {
        let [n, plus, minus, roll_plus, roll_minus] = x.lambda;
        let Local { linear, compliance, .. } = &self.local;
        let elastic = [0, 1, 2].map(|f| linear[f] + compliance[f] * x.s[f] - e[f]);
        let s = [
            elastic[0] - n - self.opening(plus + minus, roll_plus + roll_minus),
            elastic[1] + plus - minus,
            elastic[2] + roll_plus - roll_minus,
        ];
        let mut r = Entry { s, ..Entry::default() };
        let taken = self.of_limits(&x.s);
        for q in self.each_limit() {
            r.w[q] = x.w[q] + taken[q] - self.strength(q);
            r.lambda[q] = x.w[q] * x.lambda[q];
        }
        r
    }

    /// Sets the stiffness to the derivative of the forces by the kinematics at a point, with slacks
    /// and multipliers eliminated, and with this part of the usual compliances added.
    #[inline]
    pub(crate) fn linearise(&mut self, x: &Entry, regularisation: f64) {
        let soft = self.usual.map(|c| regularisation * c);
        let mut theta = [0.0; LIMITS];
        for q in self.each_limit() {
            theta[q] = x.lambda[q] / x.w[q];
        }
        let (Local { has, slopes, .. }, a) = (&self.local, self.dilation);
        let mut own = [0.0; 3];
        let (mut left, mut right) = ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        let mut sum = self.local.compliance[0] + soft[0] + theta[0];
        for (k, force) in [(0, 1), (1, 2)] {
            if !has[force] {
                continue;
            }
            let [plus, minus] = [theta[2 * k + 1], theta[2 * k + 2]];
            let compliance = soft[force] + self.local.compliance[force];
            let flexibility = 1.0 / (compliance + plus + minus);
            let lean = slopes[k] * (plus - minus) * flexibility;
            own[force] = flexibility;
            left[force] = lean;
            right[force] = a * lean;
            let square = slopes[k] * slopes[k];
            sum += a * square * (4.0 * plus * minus + compliance * (plus + minus)) * flexibility;
        }
        let mut stiffness = [[0.0; 3]; 3];
        for f in 0..3 {
            for g in 0..3 {
                stiffness[f][g] = left[f] * right[g] / sum;
            }
            stiffness[f][f] += own[f];
        }
        (self.stiffness, self.theta) = (stiffness, theta);
    }

    /// Steps of the multipliers if the forces do not change, and the kinematics that would cause
    /// the residual's forces.
    #[inline]
    fn asked(&self, x: &Entry, r: &Entry) -> ([f64; LIMITS], [f64; 3]) {
        let mut h = [0.0; LIMITS];
        for q in self.each_limit() {
            h[q] = (x.lambda[q] * r.w[q] - r.lambda[q]) / x.w[q];
        }
        let normal = -r.s[0] + h[0] + self.opening(h[1] + h[2], h[3] + h[4]);
        (h, [normal, -r.s[1] - h[1] + h[2], -r.s[2] - h[3] + h[4]])
    }

    /// Steps of the forces that cancel the residual if no body moves.
    #[inline]
    pub(crate) fn forces_at_rest(&self, x: &Entry, r: &Entry) -> [f64; 3] {
        times(&self.stiffness, &self.asked(x, r).1)
    }

    /// Steps of forces, slacks and multipliers that cancel the residual, for steps `e` of the
    /// kinematics.
    #[inline]
    pub fn step(&self, x: &Entry, r: &Entry, e: &[f64; 3]) -> Entry {
        let (h, asked) = self.asked(x, r);
        let s = times(&self.stiffness, &[0, 1, 2].map(|f| asked[f] + e[f]));
        let taken = self.of_limits(&s);
        let mut out = Entry { s, ..Entry::default() };
        for q in self.each_limit() {
            out.w[q] = -r.w[q] - taken[q];
            out.lambda[q] = h[q] + self.theta[q] * taken[q];
        }
        out
    }
}

/// A matrix times a vector.
#[inline]
pub fn times(t: &[[f64; 3]; 3], e: &[f64; 3]) -> [f64; 3] {
    t.map(|row| row[0] * e[0] + row[1] * e[1] + row[2] * e[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(dilation: f64) -> Cell {
        let local = Local {
            arms: Arms { bodies: [0, 1], rows: [[[0.0; 3]; 3]; 2] },
            has: [true; 3],
            has_tension: false,
            compliance: [0.3, 0.7, 0.45],
            linear: [0.2, -0.1, 0.4],
            slopes: [0.6, 0.25],
            strengths: [0.5, 1.5, 0.8],
        };
        Cell::new(local, dilation, [0.0; 3])
    }

    /// The residual as one row, of a point and kinematics as one row.
    fn residual(cell: &Cell, z: &[f64; 16]) -> [f64; 13] {
        let part = |from: usize| std::array::from_fn(|k| z[from + k]);
        let x = Entry { s: [z[0], z[1], z[2]], w: part(3), lambda: part(8) };
        let r = cell.residual(&x, &[z[13], z[14], z[15]]);
        let mut out = [0.0; 13];
        out[..3].copy_from_slice(&r.s);
        out[3..8].copy_from_slice(&r.w);
        out[8..].copy_from_slice(&r.lambda);
        out
    }

    /// A step of the cell solves the equations that finite differences of its residual give.
    #[test]
    fn steps_solve_the_linearised_law() {
        for dilation in [0.0, 0.5, 1.0] {
            let mut cell = cell(dilation);
            let x = Entry {
                s: [2.0, -0.9, 0.3],
                w: [1.1, 0.3, 2.4, 0.7, 0.2],
                lambda: [0.05, 1.3, 0.02, 0.4, 0.9],
            };
            let e = [0.15, -0.6, 0.35];
            let motion = [0.02, -0.05, 0.07];
            cell.linearise(&x, 0.0);
            let r = cell.residual(&x, &e);
            let step = cell.step(&x, &r, &motion);

            let row = |s: &[f64; 3], w: &[f64; 5], l: &[f64; 5], e: &[f64; 3]| -> [f64; 16] {
                let all = s.iter().chain(w).chain(l).chain(e);
                all.copied().collect::<Vec<_>>().try_into().unwrap()
            };
            let at = row(&x.s, &x.w, &x.lambda, &e);
            let along = row(&step.s, &step.w, &step.lambda, &motion);
            // The residual is quadratic: central differences of it are exact but for round-off.
            let h = 1e-3;
            let moved = |sign: f64| std::array::from_fn(|k| at[k] + sign * h * along[k]);
            let (after, before) = (residual(&cell, &moved(1.0)), residual(&cell, &moved(-1.0)));
            let here = residual(&cell, &at);
            for k in 0..13 {
                let slope = (after[k] - before[k]) / (2.0 * h);
                assert!((here[k] + slope).abs() < 1e-11, "dilation {dilation}, row {k}");
            }
        }
    }

    /// The stiffness is symmetric with full dilation and unsymmetric without dilation.
    #[test]
    fn the_stiffness_of_full_dilation_is_symmetric() {
        let x = Entry {
            s: [2.0, -0.9, 0.3],
            w: [1.1, 0.3, 2.4, 0.7, 0.2],
            lambda: [0.05, 1.3, 0.02, 0.4, 0.9],
        };
        let asymmetry = |dilation: f64| {
            let mut cell = cell(dilation);
            cell.linearise(&x, 0.0);
            let k = cell.stiffness;
            (0..3)
                .flat_map(|f| (0..3).map(move |g| (f, g)))
                .map(|(f, g)| (k[f][g] - k[g][f]).abs())
                .fold(0.0, f64::max)
        };
        assert!(asymmetry(1.0) < 1e-15);
        assert!(asymmetry(0.0) > 0.1);
    }
}
