//! Sweeps over the contacts: a start for the interior point, near the forces of the last increment.
//!
//! Where every degree of freedom has a weight the displacements follow from the forces,
//! `u = M^-1 (f - G s)`, and forces are left as the only unknowns. Under the associated law they
//! minimise
//!
//! ```text
//! J(s) = 1/2 u'M u + 1/2 s'C s + l's   over   p >= 0, |q| <= mu p, |tau| <= m p
//! ```
//!
//! and under Coulomb's law p minimises J at given q and tau, while q and tau minimise it at the
//! limits of that p. A sweep takes contact after contact to its own solution in the metric of its
//! diagonal D, there and back (projected symmetric Gauss-Seidel; Jourdan, Alart and Jean 1998).
//! Sweeps are accelerated (Nesterov 1983), with a restart where a sweep goes back against the last
//! step (O'Donoghue and Candes 2015).

use super::scaled::{Arms, Local, Scaled, first};
use super::warm::last_forces;
use crate::program::{ConeProgram, Interaction, SlidingLaw};

/// Number of sweeps.
///
/// 40: in the collapse of 5000 disks 20 leave two more of eleven factorisations an increment; 80
/// save less than one and cost more time than that.
const SWEEPS: usize = 40;

/// Smallest diagonal of a force, in units of displacement over force.
const MIN_DIAGONAL: f64 = 1e-12;

/// A contact without strength, with `F` forces: p, q and, where any contact rolls, tau. Its rows
/// are over the roots of the weights of the bodies, so that a sweep needs no weights.
struct Contact<const F: usize> {
    arms: Arms<F>,
    compliance: [f64; F],
    linear: [f64; F],
    /// D: closing of the contact per unit of each force.
    diagonal: [f64; F],
    /// 1/D.
    stiffness: [f64; F],
    /// Forces allowed by a unit of p: 1, mu and m; 0 where there is no such force.
    slopes: [f64; F],
}

/// Whether sweeps can find the forces: all interactions are contacts without strength and without
/// images between bodies with weights.
#[must_use]
pub fn applies(program: &ConeProgram) -> bool {
    let is_contact = |c: &Interaction| !c.limits.has_strength() && c.limits.moment == 0.0;
    program.cell.is_none() && program.is_damped() && program.interactions.iter().all(is_contact)
}

/// The forces after sweeps from those of the last increment, and the displacements that balance them,
/// in units of the scales.
#[must_use]
pub fn sweep(program: &ConeProgram, law: SlidingLaw) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let scaled = Scaled::natural(program);
    let start = last_forces(program);
    if scaled.locals.iter().any(|l| l.has[2]) {
        accelerated::<3>(&scaled, law, &start)
    } else {
        accelerated::<2>(&scaled, law, &start)
    }
}

fn accelerated<const F: usize>(
    program: &Scaled,
    law: SlidingLaw,
    start: &[[f64; 3]],
) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let root: Vec<[f64; 3]> = (0..program.free.len())
        .map(|i| {
            let of = |k: usize| program.weight[i][k].sqrt().recip();
            [0, 1, 2].map(|k| if program.free[i][k] { of(k) } else { 0.0 })
        })
        .collect();
    let contacts: Vec<Contact<F>> = program.locals.iter().map(|l| Contact::new(l, &root)).collect();
    let loads: Vec<[f64; 3]> = root
        .iter()
        .zip(&program.right)
        .map(|(root, f)| [0, 1, 2].map(|k| root[k] * f[k]))
        .collect();
    // Displacements times the roots of the weights.
    let balance = |s: &[[f64; F]], u: &mut [[f64; 3]]| {
        u.clone_from_slice(&loads);
        for (c, s) in contacts.iter().zip(s).filter(|(_, s)| s[0] != 0.0) {
            c.arms.add_forces(s, -1.0, u);
        }
    };
    let padded = |s: &[[f64; F]]| -> Vec<[f64; 3]> {
        s.iter().map(|s| std::array::from_fn(|f| s.get(f).copied().unwrap_or(0.0))).collect()
    };
    let mut s: Vec<[f64; F]> = contacts.iter().zip(start).map(|(c, s)| c.within(s)).collect();
    let mut u = vec![[0.0; 3]; program.free.len()];
    balance(&s, &mut u);
    let (mut y, mut v) = (s.clone(), u.clone());
    let mut from = v.clone();
    let mut t = 1.0_f64;
    for _ in 0..SWEEPS {
        from.clone_from(&v);
        for (c, y) in contacts.iter().zip(&mut y) {
            c.relax(law, y, &mut v);
        }
        // A contact without force is visited on the way there only.
        for (c, y) in contacts.iter().zip(&mut y).rev().filter(|(_, y)| y[0] != 0.0) {
            c.relax(law, y, &mut v);
        }
        let next = 0.5 * (1.0 + (1.0 + 4.0 * t * t).sqrt());
        let momentum = (t - 1.0) / next;
        t = next;
        // Work of the momentum against the last step, and of the sweep.
        let mut against = 0.0;
        for ((v, u), from) in v.iter_mut().zip(&mut u).zip(&from) {
            let at = *v;
            for k in 0..3 {
                against += (from[k] - at[k]) * (at[k] - u[k]);
                v[k] += momentum * (at[k] - u[k]);
            }
            *u = at;
        }
        for (y, s) in y.iter_mut().zip(&mut s) {
            let at = *y;
            for f in 0..F {
                y[f] += momentum * (at[f] - s[f]);
            }
            *s = at;
        }
        if against > 0.0 {
            t = 1.0;
            y.clone_from(&s);
            v.clone_from(&u);
        }
    }
    // Recomputed from the forces: the updates have accumulated round-off.
    balance(&s, &mut u);
    let displacement = |i: usize, k: usize| {
        if program.free[i][k] { root[i][k] * u[i][k] } else { program.known[i][k] }
    };
    let u = (0..u.len()).map(|i| [0, 1, 2].map(|k| displacement(i, k))).collect();
    (padded(&s), u)
}

