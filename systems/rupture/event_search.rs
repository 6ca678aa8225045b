//! Search for the state at which the next bond breaks: pure functions of trials ([`decide`],
//! [`at_constant_load`]).
//!
//! A trial is the solution at a fraction s of the increment with bonds of unlimited strength,
//! together with the overload R_i of each bond. R_i is interpolated linearly between two trials,
//! which is exact if no contact changes in between. The crossing of a bond is the fraction at
//! which R_i = 1. The bond with the first crossing breaks, at `1 - tolerance <= R <= 1`.

use clastic_components::findings::EventTrial;

/// Maximum number of trials of a search. Each contact that changes between two trials makes the
/// response nonlinear and costs one or two trials.
const MAX_TRIALS: u32 = 12;
/// From this trial on, every second trial bisects the interval, so that it also shrinks if the
/// response jumps.
const BISECT_FROM: u32 = 6;

/// The start is solved first if the crossing is expected within this fraction of the interval.
const NEAR_START: f64 = 0.05;

/// Distance below the limit at which the first interpolation aims.
const EXACT: f64 = 1e-7;

/// The consequence of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decision {
    /// The trial is committed, and the bond with this index breaks, if there is one.
    Stands(Option<usize>),
    /// The trial lies before the crossing. Solve at this larger fraction.
    Later(f64),
    /// The trial lies beyond the crossing. Solve at this smaller fraction.
    Earlier(f64),
}

/// The bond that breaks at constant load: the most overloaded of those at their limits.
pub fn at_constant_load(trial: &EventTrial, tolerance: f64) -> Option<usize> {
    let r = &trial.overloads;
    let at_limit = (0..r.len()).filter(|&i| r[i] >= 1.0 - tolerance);
    at_limit.max_by(|&i, &j| r[i].total_cmp(&r[j]).then(j.cmp(&i)))
}

/// The decision on trial number `trials` of a search, counted from 0. `below` is the last trial
/// before the crossing, or the start of the increment. `above` is the last trial beyond it.
/// `in_a_row` counts the consecutive trials that replaced the lower end of the interval, and those
/// that replaced the upper end. A bond is at its limit when `1 - tolerance <= R <= 1`.
pub fn decide(
    below: &EventTrial,
    above: Option<&EventTrial>,
    trial: &EventTrial,
    trials: u32,
    in_a_row: [u32; 2],
    tolerance: f64,
) -> Decision {
    let most = maximum(trial);
    let reached = most >= 1.0 - tolerance;
    if !reached && above.is_none() {
        return Decision::Stands(None);
    }
    if reached && trial.fraction == 0.0 {
        return Decision::Stands(at_constant_load(trial, tolerance));
    }
    // The two trials on either side of the first crossing.
    let ends = match above {
        Some(above) if !reached => [trial, above],
        _ => [below, trial],
    };
    let crossings = (0..trial.overloads.len()).map(|i| (crossing(ends, i, 1.0), i));
    let crossings = crossings.filter(|(at, _)| at.is_finite());
    let first = crossings.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let Some((_, bond)) = first else { return Decision::Stands(None) };
    if reached && most <= 1.0 || trials >= MAX_TRIALS {
        return Decision::Stands(Some(bond));
    }
    let (low, high) = if reached {
        (below.fraction, trial.fraction)
    } else {
        (trial.fraction, above.map_or(trial.fraction, |a| a.fraction))
    };
    // The first interpolation is exact if the response is linear. Later ones aim at the middle of
    // the tolerance.
    let below_limit = 0.5 * tolerance;
    let below_limit = if trials == 0 { below_limit.min(EXACT) } else { below_limit };
    let target = illinois(ends, bond, 1.0 - below_limit, in_a_row[usize::from(reached)], reached);
    // The initial forces do not predict well what happens soon after the start.
    if reached && !below.is_solved && (trials > 0 || target < NEAR_START * high) {
        return Decision::Earlier(0.0);
    }
    let is_inside = target > low && target < high;
    let bisects = trials >= BISECT_FROM && trials.is_multiple_of(2);
    let target = if is_inside && !bisects { target } else { 0.5 * (low + high) };
    if reached { Decision::Earlier(target) } else { Decision::Later(target) }
}

/// Maximum overload of a trial.
pub fn maximum(trial: &EventTrial) -> f64 {
    trial.overloads.iter().copied().fold(0.0, f64::max)
}

