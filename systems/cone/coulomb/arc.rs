//! The path of the perturbed system, followed by its arc length.
//!
//! With R the complementarity system and z_0 a point with equal products, the path is `R(z) = tau
//! R(z_0)` from tau = 1 to tau = 0, which is a solution. Where a few grains slide in a mechanism of
//! their own the path turns back, and a method whose parameter only falls gets stuck. Along a
//! regular path the sign of `dtau` times that of the determinant of the derivative does not change
//! (Keller 1977; Allgower and Georg 1990): tau falls while the determinant has its first sign, and
//! rises while it has the other.

use super::Trial;
use super::interior::boundary;
use super::settings::ArcSettings;
use super::system::{System, Vector};
use crate::residuals::max_or_nan;

/// tau at which the end of the path is reached to round-off.
const MIN_TAU: f64 = 1e-14;

/// The start of the last predictor.
struct Saved {
    z: Vector,
    tangent: Vector,
    tau: f64,
    direction: f64,
    length: f64,
}

/// Follows the path from a point until the trial is solved, for at most `max` factorisations.
/// Returns the last point, `None` if the path is lost.
pub fn follow(
    system: &mut System,
    mut z: Vector,
    settings: &ArcSettings,
    max: u32,
    trial: &mut Trial,
) -> Option<Vector> {
    system.regularisation = settings.regularisation;
    let first = system.residual(&z);
    let mut by_tau = Vector::zeros(&z);
    by_tau.add(-1.0, &first);
    let mut tau = 1.0_f64;
    let mut saved: Option<Saved> = None;
    let (mut sign, mut bad, mut grow, mut before) = (None, 0, 1.0_f64, f64::INFINITY);
    for _ in 0..max {
        if !system.factorise(&z) {
            return None;
        }
        // H = R(z) - tau R(z_0); its derivative by tau does not change.
        let mut h = system.residual(&z);
        h.add(-tau, &first);
        let tangent = system.solve(&z, &by_tau);
        let mut correction = system.solve(&z, &h);
        // The correction is made normal to the tangent, in the metric of relative changes of
        // slacks, multipliers and tau.
        let (along, square) = products(system, &z, &tangent, &correction);
        let back = -along / (square + 1.0 / (tau * tau));
        correction.add(back, &tangent);
        let off = largest_change(system, &z, &correction) + (back / tau).abs();
        let near = off < settings.close;
        bad = if near { 0 } else { bad + 1 };
        let lost = bad > 1 && off > settings.divergence * before;
        if !off.is_finite() || lost {
            let Some(last) = &mut saved else { return None };
            last.length *= settings.shortening;
            z = last.z.clone();
            z.add(last.length, &last.tangent);
            tau = last.tau + last.length * last.direction;
            (bad, grow, before) = (0, settings.shortening, f64::INFINITY);
            continue;
        }
        before = off;
        let mut room = boundary(system, &z, &correction);
        if back < 0.0 {
            room = room.min(-tau / back);
        }
        let length = (settings.reach * room).min(1.0);
        z.add(length, &correction);
        tau += length * back;
        if near {
            let now = system.matrix.sign();
            let direction = if *sign.get_or_insert(now) == now { -1.0 } else { 1.0 };
            let mut ahead = Vector::zeros(&z);
            ahead.add(direction, &tangent);
            // A predictor changes tau by its length.
            let length = settings.reach * grow * boundary(system, &z, &ahead).min(tau);
            if off < 0.5 * settings.close {
                grow = 1.0;
            }
            let last = Saved { z: z.clone(), tangent: ahead, tau, direction, length };
            z.add(length, &last.tangent);
            tau += length * direction;
            saved = Some(last);
        }
        if trial.consider(system, &z) {
            return Some(z);
        }
        if !(tau >= MIN_TAU) {
            return None;
        }
    }
    None
}

/// Scalar product of the relative changes of slacks and multipliers in a tangent and a step, and
/// the square of those in the tangent.
fn products(system: &System, z: &Vector, tangent: &Vector, step: &Vector) -> (f64, f64) {
    let (mut along, mut square) = (0.0, 0.0);
    let both = system.along(z, tangent).flatten().zip(system.along(z, step).flatten());
    for ((x, t), (_, c)) in both {
        along += t * c / (x * x);
        square += t * t / (x * x);
    }
    (along, square)
}

/// Maximum relative change of a slack or multiplier; NaN if any is NaN.
fn largest_change(system: &System, z: &Vector, step: &Vector) -> f64 {
    let changes = system.along(z, step).flatten().map(|(x, d)| (d / x).abs());
    changes.fold(0.0, max_or_nan)
}
