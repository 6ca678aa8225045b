//! The fraction of an increment that meets an accuracy.

use clastic_components::step_control::{StepControl, Whole};

/// The next increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its fraction of a whole increment.
    pub fraction: f64,
    /// Whether it and the next one of the same fraction are solved in one as well.
    pub is_checked: bool,
}

/// Number of whole increments from one estimate to the next where the stage asks for smaller
/// increments than the accuracy. The estimate then costs half as much as the increments.
const SAMPLE: u32 = 4;
/// Maximum ratio of the fraction after an estimate to that of its increments, and of the latter to
/// the former.
const GROWTH: f64 = 2.0;
const SHRINKAGE: f64 = 8.0;
/// Weight of the last estimate in the mean.
const WEIGHT: f64 = 0.5;

/// The next increment, if this part of the whole increment is left. Fractions are at least
/// `finest`.
pub fn part(control: &StepControl, left: f64, finest: f64) -> Part {
    if control.step >= 1.0 && control.unchecked < SAMPLE {
        return Part { fraction: left, is_checked: false };
    }
    // Pairs of equal increments end where the whole increment ends.
    let pairs = (left / (2.0 * control.step.max(finest)) - 1e-9).ceil().max(1.0);
    Part { fraction: left / (2.0 * pairs), is_checked: true }
}

/// Takes the end of two increments of a fraction, which were solved in one as `whole`.
///
/// The error of the stress is proportional to the increment, so that the difference between one
/// solve and two is the error of the two.
pub fn see(control: &mut StepControl, whole: &Whole, moment: [f64; 4], fraction: f64) {
    let norm = norm(moment).max(f64::MIN_POSITIVE);
    let error = [0, 1, 2, 3].map(|k| (whole.moment[k] - moment[k]) / norm / fraction);
    let mean = match control.error {
        Some(before) => [0, 1, 2, 3].map(|k| before[k] + WEIGHT * (error[k] - before[k])),
        None => error,
    };
    control.error = Some(mean);
    let wanted = control.accuracy / self::norm(mean).max(f64::MIN_POSITIVE);
    control.step = wanted.clamp(fraction / SHRINKAGE, fraction * GROWTH);
    control.unchecked = 0;
}

fn norm(tensor: [f64; 4]) -> f64 {
    tensor.iter().map(|t| t * t).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINEST: f64 = 1.0 / 64.0;

    /// y' = 1 - y from y = 0 over a stage of whole increments of length h. A solve gives the value
    /// with an error that is proportional to its increment, and no later one inherits it: the state
    /// of the next is exact. Returns the maximum error over the value, solves and increments.
    fn approach(accuracy: f64, h: f64, increments: u32) -> (f64, u32, u32) {
        let exact = |done: f64| 1.0 - (-(done + 1.0) * h).exp();
        let solve = |done: f64, fraction: f64| {
            let end = exact(done + fraction);
            [end + 0.2 * fraction * h, 0.0, 0.0, 0.0]
        };
        let mut control = StepControl::new(accuracy);
        let (mut done, mut solves, mut rows, mut worst) = (0.0_f64, 0, 0, 0.0_f64);
        while done < f64::from(increments) {
            let mut take = |done: &mut f64, fraction: f64| {
                let found = solve(*done, fraction);
                *done += fraction;
                solves += 1;
                rows += 1;
                // Before the first estimate no error is known.
                if control.error.is_some() {
                    worst = worst.max((found[0] / exact(*done) - 1.0).abs());
                }
                found
            };
            let Part { fraction, is_checked } = part(&control, 1.0 - done.fract(), 1e-4);
            if !is_checked {
                take(&mut done, fraction);
                control.unchecked += 1;
                continue;
            }
            let whole = Whole { end: done + 2.0 * fraction, moment: solve(done, 2.0 * fraction) };
            take(&mut done, fraction);
            let moment = take(&mut done, fraction);
            solves += 1;
            see(&mut control, &whole, moment, fraction);
            assert!((whole.end - done).abs() < 1e-12);
            if (done - done.round()).abs() < 1e-9 {
                done = done.round();
            }
        }
        assert_eq!(done, f64::from(increments));
        (worst, solves, rows)
    }

    #[test]
    fn the_error_follows_the_accuracy() {
        let mut last = f64::INFINITY;
        // A smaller accuracy takes more than one estimate: fractions shrink by SHRINKAGE at most.
        for accuracy in [3e-2, 1e-2, 3e-3] {
            let (worst, ..) = approach(accuracy, 0.3, 20);
            assert!(worst <= 1.1 * accuracy && worst > 0.1 * accuracy, "{accuracy}: {worst}");
            assert!(worst < last);
            last = worst;
        }
    }

    #[test]
    fn increments_that_are_small_enough_cost_half_as_much_again() {
        let (_, solves, rows) = approach(0.5, 0.1, 400);
        assert!(rows < 510 && solves < 610, "{rows} rows, {solves} solves");
    }

    #[test]
    fn pairs_fill_what_is_left() {
        let mut control = StepControl::new(0.01);
        for (step, left, fraction) in
            [(0.3, 1.0, 0.25), (0.5, 1.0, 0.5), (0.4, 0.5, 0.25), (1e-9, 1.0, FINEST)]
        {
            control.step = step;
            let part = part(&control, left, FINEST);
            assert!(part.is_checked && (part.fraction - fraction).abs() < 1e-15, "{part:?}");
        }
        control.step = 1.5;
        assert_eq!(part(&control, 1.0, FINEST), Part { fraction: 1.0, is_checked: false });
        control.unchecked = SAMPLE;
        assert_eq!(part(&control, 1.0, FINEST), Part { fraction: 0.5, is_checked: true });
    }
}
