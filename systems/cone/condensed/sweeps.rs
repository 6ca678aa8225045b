//! Sweeps over the contacts: a start for the interior point, near the forces of the last increment.
//!
//! Where every degree of freedom has a weight the displacements follow from the forces,
//! `u = M^-1 (f - G s)`, and the program is one of the forces alone:
//!
//! ```text
//! min J(s) = 1/2 u'M u + 1/2 s'C s + l's   over   p >= 0, |q| <= mu p, |tau| <= m p
//! ```
//!
//! A sweep takes contact after contact to its minimum in the metric of its own diagonal D, there
//! and back (projected symmetric Gauss-Seidel), and sweeps are accelerated (Nesterov 1983), with a
//! restart where J rises (O'Donoghue and Candes 2015).

use super::scaled::{Kind, Local, Scaled, add_forces, kinematics};
use super::settings::WarmSettings;

/// Smallest diagonal of a force, in units of displacement over force.
const MIN_DIAGONAL: f64 = 1e-12;

/// A contact without strength, with `F` forces: p, q and, where any contact rolls, tau.
struct Contact<const F: usize> {
    bodies: [u32; 2],
    rows: [[[f64; F]; 3]; 2],
    compliance: [f64; F],
    linear: [f64; F],
    /// D: closing of the contact per unit of each force.
    diagonal: [f64; F],
    /// 1/D.
    stiffness: [f64; F],
    /// Forces allowed by a unit of p: 1, mu and m; 0 where there is no such force.
    slopes: [f64; F],
}

/// Whether sweeps can find the forces: all interactions are contacts without strength between
/// bodies with weights.
#[must_use]
pub fn applies(program: &Scaled) -> bool {
    let without_strength = |right: &[f64]| right.iter().all(|x| *x == 0.0);
    program.is_damped()
        && program.locals.iter().all(|l| l.kind != Kind::Bond && without_strength(&l.right))
}

/// The forces after the sweeps from `start`, and the displacements that balance them.
#[must_use]
pub fn sweep(
    program: &Scaled,
    start: &[[f64; 3]],
    settings: &WarmSettings,
) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    if program.locals.iter().any(|l| l.has[2]) {
        accelerated::<3>(program, start, settings)
    } else {
        accelerated::<2>(program, start, settings)
    }
}

/// Sets `u` to the displacements that balance the forces.
fn displacements<const F: usize>(
    program: &Scaled,
    contacts: &[Contact<F>],
    s: &[[f64; F]],
    u: &mut [[f64; 3]],
) {
    u.clone_from_slice(&program.right);
    for (c, s) in contacts.iter().zip(s).filter(|(_, s)| s[0] != 0.0) {
        add_forces(c.bodies, &c.rows, s, -1.0, u);
    }
    for (i, u) in u.iter_mut().enumerate() {
        for k in 0..3 {
            let (free, known) = (program.free[i][k], program.known[i][k]);
            u[k] = if free { u[k] / program.weight[i][k] } else { known };
        }
    }
}

fn accelerated<const F: usize>(
    program: &Scaled,
    start: &[[f64; 3]],
    settings: &WarmSettings,
) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let inverse: Vec<[f64; 3]> = (0..program.free.len())
        .map(|i| {
            [0, 1, 2].map(|k| if program.free[i][k] { 1.0 / program.weight[i][k] } else { 0.0 })
        })
        .collect();
    let contacts: Vec<Contact<F>> =
        program.locals.iter().map(|l| Contact::new(l, &inverse)).collect();
    let mut s: Vec<[f64; F]> = contacts.iter().zip(start).map(|(c, s)| c.within(s)).collect();
    let mut u = vec![[0.0; 3]; program.free.len()];
    displacements(program, &contacts, &s, &mut u);
    let (mut y, mut v) = (s.clone(), u.clone());
    let (mut t, mut last) = (1.0_f64, f64::INFINITY);
    let mut visited: Vec<usize> = Vec::new();
    for k in 0..settings.sweeps {
        // Contacts without force are visited in every few sweeps only.
        if k.is_multiple_of(settings.full_sweep_every) {
            visited.clear();
            visited.extend(0..contacts.len());
        } else if k % settings.full_sweep_every == 1 {
            visited.retain(|k| y[*k][0] != 0.0 || s[*k][0] != 0.0);
        }
        for k in visited.iter().copied().chain(visited.iter().rev().copied()) {
            contacts[k].relax(&inverse, &mut y[k], &mut v);
        }
        let now = energy(program, &contacts, &y, &v);
        if now > last {
            // Back to the last point, without momentum.
            (t, last) = (1.0, f64::INFINITY);
            y.clone_from(&s);
            v.clone_from(&u);
            continue;
        }
        last = now;
        let next = 0.5 * (1.0 + (1.0 + 4.0 * t * t).sqrt());
        let momentum = (t - 1.0) / next;
        t = next;
        extrapolate(&mut y, &mut s, momentum);
        extrapolate(&mut v, &mut u, momentum);
    }
    // Recomputed from the forces: the updates have accumulated round-off.
    displacements(program, &contacts, &s, &mut u);
    let forces = s.iter().map(|s| std::array::from_fn(|f| s.get(f).copied().unwrap_or(0.0)));
    (forces.collect(), u)
}

