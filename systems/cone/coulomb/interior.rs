//! The interior-point iteration on the complementarity system, with the predictor and corrector of
//! Mehrotra (1992).

use super::Trial;
use super::settings::CoulombInteriorSettings;
use super::system::{System, Vector};
use crate::condensed::interior::part_of_way;

/// Iterates from a point until the trial is solved, for at most `max` factorisations.
pub(crate) fn iterate(
    system: &mut System,
    mut z: Vector,
    settings: &CoulombInteriorSettings,
    max: u32,
    trial: &mut Trial,
) {
    system.regularisation = settings.regularisation;
    let mut last = 1.0;
    let mut short = 0;
    let mut residuals = Vec::new();
    for iteration in 0..=max {
        let solved = trial.consider(system, &z);
        // The first step leads from the start to the path and is no measure of progress.
        let sharpens = if iteration < 2 { !trial.is_sharp() } else { trial.sharpens() };
        if solved && !sharpens {
            return;
        }
        residuals.push(if iteration == 0 { f64::INFINITY } else { trial.worst });
        let earlier = (iteration as usize).checked_sub(settings.patience);
        let stalls = earlier.is_some_and(|earlier| {
            residuals[iteration as usize] > trial.settings.progress * residuals[earlier]
        });
        let r = system.residual(&z);
        let mu = sum_of_products(system, &z, &z, 0.0) / system.limits;
        short = if last < settings.short_step { short + 1 } else { 0 };
        let ends =
            !mu.is_finite() || iteration == max || short >= settings.max_short_steps || stalls;
        if ends || !system.factorise(&z) {
            return;
        }
        let predictor = system.solve(&z, &r);
        let length = boundary(system, &z, &predictor).min(1.0);
        let after = sum_of_products(system, &z, &predictor, length) / system.limits;
        // After a short step the iteration goes back to the path first.
        let min = if last < settings.centring_step { settings.min_centring } else { 0.0 };
        let target = (after.max(0.0) / mu).powi(3).clamp(min, 1.0) * mu;
        let mut aimed = r;
        for ((r, d), cell) in aimed.cells.iter_mut().zip(&predictor.cells).zip(&system.cells) {
            for q in cell.each_limit() {
                r.lambda[q] += d.w[q] * d.lambda[q] - target;
            }
        }
        let step = system.solve(&z, &aimed);
        let room = boundary(system, &z, &step);
        if room.is_nan() {
            return;
        }
        last = room.min(1.0);
        z.add((room * part_of_way(mu)).min(1.0), &step);
    }
}

/// The length of a step at which the first slack or multiplier vanishes; NaN if a number of the
/// step is NaN.
pub fn boundary(system: &System, z: &Vector, step: &Vector) -> f64 {
    let mut length = f64::INFINITY;
    for (x, d) in system.along(z, step).flatten() {
        if d.is_nan() {
            return f64::NAN;
        }
        if d < 0.0 && x + length * d < 0.0 {
            length = -x / d;
        }
    }
    length
}

fn sum_of_products(system: &System, z: &Vector, step: &Vector, length: f64) -> f64 {
    let mut sum = 0.0;
    for [(w, dw), (l, dl)] in system.along(z, step) {
        sum += (w + length * dw) * (l + length * dl);
    }
    sum
}
