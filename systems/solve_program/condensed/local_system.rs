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

/// Unknowns at most: three forces and four multipliers (limits of rolling imply that of tension), or
/// two forces and three.
const SIZE: usize = 7;

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
    /// Rows of `size` entries: forces that exist, then multipliers of active limits.
    inverse: [f64; SIZE * SIZE],
    size: u8,
    forces: u8,
    /// Force by unknown.
    force: [u8; 3],
    /// Limit by active multiplier.
    active: [u8; ROWS],
    is_active: [bool; ROWS],
}

impl Default for LocalSystem {
    fn default() -> Self {
        Self {
            inverse: [0.0; SIZE * SIZE],
            size: 0,
            forces: 0,
            force: [0; 3],
            active: [0; ROWS],
            is_active: [false; ROWS],
        }
    }
}

impl LocalSystem {
    /// Sets up and inverts the system at slacks w and multipliers lambda.
    pub fn set(&mut self, local: &Local, w: &[f64; ROWS], lambda: &[f64; ROWS]) {
        let mut n = 0;
        for f in (0..3).filter(|f| local.has[*f]) {
            self.force[n] = f as u8;
            n += 1;
        }
        self.forces = n as u8;
        let forces = n;
        for q in 0..local.count {
            self.is_active[q] = lambda[q] > w[q];
            if self.is_active[q] {
                self.active[n - forces] = q as u8;
                n += 1;
            }
        }
        self.size = n as u8;
        let mut m = [[0.0; SIZE]; SIZE];
        for i in 0..forces {
            m[i][i] = local.compliance[self.force[i] as usize];
        }
        for q in (0..local.count).filter(|q| !self.is_active[*q]) {
            let a = &local.limits[q];
            let theta = lambda[q] / w[q];
            for i in 0..forces {
                let scaled = theta * a[self.force[i] as usize];
                for j in 0..forces {
                    m[i][j] += scaled * a[self.force[j] as usize];
                }
            }
        }
        for k in forces..n {
            let q = self.active[k - forces] as usize;
            for i in 0..forces {
                let a = local.limits[q][self.force[i] as usize];
                m[i][k] = a;
                m[k][i] = a;
            }
            m[k][k] = -w[q] / lambda[q];
        }
        invert(&mut m, n, &mut self.inverse);
    }

    /// The part T of the inverse that takes kinematics to forces.
    #[must_use]
    pub fn compliance_inverse(&self) -> [[f64; 3]; 3] {
        let mut t = [[0.0; 3]; 3];
        let (n, forces) = (self.size as usize, self.forces as usize);
        for i in 0..forces {
            for j in 0..forces {
                t[self.force[i] as usize][self.force[j] as usize] = self.inverse[n * i + j];
            }
        }
        t
    }

    /// Steps of the forces for the kinematics e.
    #[must_use]
    pub fn forces(
        &self,
        local: &Local,
        e: &[f64; 3],
        right: &Right,
        w: &[f64; ROWS],
        lambda: &[f64; ROWS],
    ) -> [f64; 3] {
        let b = self.right_side(local, e, right, w, lambda);
        let n = self.size as usize;
        let mut ds = [0.0; 3];
        for i in 0..self.forces as usize {
            ds[self.force[i] as usize] = dot(&self.inverse[n * i..n * (i + 1)], &b);
        }
        ds
    }

    fn right_side(
        &self,
        local: &Local,
        e: &[f64; 3],
        right: &Right,
        w: &[f64; ROWS],
        lambda: &[f64; ROWS],
    ) -> [f64; SIZE] {
        let mut b = [0.0; SIZE];
        let (n, forces) = (self.size as usize, self.forces as usize);
        for i in 0..forces {
            let f = self.force[i] as usize;
            b[i] = e[f] - right.stationarity[f];
        }
        for k in forces..n {
            let q = self.active[k - forces] as usize;
            b[k] = -right.defects[q] + right.products[q] / lambda[q];
        }
        for q in (0..local.count).filter(|q| !self.is_active[*q]) {
            // dlambda = (-c - lambda dw)/w with dw = -d - A ds.
            let constant = (lambda[q] * right.defects[q] - right.products[q]) / w[q];
            for i in 0..forces {
                b[i] -= local.limits[q][self.force[i] as usize] * constant;
            }
        }
        b
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
        let b = self.right_side(local, e, right, w, lambda);
        let (n, forces) = (self.size as usize, self.forces as usize);
        let mut ds = [0.0; 3];
        let mut steps = [(0.0, 0.0); ROWS];
        for i in 0..n {
            let y = dot(&self.inverse[n * i..n * (i + 1)], &b);
            if i < forces {
                ds[self.force[i] as usize] = y;
            } else {
                let q = self.active[i - forces] as usize;
                steps[q] = (-(right.products[q] + w[q] * y) / lambda[q], y);
            }
        }
        for q in (0..local.count).filter(|q| !self.is_active[*q]) {
            let a = &local.limits[q];
            let dw = -right.defects[q] - (a[0] * ds[0] + a[1] * ds[1] + a[2] * ds[2]);
            steps[q] = (dw, -(right.products[q] + lambda[q] * dw) / w[q]);
        }
        (ds, steps)
    }
}

fn dot(row: &[f64], b: &[f64; SIZE]) -> f64 {
    row.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Inverts the leading `n` rows and columns by Gauss and Jordan with partial pivoting, into rows of
/// `n` entries.
fn invert(m: &mut [[f64; SIZE]; SIZE], n: usize, out: &mut [f64; SIZE * SIZE]) {
    let mut inverse = [[0.0; SIZE]; SIZE];
    for (i, row) in inverse.iter_mut().enumerate().take(n) {
        row[i] = 1.0;
    }
    for c in 0..n {
        let mut pivot = c;
        for r in c + 1..n {
            if m[r][c].abs() > m[pivot][c].abs() {
                pivot = r;
            }
        }
        m.swap(c, pivot);
        inverse.swap(c, pivot);
        let d = 1.0 / m[c][c];
        for j in 0..n {
            m[c][j] *= d;
            inverse[c][j] *= d;
        }
        for i in (0..n).filter(|i| *i != c) {
            let factor = m[i][c];
            if factor != 0.0 {
                for j in 0..n {
                    m[i][j] -= factor * m[c][j];
                    inverse[i][j] -= factor * inverse[c][j];
                }
            }
        }
    }
    for i in 0..n {
        out[n * i..n * (i + 1)].copy_from_slice(&inverse[i][..n]);
    }
}
