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
//!
//! All this is done for every interaction in every iteration: it is compiled for the number `F` of
//! forces and `Q` of limits (see [`Kind`](super::super::scaled::Kind)).

use super::super::scaled::ROWS;
use super::cell::Law;

/// Unknowns at most: forces and multipliers.
const SIZE: usize = 3 + ROWS;

/// Slacks and multipliers of the limits, their steps, and what the steps are to bring about.
#[derive(Clone, Copy, Debug)]
pub struct Slacks<const Q: usize> {
    /// Slacks w.
    pub w: [f64; Q],
    /// Multipliers lambda.
    pub lambda: [f64; Q],
    /// Steps of w.
    pub dw: [f64; Q],
    /// Steps of lambda.
    pub dlambda: [f64; Q],
    /// Defects d of the limits.
    pub defect: [f64; Q],
    /// Products c to be taken away.
    pub product: [f64; Q],
}

impl<const Q: usize> Default for Slacks<Q> {
    fn default() -> Self {
        let zero = [0.0; Q];
        Self { w: zero, lambda: zero, dw: zero, dlambda: zero, defect: zero, product: zero }
    }
}

/// Right side of the system without kinematics: rows of forces, rows of active multipliers.
#[derive(Clone, Copy, Debug)]
pub struct Right<const F: usize, const Q: usize> {
    forces: [f64; F],
    limits: [f64; Q],
}

impl<const F: usize, const Q: usize> Default for Right<F, Q> {
    fn default() -> Self {
        Self { forces: [0.0; F], limits: [0.0; Q] }
    }
}

/// The inverse of the system by blocks; rows and columns of limits that are not active are zero.
#[derive(Clone, Copy, Debug)]
pub struct LocalSystem<const F: usize, const Q: usize> {
    /// Takes kinematics to forces: T.
    pub stiffness: [[f64; F]; F],
    mixed: [[f64; Q]; F],
    limits: [[f64; Q]; Q],
    active: [bool; Q],
}

impl<const F: usize, const Q: usize> Default for LocalSystem<F, Q> {
    fn default() -> Self {
        Self {
            stiffness: [[0.0; F]; F],
            mixed: [[0.0; Q]; F],
            limits: [[0.0; Q]; Q],
            active: [false; Q],
        }
    }
}

impl<const F: usize, const Q: usize> LocalSystem<F, Q> {
    /// Sets up and inverts the system at slacks w and multipliers lambda.
    pub fn set(&mut self, law: &Law<F, Q>, slacks: &Slacks<Q>) {
        let (w, lambda) = (&slacks.w, &slacks.lambda);
        *self = Self::default();
        let mut any = false;
        for q in 0..Q {
            self.active[q] = lambda[q] > w[q];
            any |= self.active[q];
        }
        if !any && F == 2 {
            let inverse = inverse_of_two(law, w, lambda);
            for f in 0..F {
                self.stiffness[f].copy_from_slice(&inverse[f][..F]);
            }
            return;
        }
        let mut m = [[0.0; SIZE]; SIZE];
        for f in 0..F {
            m[f][f] = law.compliance[f];
        }
        // Limit by unknown.
        let mut limit = [0; SIZE];
        let mut n = F;
        for q in 0..Q {
            let a = &law.limits[q];
            if self.active[q] {
                for f in 0..F {
                    m[f][n] = a[f];
                    m[n][f] = a[f];
                }
                m[n][n] = -w[q] / lambda[q];
                limit[n] = q;
                n += 1;
            } else {
                let theta = lambda[q] / w[q];
                for f in 0..F {
                    for g in 0..F {
                        m[f][g] += theta * a[f] * a[g];
                    }
                }
            }
        }
        let inverse = match n {
            1 => invert::<1>(&mut m),
            2 => invert::<2>(&mut m),
            3 => invert::<3>(&mut m),
            4 => invert::<4>(&mut m),
            5 => invert::<5>(&mut m),
            6 => invert::<6>(&mut m),
            _ => invert::<SIZE>(&mut m),
        };
        for f in 0..F {
            for g in 0..F {
                self.stiffness[f][g] = inverse[f][g];
            }
            for k in F..n {
                self.mixed[f][limit[k]] = inverse[f][k];
            }
        }
        for k in F..n {
            for l in F..n {
                self.limits[limit[k]][limit[l]] = inverse[k][l];
            }
        }
    }

