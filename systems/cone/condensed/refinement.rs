//! Iterative refinement of the solution of a condensed system: round-off of the factor must not
//! become an error of the step.

use super::images::Images;
use super::interior::max_magnitude;

/// Maximum number of refinements of a linear solve.
const MAX_REFINEMENTS: usize = 8;

/// Refines a solution until its defect is at most `enough` or a refinement does not halve it. `set` sets
/// the defect of a solution, in the rows of bodies and images; `solve` solves with the factor.
pub fn refine(
    images: &Images,
    bodies: usize,
    enough: f64,
    x: &mut [[f64; 3]],
    defect: &mut [[f64; 3]],
    mut set: impl FnMut(&[[f64; 3]], &mut [[f64; 3]]),
    mut solve: impl FnMut(&mut [[f64; 3]]),
) {
    let mut last = f64::INFINITY;
    for _ in 0..MAX_REFINEMENTS {
        set(x, defect);
        images.fold(defect);
        let now = max_magnitude(&defect[..bodies]);
        if now <= enough || !(now <= 0.5 * last) {
            return;
        }
        last = now;
        solve(&mut defect[..bodies]);
        images.spread(defect);
        for (x, d) in x.iter_mut().zip(&*defect) {
            for k in 0..3 {
                x[k] += d[k];
            }
        }
    }
}