/// Fraction at which the overload of a bond is `value`, interpolated through two trials; infinite
/// if it decreases.
fn crossing([left, right]: [&EventTrial; 2], bond: usize, value: f64) -> f64 {
    let (l, r) = (left.overloads[bond], right.overloads[bond]);
    if l >= value {
        left.fraction
    } else if r > l {
        left.fraction + (value - l) / (r - l) * (right.fraction - left.fraction)
    } else {
        f64::INFINITY
    }
}

/// The next fraction by the Illinois rule. The weight of an end of the interval that stays is
/// halved each time, so that the trials of a nonlinear response do not accumulate on one side.
fn illinois(
    ends: [&EventTrial; 2],
    bond: usize,
    value: f64,
    in_a_row: u32,
    keeps_left: bool,
) -> f64 {
    let weight = 0.5_f64.powi(in_a_row.min(8) as i32);
    let [left, right] = ends.map(|trial| trial.overloads[bond] - value);
    let [left, right] = if keeps_left { [weight * left, right] } else { [left, weight * right] };
    let share = if right > left { -left / (right - left) } else { 0.5 };
    ends[0].fraction + share * (ends[1].fraction - ends[0].fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCE: f64 = 1e-3;

    fn trial(fraction: f64, overloads: &[f64]) -> EventTrial {
        EventTrial { fraction, overloads: overloads.to_vec(), change: fraction, is_solved: true }
    }

    /// Searches along piecewise linear overloads.
    fn search(response: impl Fn(f64) -> Vec<f64>) -> (f64, Option<usize>, u32) {
        let (mut below, mut above) = (trial(0.0, &response(0.0)), None);
        let mut fraction = 1.0;
        let mut in_a_row = [0, 0];
        for trials in 0.. {
            let this = trial(fraction, &response(fraction));
            match decide(&below, above.as_ref(), &this, trials, in_a_row, TOLERANCE) {
                Decision::Stands(broken) => return (fraction, broken, trials),
                Decision::Later(at) => {
                    (below, fraction) = (this, at);
                    in_a_row = [in_a_row[0] + 1, 0];
                }
                Decision::Earlier(at) => {
                    (above, fraction) = (Some(this), at);
                    in_a_row = [0, in_a_row[1] + 1];
                }
            }
        }
        unreachable!()
    }

    #[test]
    fn the_first_of_several_bonds_is_found_with_one_more_trial() {
        let response = |s: f64| vec![0.2 + 2.0 * s, 2.5 * s, 0.9 + 0.3 * s];
        let (fraction, broken, trials) = search(response);
        assert_eq!((broken, trials), (Some(2), 1));
        assert!((fraction - (0.1 - EXACT) / 0.3).abs() < 1e-12, "{fraction}");
    }

    #[test]
    fn below_all_limits_a_trial_stands_and_nothing_breaks() {
        let response = |s: f64| vec![0.5 * s, 0.998 * s];
        assert_eq!(search(response), (1.0, None, 0));
    }

    #[test]
    fn a_bent_response_is_followed_to_the_limit() {
        // A contact closes at 0.3, and the bond then carries more.
        let response = |s: f64| vec![0.4 * s + 3.0 * (s - 0.3_f64).max(0.0)];
        let (fraction, broken, trials) = search(response);
        let reached = response(fraction)[0];
        assert!((1.0 - 1e-3..=1.0).contains(&reached), "{reached}");
        assert!(broken == Some(0) && trials <= 8, "{trials}");
    }

    #[test]
    fn where_the_response_jumps_the_bond_breaks_all_the_same() {
        let response = |s: f64| vec![if s < 0.37 { 0.5 } else { 1.5 }];
        let (fraction, broken, _) = search(response);
        assert!((fraction - 0.37).abs() < 0.02, "{fraction}");
        assert_eq!(broken, Some(0));
    }

    #[test]
    fn the_most_overloaded_bond_breaks_at_constant_load() {
        let broken = |r: &[f64]| at_constant_load(&trial(0.0, r), TOLERANCE);
        assert_eq!(broken(&[1.1, 3.0, 0.5, 3.0]), Some(1));
        assert_eq!(broken(&[0.9, 0.9995]), Some(1));
        assert_eq!(broken(&[0.9, 0.99]), None);
    }
}