    /// Right side for the residuals r of stationarity, and for the defects and products of `slacks`.
    #[inline]
    #[must_use]
    pub fn right(
        &self,
        law: &Law<F, Q>,
        stationarity: &[f64; F],
        slacks: &Slacks<Q>,
    ) -> Right<F, Q> {
        let mut right = Right::default();
        for f in 0..F {
            right.forces[f] = -stationarity[f];
        }
        for q in 0..Q {
            let (w, lambda) = (slacks.w[q], slacks.lambda[q]);
            let (d, c) = (slacks.defect[q], slacks.product[q]);
            if self.active[q] {
                right.limits[q] = c / lambda - d;
            } else {
                // dlambda = (-c - lambda dw)/w with dw = -d - A ds.
                let constant = (lambda * d - c) / w;
                for f in 0..F {
                    right.forces[f] -= law.limits[q][f] * constant;
                }
            }
        }
        right
    }

    /// Steps of the forces without kinematics.
    #[inline]
    #[must_use]
    pub fn forces(&self, right: &Right<F, Q>) -> [f64; F] {
        let mut ds = [0.0; F];
        for f in 0..F {
            for g in 0..F {
                ds[f] += self.stiffness[f][g] * right.forces[g];
            }
            for q in 0..Q {
                ds[f] += self.mixed[f][q] * right.limits[q];
            }
        }
        ds
    }

    /// Steps of the forces for the kinematics e; those of slacks and multipliers go to `slacks`.
    #[inline]
    pub fn solve(
        &self,
        law: &Law<F, Q>,
        e: &[f64; F],
        right: &Right<F, Q>,
        slacks: &mut Slacks<Q>,
    ) -> [f64; F] {
        let mut right = *right;
        for f in 0..F {
            right.forces[f] += e[f];
        }
        let ds = self.forces(&right);
        for q in 0..Q {
            let (w, lambda, c) = (slacks.w[q], slacks.lambda[q], slacks.product[q]);
            if self.active[q] {
                let mut step = 0.0;
                for f in 0..F {
                    step += self.mixed[f][q] * right.forces[f];
                }
                for k in 0..Q {
                    step += self.limits[q][k] * right.limits[k];
                }
                slacks.dlambda[q] = step;
                slacks.dw[q] = -(c + w * step) / lambda;
            } else {
                let mut step = -slacks.defect[q];
                for f in 0..F {
                    step -= law.limits[q][f] * ds[f];
                }
                slacks.dw[q] = step;
                slacks.dlambda[q] = -(c + lambda * step) / w;
            }
        }
        ds
    }
}

/// Inverse for two forces and no active limit. The determinant is a sum of terms that are not
/// negative (Cauchy and Binet): nothing cancels where a limit outweighs all else.
fn inverse_of_two<const F: usize, const Q: usize>(
    law: &Law<F, Q>,
    w: &[f64; Q],
    lambda: &[f64; Q],
) -> [[f64; 2]; 2] {
    let [c0, c1] = [law.compliance[0], law.compliance[1]];
    let (mut k00, mut k01, mut k11, mut determinant) = (c0, 0.0, c1, c0 * c1);
    let mut theta = [0.0; Q];
    for q in 0..Q {
        theta[q] = lambda[q] / w[q];
        let a = &law.limits[q];
        k00 += theta[q] * a[0] * a[0];
        k01 += theta[q] * a[0] * a[1];
        k11 += theta[q] * a[1] * a[1];
        determinant += theta[q] * (c0 * a[1] * a[1] + c1 * a[0] * a[0]);
        for p in 0..q {
            let b = &law.limits[p];
            let area = a[0] * b[1] - a[1] * b[0];
            determinant += theta[q] * theta[p] * area * area;
        }
    }
    let d = 1.0 / determinant;
    [[k11 * d, -k01 * d], [-k01 * d, k00 * d]]
}

/// Inverse of the leading `N` rows and columns by Gauss and Jordan with partial pivoting.
fn invert<const N: usize>(m: &mut [[f64; SIZE]; SIZE]) -> [[f64; SIZE]; SIZE] {
    let mut inverse = [[0.0; SIZE]; SIZE];
    for (i, row) in inverse.iter_mut().enumerate().take(N) {
        row[i] = 1.0;
    }
    for c in 0..N {
        let mut pivot = c;
        for r in c + 1..N {
            if m[r][c].abs() > m[pivot][c].abs() {
                pivot = r;
            }
        }
        m.swap(c, pivot);
        inverse.swap(c, pivot);
        let d = 1.0 / m[c][c];
        for j in 0..N {
            m[c][j] *= d;
            inverse[c][j] *= d;
        }
        for i in (0..N).filter(|i| *i != c) {
            let factor = m[i][c];
            if factor != 0.0 {
                for j in 0..N {
                    m[i][j] -= factor * m[c][j];
                    inverse[i][j] -= factor * inverse[c][j];
                }
            }
        }
    }
    inverse
}
