//! The Newton system of one interaction, without cancellation.
//!
//! ```text
//! C ds + A' dlambda = e - r         stationarity
//! A ds + dw         = -d            limits
//! lambda dw + w dlambda = -c        complementarity
//! ```
//!
//! Near the solution w or lambda of a limit vanishes, and whichever is small must come out with a
//! small *relative* error or the iteration diverges. Limits with `lambda > w` (active) stay in the
//! system with their multiplier, `A ds - (w/lambda) dlambda = -d + c/lambda`, and their slack follows
//! from complementarity; the others are folded into the compliance by `theta = lambda/w`, and their
//! multiplier follows from complementarity.

use super::scaled::{Local, ROWS};

/// Unknowns at most: three forces and the multipliers of the limits.
const SIZE: usize = 3 + ROWS;

/// Right sides of the system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Right {
    /// r.
    pub stationarity: [f64; 3],
    /// d.
    pub defects: [f64; ROWS],
    /// c.
    pub products: [f64; ROWS],
}

/// The inverse of the system.
#[derive(Clone, Copy, Debug)]
pub struct LocalSystem {
    inverse: [[f64; SIZE]; SIZE],
    active: [usize; ROWS],
    count: usize,
}

impl Default for LocalSystem {
    fn default() -> Self {
        Self { inverse: [[0.0; SIZE]; SIZE], active: [0; ROWS], count: 0 }
    }
}

impl LocalSystem {
    /// Sets up and inverts the system at slacks w and multipliers lambda.
    #[must_use]
    pub fn new(local: &Local, w: &[f64; ROWS], lambda: &[f64; ROWS]) -> Self {
        let mut out = Self::default();
        let mut m = [[0.0; SIZE]; SIZE];
        for f in 0..3 {
            m[f][f] = if local.has[f] { local.compliance[f] } else { 1.0 };
        }
        for q in 0..local.count {
            let a = &local.limits[q];
            if lambda[q] > w[q] {
                let k = 3 + out.count;
                out.active[out.count] = q;
                out.count += 1;
                for f in 0..3 {
                    m[f][k] = a[f];
                    m[k][f] = a[f];
                }
                m[k][k] = -w[q] / lambda[q];
            } else {
                let theta = lambda[q] / w[q];
                for i in 0..3 {
                    for j in 0..3 {
                        m[i][j] += theta * a[i] * a[j];
                    }
                }
            }
        }
        invert(&mut m, 3 + out.count, &mut out.inverse);
        for f in (0..3).filter(|f| !local.has[*f]) {
            for k in 0..SIZE {
                out.inverse[f][k] = 0.0;
                out.inverse[k][f] = 0.0;
            }
        }
        out
    }

    /// The part T of the inverse that takes kinematics to forces.
    #[must_use]
    pub fn compliance_inverse(&self) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.inverse[i][j]))
    }

    /// Steps of the forces, and (dw, dlambda) of the limits, for the kinematics e.
    #[must_use]
    pub fn solve(
        &self,
        local: &Local,
        e: &[f64; 3],
        right: &Right,
        w: &[f64; ROWS],
        lambda: &[f64; ROWS],
    ) -> ([f64; 3], [(f64, f64); ROWS]) {
        let mut b = [0.0; SIZE];
        for f in 0..3 {
            b[f] = e[f] - right.stationarity[f];
        }
        let mut is_active = [false; ROWS];
        for k in 0..self.count {
            let q = self.active[k];
            is_active[q] = true;
            b[3 + k] = -right.defects[q] + right.products[q] / lambda[q];
        }
        for q in (0..local.count).filter(|q| !is_active[*q]) {
            // dlambda = (-c - lambda dw)/w with dw = -d - A ds.
            let constant = (lambda[q] * right.defects[q] - right.products[q]) / w[q];
            for f in 0..3 {
                b[f] -= local.limits[q][f] * constant;
            }
        }
        let size = 3 + self.count;
        let mut y = [0.0; SIZE];
        for (i, y) in y.iter_mut().enumerate().take(size) {
            for j in 0..size {
                *y += self.inverse[i][j] * b[j];
            }
        }
        let ds = [y[0], y[1], y[2]];
        let mut steps = [(0.0, 0.0); ROWS];
        for k in 0..self.count {
            let q = self.active[k];
            let dlambda = y[3 + k];
            steps[q] = (-(right.products[q] + w[q] * dlambda) / lambda[q], dlambda);
        }
        for q in (0..local.count).filter(|q| !is_active[*q]) {
            let a = &local.limits[q];
            let dw = -right.defects[q] - (a[0] * ds[0] + a[1] * ds[1] + a[2] * ds[2]);
            steps[q] = (dw, -(right.products[q] + lambda[q] * dw) / w[q]);
        }
        (ds, steps)
    }
}

/// Inverts the leading `n` rows and columns by Gauss and Jordan with partial pivoting.
fn invert(m: &mut [[f64; SIZE]; SIZE], n: usize, out: &mut [[f64; SIZE]; SIZE]) {
    for (i, row) in out.iter_mut().enumerate() {
        *row = [0.0; SIZE];
        row[i] = 1.0;
    }
    for c in 0..n {
        let pivot = (c..n).max_by(|a, b| m[*a][c].abs().total_cmp(&m[*b][c].abs())).unwrap_or(c);
        m.swap(c, pivot);
        out.swap(c, pivot);
        let d = m[c][c];
        for j in 0..n {
            m[c][j] /= d;
            out[c][j] /= d;
        }
        for i in (0..n).filter(|i| *i != c) {
            let factor = m[i][c];
            if factor != 0.0 {
                for j in 0..n {
                    m[i][j] -= factor * m[c][j];
                    out[i][j] -= factor * out[c][j];
                }
            }
        }
    }
}