/// Extrapolates the new points along their change from the last ones, and makes them the last
/// points.
fn extrapolate<const N: usize>(new: &mut [[f64; N]], last: &mut [[f64; N]], momentum: f64) {
    for (new, last) in new.iter_mut().zip(last) {
        let at = *new;
        for k in 0..N {
            new[k] += momentum * (at[k] - last[k]);
        }
        *last = at;
    }
}

/// J of forces and the displacements that balance them.
fn energy<const F: usize>(
    program: &Scaled,
    contacts: &[Contact<F>],
    s: &[[f64; F]],
    u: &[[f64; 3]],
) -> f64 {
    let mut sum = 0.0;
    for (i, u) in u.iter().enumerate() {
        for k in (0..3).filter(|k| program.free[i][*k]) {
            sum += 0.5 * program.weight[i][k] * u[k] * u[k];
        }
    }
    for (c, s) in contacts.iter().zip(s) {
        for f in 0..F {
            sum += (c.linear[f] + 0.5 * c.compliance[f] * s[f]) * s[f];
        }
    }
    sum
}

impl<const F: usize> Contact<F> {
    fn new(local: &Local, inverse: &[[f64; 3]]) -> Self {
        let rows = local.rows.map(|rows| rows.map(|row| std::array::from_fn(|f| row[f])));
        let compliance: [f64; F] = std::array::from_fn(|f| local.compliance[f]);
        let mut diagonal = compliance;
        for (rows, body) in local.rows.iter().zip(local.bodies) {
            for (row, inverse) in rows.iter().zip(inverse[body]) {
                for f in 0..F {
                    diagonal[f] += row[f] * row[f] * inverse;
                }
            }
        }
        let diagonal = diagonal.map(|d| d.max(MIN_DIAGONAL));
        // The slopes of limits stand in their rows, shear before rolling.
        let shear = if local.has[1] { -local.limits[0][0] } else { 0.0 };
        let rolling =
            if local.has[2] { -local.limits[2 * usize::from(local.has[1])][0] } else { 0.0 };
        let slopes = [1.0, shear, rolling];
        Self {
            bodies: local.bodies.map(|i| i as u32),
            rows,
            compliance,
            linear: std::array::from_fn(|f| local.linear[f]),
            diagonal,
            stiffness: diagonal.map(|d| 1.0 / d),
            slopes: std::array::from_fn(|f| slopes[f]),
        }
    }

    /// Forces brought within the limits, the normal force first.
    fn within(&self, s: &[f64; 3]) -> [f64; F] {
        let p = s[0].max(0.0);
        std::array::from_fn(|f| if f == 0 { p } else { clamped(s[f], self.slopes[f] * p) })
    }

    /// Takes the contact to its minimum, and its bodies along.
    #[inline]
    fn relax(&self, inverse: &[[f64; 3]], s: &mut [f64; F], u: &mut [[f64; 3]]) {
        let e = kinematics(self.bodies, &self.rows, u);
        let mut trial = [0.0; F];
        for f in 0..F {
            let left = e[f] - self.linear[f] - self.compliance[f] * s[f];
            trial[f] = s[f] + self.stiffness[f] * left;
        }
        let new = self.project(&trial);
        let mut change = [0.0; F];
        let mut any = false;
        for f in 0..F {
            change[f] = new[f] - s[f];
            any |= change[f] != 0.0;
        }
        if !any {
            return;
        }
        *s = new;
        for (rows, body) in self.rows.iter().zip(self.bodies) {
            let (u, inverse) = (&mut u[body as usize], &inverse[body as usize]);
            for k in 0..3 {
                let mut sum = 0.0;
                for f in 0..F {
                    sum += rows[k][f] * change[f];
                }
                u[k] -= inverse[k] * sum;
            }
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
            bodies: [0, 1],
            rows: [[[0.0; 3]; 3]; 2],
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
