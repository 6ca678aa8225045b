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
//! All this is done for every interaction in every iteration: functions are compiled for the number
//! `F` of forces and `Q` of limits (see [`Kind`](super::scaled::Kind)).

use super::scaled::{Local, ROWS};

/// Unknowns at most: forces and multipliers.
const SIZE: usize = 3 + ROWS;

/// Slacks and multipliers of the limits, their steps, and what the steps are to bring about.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slacks {
    /// Slacks w.
    pub w: [f64; ROWS],
    /// Multipliers lambda.
    pub lambda: [f64; ROWS],
    /// Steps of w.
    pub dw: [f64; ROWS],
    /// Steps of lambda.
    pub dlambda: [f64; ROWS],
    /// Defects d of the limits.
    pub defect: [f64; ROWS],
    /// Products c to be taken away.
    pub product: [f64; ROWS],
}

/// Right side of the system without kinematics: rows of forces, rows of active multipliers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Right {
    forces: [f64; 3],
    limits: [f64; ROWS],
}

/// The inverse of the system by blocks; rows and columns of limits that are not active are zero.
#[derive(Clone, Copy, Debug, Default)]
pub struct LocalSystem {
    /// Takes kinematics to forces: T.
    pub stiffness: [[f64; 3]; 3],
    mixed: [[f64; ROWS]; 3],
    limits: [[f64; ROWS]; ROWS],
    active: [bool; ROWS],
}

impl LocalSystem {
    /// Sets up and inverts the system at slacks w and multipliers lambda.
    pub fn set<const F: usize, const Q: usize>(&mut self, local: &Local, slacks: &Slacks) {
        let (w, lambda) = (&slacks.w, &slacks.lambda);
        *self = Self::default();
        let mut any = false;
        for q in 0..Q {
            self.active[q] = lambda[q] > w[q];
            any |= self.active[q];
        }
        if !any && F == 2 {
            self.stiffness = inverse_of_two::<Q>(local, w, lambda);
            return;
        }
        let mut m = [[0.0; SIZE]; SIZE];
        for f in 0..F {
            m[f][f] = local.compliance[f];
        }
        // Limit by unknown.
        let mut limit = [0; SIZE];
        let mut n = F;
        for q in 0..Q {
            let a = &local.limits[q];
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
    pub fn right<const F: usize, const Q: usize>(
        &self,
        local: &Local,
        stationarity: &[f64; 3],
        slacks: &Slacks,
    ) -> Right {
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
                    right.forces[f] -= local.limits[q][f] * constant;
                }
            }
        }
        right
    }

    /// Steps of the forces without kinematics.
    #[inline]
    #[must_use]
    pub fn forces<const F: usize, const Q: usize>(&self, right: &Right) -> [f64; 3] {
        let mut ds = [0.0; 3];
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
    pub fn solve<const F: usize, const Q: usize>(
        &self,
        local: &Local,
        e: &[f64; 3],
        right: &Right,
        slacks: &mut Slacks,
    ) -> [f64; 3] {
        let mut right = *right;
        for f in 0..F {
            right.forces[f] += e[f];
        }
        let ds = self.forces::<F, Q>(&right);
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
                    step -= local.limits[q][f] * ds[f];
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
fn inverse_of_two<const Q: usize>(
    local: &Local,
    w: &[f64; ROWS],
    lambda: &[f64; ROWS],
) -> [[f64; 3]; 3] {
    let [c0, c1, _] = local.compliance;
    let (mut k00, mut k01, mut k11, mut determinant) = (c0, 0.0, c1, c0 * c1);
    let mut theta = [0.0; Q];
    for q in 0..Q {
        theta[q] = lambda[q] / w[q];
        let a = &local.limits[q];
        k00 += theta[q] * a[0] * a[0];
        k01 += theta[q] * a[0] * a[1];
        k11 += theta[q] * a[1] * a[1];
        determinant += theta[q] * (c0 * a[1] * a[1] + c1 * a[0] * a[0]);
        for p in 0..q {
            let b = &local.limits[p];
            let area = a[0] * b[1] - a[1] * b[0];
            determinant += theta[q] * theta[p] * area * area;
        }
    }
    let d = 1.0 / determinant;
    [[k11 * d, -k01 * d, 0.0], [-k01 * d, k00 * d, 0.0], [0.0; 3]]
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
