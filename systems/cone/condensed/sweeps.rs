//! Sweeps over the contacts, from the forces of the last increment: a solution where they converge
//! fast, elsewhere a start for the interior point.
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
//! step (O'Donoghue and Candes 2015). Forty of them cost as much as half a factorisation of Coulomb's
//! law, of which a time step takes five and more.

use super::scaled::{Arms, Local, Scaled, first, forces_in_units};
use crate::program::{ConeProgram, ConeSolution, Interaction, SlidingLaw, SolveStatus};
use crate::residuals::settle;

/// Number of sweeps in a round, after which the residual is computed.
/// 40: in the collapse of 5000 disks 20 leave two more of eleven factorisations an increment; 80
/// save less than one and cost more time than that.
const ROUND: usize = 40;

/// Number of rounds in which the residual has to halve under Coulomb's law. It falls and rises from
/// round to round.
/// 5: 42 time steps of 2000 disks take 1.1 times as long to 1e-3 with 3 and 10, and 1.3 times to 1e-4
/// with 10.
const PATIENCE: u32 = 5;

/// Maximum momentum after the first round, as a share of the last step.
/// 0.85: with the momentum of Nesterov, which tends to 1, a time step of 2000 rigid disks under
/// Coulomb's law stays at a residual of 2e-2 and more; 0.7 takes twice as many sweeps.
const MAX_MOMENTUM: f64 = 0.85;

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

/// Whether sweeps can find the forces: every degree of freedom has a weight, and every interaction is
/// a contact without strength and without an image.
pub fn applies(program: &ConeProgram) -> bool {
    let is_contact = |c: &Interaction| !c.limits.has_strength() && c.limits.moment == 0.0;
    program.cell.is_none() && program.is_damped() && program.interactions.iter().all(is_contact)
}

/// The solution of a program to which sweeps apply after sweeps from its last forces, with
/// displacements that balance its forces; stalled if its residual exceeds the tolerance.
pub fn sweep(program: &ConeProgram, law: SlidingLaw, tolerance: f64) -> ConeSolution {
    let scaled = Scaled::natural(program);
    if scaled.locals.iter().any(|l| l.has[2]) {
        Sweeps::<3>::new(program, &scaled, law).converge(program, tolerance)
    } else {
        Sweeps::<2>::new(program, &scaled, law).converge(program, tolerance)
    }
}

/// Forces and displacements between two sweeps, in units of the scales, displacements times the
/// roots of the weights.
struct Sweeps<const F: usize> {
    law: SlidingLaw,
    contacts: Vec<Contact<F>>,
    /// The point after the last sweep.
    s: Vec<[f64; F]>,
    u: Vec<[f64; 3]>,
    /// The same with momentum, from where the next sweep starts.
    y: Vec<[f64; F]>,
    v: Vec<[f64; 3]>,
    /// Nesterov's number, from which the momentum follows.
    t: f64,
}

impl<const F: usize> Sweeps<F> {
    fn new(program: &ConeProgram, scaled: &Scaled, law: SlidingLaw) -> Self {
        let mut root = vec![[0.0; 3]; scaled.free.len()];
        for (i, k) in scaled.all_free() {
            root[i][k] = scaled.weight[i][k].sqrt().recip();
        }
        let contacts: Vec<Contact<F>> =
            scaled.locals.iter().map(|l| Contact::new(l, &root)).collect();
        let loads = root.iter().zip(&scaled.right);
        let mut u: Vec<_> = loads.map(|(root, f)| [0, 1, 2].map(|k| root[k] * f[k])).collect();
        let last = forces_in_units(program, &program.last_forces);
        let s: Vec<_> = contacts.iter().zip(&last).map(|(c, s)| c.within(s)).collect();
        for (c, s) in contacts.iter().zip(&s) {
            c.arms.add_forces(s, -1.0, &mut u);
        }
        Self { law, contacts, y: s.clone(), v: u.clone(), s, u, t: 1.0 }
    }

    /// The point after one round under the associated law. Under Coulomb's law rounds go on until the
    /// residual is within the tolerance or [`PATIENCE`] of them have not halved it.
    fn converge(mut self, program: &ConeProgram, tolerance: f64) -> ConeSolution {
        if self.law == SlidingLaw::Associated {
            self.round(1.0);
            return self.solution(program, tolerance);
        }
        let mut last = self.solution(program, tolerance);
        let (mut goal, mut left) = (f64::INFINITY, PATIENCE);
        let mut max_momentum = 1.0;
        while last.status != SolveStatus::Solved && left > 0 {
            self.round(max_momentum);
            max_momentum = MAX_MOMENTUM;
            last = self.solution(program, tolerance);
            left -= 1;
            if last.residuals.worst() <= goal {
                (goal, left) = (0.5 * last.residuals.worst(), PATIENCE);
            }
        }
        last
    }

    fn round(&mut self, max_momentum: f64) {
        let Self { law, contacts, s, u, y, v, t } = self;
        let mut from = Vec::new();
        for _ in 0..ROUND {
            from.clone_from(v);
            for (c, y) in contacts.iter().zip(y.iter_mut()) {
                c.relax(*law, y, v);
            }
            // A contact without force is visited on the way there only.
            for (c, y) in contacts.iter().zip(y.iter_mut()).rev().filter(|(_, y)| y[0] != 0.0) {
                c.relax(*law, y, v);
            }
            let next = 0.5 * (1.0 + (1.0 + 4.0 * *t * *t).sqrt());
            let momentum = ((*t - 1.0) / next).min(max_momentum);
            *t = next;
            // Work of the momentum against the last step, and of the sweep.
            let mut against = 0.0;
            for ((v, u), from) in v.iter_mut().zip(u.iter_mut()).zip(&from) {
                let at = *v;
                for k in 0..3 {
                    against += (from[k] - at[k]) * (at[k] - u[k]);
                    v[k] += momentum * (at[k] - u[k]);
                }
                *u = at;
            }
            for (y, s) in y.iter_mut().zip(s.iter_mut()) {
                let at = *y;
                for f in 0..F {
                    y[f] += momentum * (at[f] - s[f]);
                }
                *s = at;
            }
            if against > 0.0 {
                *t = 1.0;
                y.clone_from(s);
                v.clone_from(u);
            }
        }
    }

    /// The point in SI units. Displacements follow from the forces: the updates of sweeps accumulate
    /// round-off.
    fn solution(&self, program: &ConeProgram, tolerance: f64) -> ConeSolution {
        let (_, df) = program.scales.units();
        let in_si =
            |s: &[f64; F]| std::array::from_fn(|f| s.get(f).copied().unwrap_or(0.0) * df[f]);
        let mut out = ConeSolution {
            law: self.law,
            forces: self.s.iter().map(in_si).collect(),
            displacements: program.imposed(),
            message: "sweeps".to_owned(),
            ..ConeSolution::default()
        };
        settle(program, &mut out, tolerance);
        out
    }
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
        let trial: [f64; F] = std::array::from_fn(|f| {
            s[f] + self.stiffness[f] * (e[f] - self.linear[f] - self.compliance[f] * s[f])
        });
        let new = match law {
            SlidingLaw::Coulomb => self.within(&trial),
            SlidingLaw::Associated => self.project(&trial),
        };
        let change: [f64; F] = std::array::from_fn(|f| new[f] - s[f]);
        if change != [0.0; F] {
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