impl<const F: usize> Contact<F> {
    fn new(local: &Local, root: &[[f64; 3]]) -> Self {
        let mut arms = Arms::of(local);
        let compliance: [f64; F] = first(&local.compliance);
        let mut diagonal = compliance;
        for (rows, body) in arms.rows.iter_mut().zip(arms.bodies) {
            for (row, root) in rows.iter_mut().zip(root[body as usize]) {
                for f in 0..F {
                    row[f] *= root;
                    diagonal[f] += row[f] * row[f];
                }
            }
        }
        let diagonal = diagonal.map(|d| d.max(MIN_DIAGONAL));
        let [shear, rolling] = local.slopes;
        Self {
            arms,
            compliance,
            linear: first(&local.linear),
            diagonal,
            stiffness: diagonal.map(|d| 1.0 / d),
            slopes: first(&[1.0, shear, rolling]),
        }
    }

    /// Forces brought within the limits, the normal force first: the solution of Coulomb's law in
    /// the metric of D.
    fn within(&self, s: &[f64]) -> [f64; F] {
        let p = s[0].max(0.0);
        std::array::from_fn(|f| if f == 0 { p } else { clamped(s[f], self.slopes[f] * p) })
    }

    /// Takes the contact to its solution, and its bodies along.
    #[inline]
    fn relax(&self, law: SlidingLaw, s: &mut [f64; F], u: &mut [[f64; 3]]) {
        let e = self.arms.kinematics(u);
        let mut trial = [0.0; F];
        for f in 0..F {
            let left = e[f] - self.linear[f] - self.compliance[f] * s[f];
            trial[f] = s[f] + self.stiffness[f] * left;
        }
        let new = match law {
            SlidingLaw::Coulomb => self.within(&trial),
            SlidingLaw::Associated => self.project(&trial),
        };
        let mut change = [0.0; F];
        let mut any = false;
        for f in 0..F {
            change[f] = new[f] - s[f];
            any |= change[f] != 0.0;
        }
        if any {
            *s = new;
            self.arms.add_forces(&change, -1.0, u);
        }
    }

    /// The nearest forces within the limits, in the metric of the diagonal D. With the limits of
    /// forces x active
    ///
    /// ```text
    /// p = (D_p t_p + sum m_x D_x |t_x|) / (D_p + sum m_x^2 D_x),   x = +- m_x p
    /// ```
    ///
    /// and a limit is active where `m_x p < |t_x|`: those of larger `|t_x|/m_x` first.
    #[inline]
    fn project(&self, trial: &[f64; F]) -> [f64; F] {
        let (mut above, mut below) = (self.diagonal[0] * trial[0], self.diagonal[0]);
        let mut p = trial[0];
        // Each pass adds a limit that the last p violates; there are two at most.
        let mut active = [false; F];
        for _ in 1..F {
            let over = |f: usize| self.slopes[f] * p < trial[f].abs() && self.slopes[f] > 0.0;
            let reach = |f: usize| trial[f].abs() / self.slopes[f];
            let next = (1..F)
                .filter(|f| !active[*f] && over(*f))
                .max_by(|a, b| reach(*a).total_cmp(&reach(*b)));
            let Some(f) = next else { break };
            active[f] = true;
            above += self.slopes[f] * self.diagonal[f] * trial[f].abs();
            below += self.slopes[f] * self.slopes[f] * self.diagonal[f];
            p = above / below;
        }
        if p <= 0.0 {
            return [0.0; F];
        }
        std::array::from_fn(|f| if f == 0 { p } else { clamped(trial[f], self.slopes[f] * p) })
    }
}

fn clamped(x: f64, limit: f64) -> f64 {
    x.clamp(-limit, limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The projection fulfils the conditions of the minimum: the difference to the trial is normal
    /// to the cone.
    #[test]
    fn projections_are_the_nearest_forces() {
        let contact = |slopes, diagonal| Contact::<3> {
            arms: Arms { bodies: [0, 1], rows: [[[0.0; 3]; 3]; 2] },
            compliance: [0.0; 3],
            linear: [0.0; 3],
            diagonal,
            stiffness: [0.0; 3],
            slopes,
        };
        let mut state = 7_u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..10_000 {
            let c = contact(
                [1.0, draw() + 0.01, 0.5 * draw() + 0.01],
                [draw() + 0.1, draw() + 0.1, draw() + 0.1],
            );
            let trial = [4.0 * draw() - 2.0, 4.0 * draw() - 2.0, 4.0 * draw() - 2.0];
            let s = c.project(&trial);
            let inside = |s: &[f64; 3]| {
                s[0] >= 0.0 && (1..3).all(|f| s[f].abs() <= c.slopes[f] * s[0] * (1.0 + 1e-12))
            };
            assert!(inside(&s));
            let distance = |s: &[f64; 3]| -> f64 {
                (0..3).map(|f| 0.5 * c.diagonal[f] * (s[f] - trial[f]).powi(2)).sum()
            };
            let best = distance(&s);
            for _ in 0..20 {
                let p = (s[0] + 0.2 * (draw() - 0.5)).max(0.0);
                let other = [
                    p,
                    clamped(s[1] + 0.2 * (draw() - 0.5), c.slopes[1] * p),
                    clamped(s[2] + 0.2 * (draw() - 0.5), c.slopes[2] * p),
                ];
                assert!(distance(&other) >= best - 1e-14, "{trial:?} {s:?} {other:?}");
            }
        }
    }
}
