//! Certificates of collapse.
//!
//! By Farkas' lemma no forces within the limits balance the loads if a mechanism u exists, zero on
//! degrees of freedom with imposed displacements or inertia, with
//!
//! ```text
//! load . u  >  sum_c  sup { (p, q, tau) . (d_n, d_t, d_r) : limits of c }
//! ```
//!
//! The supremum is the dissipation `c A |d_t| + mu_r r f_t |d_r| - p_min lambda_T` where
//! `lambda_T = -d_n - mu |d_t| - mu_r r |d_r|` is not negative, and infinite otherwise. p_min is
//! -f_t, or the apex -c A/mu of the shear limit if that is larger.

use crate::program::{Certificate, ConeProgram};

/// A certificate proves a collapse if its margin is above this and its defect is below.
pub const TOLERANCE: f64 = 1e-6;

/// Computes margin and defect of a mechanism: displacements by body in the bodies' own axes, at any
/// scale. `None` if no body moves, or if the loads do no work.
pub fn certificate(program: &ConeProgram, mechanism: &[[f64; 3]]) -> Option<Certificate> {
    let length = program.scales.length;
    let mut u = vec![[0.0; 3]; mechanism.len()];
    for ((body, u), given) in program.bodies.iter().zip(&mut u).zip(mechanism) {
        // A degree of freedom with inertia takes up any load and does not collapse. A regularised
        // one does too, but regularisation is no part of the problem.
        for (k, _) in body.free().filter(|(_, free)| free.inertia == 0.0) {
            u[k] = given[k];
        }
    }
    let size = |u: &[f64; 3]| u[0].abs().max(u[1].abs()).max(length * u[2].abs());
    let u = over_maximum(&u, size)?;
    let (mut work, mut works, mut moved) = (0.0, 0.0, 0.0);
    for (body, u) in program.bodies.iter().zip(&u) {
        for (k, free) in body.free() {
            work += free.load * u[k];
            works += (free.load * u[k]).abs();
            moved += (free.load * u[k]).abs() * size(u);
        }
    }
    // Mean motion of the bodies on which loads do work: a body without load that moves further must
    // not hide what closes.
    let moved = moved / works;
    let mut dissipation = 0.0;
    let mut defect = 0.0_f64;
    for c in &program.interactions {
        let e = program.kinematics(c, &u);
        let l = &c.limits;
        let slip = if l.has_shear() { e[1].abs() } else { 0.0 };
        let roll = if l.has_rolling() { e[2].abs() } else { 0.0 };
        let opening = -e[0] - l.friction * slip - l.rolling * roll;
        defect = defect.max(-opening);
        dissipation +=
            l.cohesion * slip + l.moment * roll - l.min_normal_force() * opening.max(0.0);
    }
    (work > 0.0).then(|| Certificate {
        mechanism: u,
        margin: (work - dissipation) / work,
        defect: defect / moved,
    })
}

/// The rows over the maximum of their sizes; `None` if it is zero or not finite.
fn over_maximum(rows: &[[f64; 3]], size: impl Fn(&[f64; 3]) -> f64) -> Option<Vec<[f64; 3]>> {
    let maximum = rows.iter().map(size).fold(0.0, f64::max);
    let is_sound = maximum > 0.0 && maximum.is_finite();
    is_sound.then(|| rows.iter().map(|row| row.map(|x| x / maximum)).collect())
}

/// Minimum work per unit of force, over the length scale, that proves rigid bodies to be forced
/// into each other: an overlap above round-off.
const MIN_OVERLAP: f64 = 1e-9;

/// Whether forces prove that rigid bodies are locked, so that no displacements satisfy the
/// constraints.
///
/// They do if they balance each other without any load, lie within the limits without cohesion, act
/// on rigid contacts only, and do work on the overlaps and the imposed motions.
pub fn locks(program: &ConeProgram, forces: &[[f64; 3]]) -> bool {
    let length = program.scales.length;
    let size = |f: &[f64; 3]| f[0].abs().max(f[1].abs()).max(f[2].abs() / length);
    let Some(forces) = over_maximum(forces, size) else { return false };
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    program.add_forces(&forces, &mut rows);
    let known = program.imposed();
    let balanced = program.bodies.iter().zip(&rows).all(|(body, row)| {
        body.free().all(|(k, _)| row[k].abs() <= TOLERANCE * if k < 2 { 1.0 } else { length })
    });
    let (mut work, mut allowed) = (0.0, true);
    for (c, [p, q, tau]) in program.interactions.iter().zip(&forces) {
        let e = program.kinematics(c, &known);
        work += (e[0] - c.offset) * p + e[1] * q + e[2] * tau;
        allowed &= *p >= -TOLERANCE
            && q.abs() <= c.limits.friction * p + TOLERANCE
            && tau.abs() <= c.limits.rolling * p + TOLERANCE * length
            && (c.normal_compliance == 0.0 || p.abs() <= TOLERANCE)
            && (c.tangential_compliance == 0.0 || q.abs() <= TOLERANCE)
            && (c.rolling_compliance == 0.0 || tau.abs() <= TOLERANCE * length);
    }
    balanced && allowed && work > MIN_OVERLAP * length
}

/// Whether a certificate proves the collapse.
pub fn proves(certificate: &Certificate) -> bool {
    certificate.margin > TOLERANCE && certificate.defect < TOLERANCE
}
