//! Search for the state at which the next bonds break: pure functions of trials ([`decide`],
//! [`at_constant_load`]).
//!
//! A trial is the solution at a fraction s of the increment with bonds of unlimited strength,
//! together with the overload R_i of each bond. R_i is interpolated linearly between two trials,
//! which is exact if no contact changes in between. The crossing c_i of a bond is the fraction at
//! which R_i = 1.
//!
//! Bonds break in groups. A group starts with the first crossing c_1 and ends with the last c_i
//! that satisfies
//!
//! ```text
//! (c_i - c_1) d/ds sum|f - f_0| <= group sum|f|,     sum_group |f_i| <= group sum|f|
//! ```
//!
//! with f the contact forces and f_0 those at the start of the increment. Neither the loading
//! across the group nor its ruptures then change the forces by more than the fraction `group`. The
//! first bond always belongs to the group. The group breaks at the middle of its span: half of its
//! bonds break somewhat late and the others somewhat early, so that the first-order error cancels.
//! With `group` = 0 bonds break one by one, each at `1 - tolerance <= R <= 1`.

use clastic_components::findings::EventTrial;

/// Maximum number of trials of a search. Each contact that changes between two trials makes the
/// response nonlinear and costs one or two trials.
const MAX_TRIALS: u32 = 12;
/// From this trial on, every second trial bisects the interval, so that it also shrinks if the
/// response jumps.
const BISECT_FROM: u32 = 6;

/// The start is solved first if a group is expected within this fraction of the interval.
const NEAR_START: f64 = 0.05;

/// Distance below the limit at which the first interpolation aims.
const EXACT: f64 = 1e-7;

/// Rules that decide which bonds break together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupRules {
    /// A bond is at its limit when `1 - tolerance <= R <= 1`.
    pub tolerance: f64,
    /// Relative change of the contact forces across a group.
    pub group: f64,
    /// Maximum share of the contact forces in the bonds that break together at constant load. With
    /// infinity, all bonds above their limits break.
    pub share: f64,
}

/// A trial and its forces.
#[derive(Clone, Copy, Debug)]
pub struct Now<'a> {
    /// The trial.
    pub trial: &'a EventTrial,
    /// Force of each bond over the sum of all contact forces, `|f_i| / sum|f|`.
    pub shares: &'a [f64],
}

/// The consequence of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum Decision {
    /// The trial is committed, and the bonds with these indices break. The list may be empty.
    Stands(Vec<usize>),
    /// The trial lies before the group. Solve at this larger fraction.
    Later(f64),
    /// The trial lies beyond the group. Solve at this smaller fraction.
    Earlier(f64),
}

/// The bonds that break at constant load, by decreasing overload, up to the share `share` of the
/// forces.
#[must_use]
pub fn at_constant_load(now: Now, rules: GroupRules) -> Vec<usize> {
    let r = &now.trial.overloads;
    let mut overloaded: Vec<usize> =
        (0..r.len()).filter(|&i| r[i] >= 1.0 - rules.tolerance).collect();
    overloaded.sort_by(|&i, &j| r[j].total_cmp(&r[i]).then(i.cmp(&j)));
    overloaded.truncate(affordable(&overloaded, now.shares, rules.share));
    overloaded
}

/// The decision on trial number `trials` of a search, counted from 0. `below` is the last trial
/// before the group, or the start of the increment. `above` is the last trial beyond the group.
/// `in_a_row` counts the consecutive trials that replaced the lower end of the interval, and the
/// upper end.
#[must_use]
pub fn decide(
    below: &EventTrial,
    above: Option<&EventTrial>,
    now: Now,
    trials: u32,
    in_a_row: [u32; 2],
    rules: GroupRules,
) -> Decision {
    let trial = now.trial;
    let reached = maximum(trial) >= 1.0 - rules.tolerance;
    if !reached && above.is_none() {
        return Decision::Stands(Vec::new());
    }
    if reached && trial.fraction == 0.0 {
        return Decision::Stands(at_constant_load(now, rules));
    }
    // The two trials on either side of the first crossing.
    let ends = match above {
        Some(above) if !reached => [trial, above],
        _ => [below, trial],
    };
    let mut crossings: Vec<(f64, usize)> = (0..trial.overloads.len())
        .map(|i| (crossing(ends, i, 1.0), i))
        .filter(|(at, _)| at.is_finite())
        .collect();
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let Some(&(first, leader)) = crossings.first() else {
        return Decision::Stands(Vec::new());
    };
    // Relative change of the contact forces with the fraction.
    let rate = ends[1].change / ends[1].fraction.max(f64::MIN_POSITIVE);
    let within = |c: &(f64, usize)| (c.0 - first) * rate <= rules.group;
    let order: Vec<usize> = crossings.iter().take_while(|c| within(c)).map(|c| c.1).collect();
    let members = affordable(&order, now.shares, rules.group);
    let last = crossings[members - 1].0;
    let holds = maximum(trial) <= 1.0;
    if reached && (holds || trial.fraction <= last && members > 1) || trials >= MAX_TRIALS {
        // The end lies as far beyond this state as the first crossing lies before it.
        let end = (2.0 * trial.fraction - first).max(trial.fraction);
        let is_due =
            |c: &&(f64, usize)| c.0 <= end || trial.overloads[c.1] >= 1.0 - rules.tolerance;
        let mut due: Vec<usize> =
            crossings.iter().take(members).filter(is_due).map(|c| c.1).collect();
        if due.is_empty() {
            due.push(leader);
        }
        return Decision::Stands(due);
    }
    let (low, high) = if reached {
        (below.fraction, trial.fraction)
    } else {
        (trial.fraction, above.map_or(trial.fraction, |a| a.fraction))
    };
    let target = if members > 1 {
        0.5 * (first + last)
    } else {
        // The first interpolation is exact if the response is linear. Later ones aim at the middle
        // of the tolerance.
        let below_limit = 0.5 * rules.tolerance;
        let below_limit = if trials == 0 { below_limit.min(EXACT) } else { below_limit };
        let again = in_a_row[usize::from(reached)];
        illinois(ends, leader, 1.0 - below_limit, again, reached)
    };
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
#[must_use]
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

/// Number of bonds, from the first on, whose forces sum to at most the share `group` of all forces;
/// at least one.
fn affordable(order: &[usize], shares: &[f64], group: f64) -> usize {
    let mut sum = 0.0;
    let fit = order.iter().take_while(|&&i| {
        sum += shares[i];
        sum <= group
    });
    fit.count().max(1).min(order.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: GroupRules = rules(1e-3, 0.0);

    const fn rules(tolerance: f64, group: f64) -> GroupRules {
        GroupRules { tolerance, group, share: group }
    }

    fn trial(fraction: f64, overloads: &[f64]) -> EventTrial {
        EventTrial { fraction, overloads: overloads.to_vec(), change: fraction, is_solved: true }
    }

    fn now<'a>(trial: &'a EventTrial, shares: &'a [f64]) -> Now<'a> {
        Now { trial, shares }
    }

    /// Searches along piecewise linear overloads.
    fn search(response: impl Fn(f64) -> Vec<f64>, rules: GroupRules) -> (f64, Vec<usize>, u32) {
        let (mut below, mut above) = (trial(0.0, &response(0.0)), None);
        let mut fraction = 1.0;
        let mut in_a_row = [0, 0];
        for trials in 0.. {
            let this = trial(fraction, &response(fraction));
            let shares = vec![0.01; this.overloads.len()];
            match decide(&below, above.as_ref(), now(&this, &shares), trials, in_a_row, rules) {
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
        let (fraction, broken, trials) = search(response, RULES);
        assert_eq!((broken, trials), (vec![2], 1));
        assert!((fraction - (0.1 - EXACT) / 0.3).abs() < 1e-12, "{fraction}");
    }

    #[test]
    fn below_all_limits_a_trial_stands_and_nothing_breaks() {
        let response = |s: f64| vec![0.5 * s, 0.999 * s];
        assert_eq!(search(response, rules(1e-4, 0.0)), (1.0, vec![], 0));
    }

    #[test]
    fn a_bent_response_is_followed_to_the_limit() {
        // A contact closes at 0.3, and the bond then carries more.
        let response = |s: f64| vec![0.4 * s + 3.0 * (s - 0.3_f64).max(0.0)];
        let (fraction, broken, trials) = search(response, RULES);
        let reached = response(fraction)[0];
        assert!((1.0 - 1e-3..=1.0).contains(&reached), "{reached}");
        assert!(broken == [0] && trials <= 8, "{trials}");
    }

    #[test]
    fn where_the_response_jumps_the_bond_breaks_all_the_same() {
        let response = |s: f64| vec![if s < 0.37 { 0.5 } else { 1.5 }];
        let (fraction, broken, _) = search(response, RULES);
        assert!((fraction - 0.37).abs() < 0.02, "{fraction}");
        assert_eq!(broken, [0]);
    }

    #[test]
    fn a_group_breaks_in_the_middle_of_its_span() {
        // Crossings are 0.10, 0.11, ... 0.19. A group of 0.045 contains those up to 0.14.
        let response = |s: f64| (0..10).map(|i| s / (0.1 + 0.01 * f64::from(i))).collect();
        let (fraction, broken, _) = search(response, rules(1e-3, 0.0451));
        assert!((fraction - 0.115).abs() < 0.012, "{fraction}");
        assert!(broken.starts_with(&[0, 1]) && broken.len() <= 4, "{broken:?}");
    }

    #[test]
    fn a_group_ends_with_its_share_of_the_forces() {
        let r = trial(0.0, &[1.1, 3.0, 0.5, 2.0]);
        let shares = [0.01, 0.02, 0.01, 0.02];
        let broken = |group| at_constant_load(now(&r, &shares), rules(1e-3, group));
        assert_eq!(broken(0.0), [1]);
        assert_eq!(broken(0.045), [1, 3]);
        assert_eq!(broken(1.0), [1, 3, 0]);
        // All bonds above their limits break, whatever their share of the forces.
        let together = GroupRules { share: f64::INFINITY, ..RULES };
        let broken = at_constant_load(now(&r, &[9.0; 4]), together);
        assert_eq!(broken, [1, 3, 0]);
    }

    #[test]
    fn a_bond_at_its_limit_breaks_at_constant_load() {
        let r = trial(0.0, &[0.9, 0.9995]);
        assert_eq!(at_constant_load(now(&r, &[0.1, 0.1]), RULES), [1]);
        let r = trial(0.0, &[0.9, 0.99]);
        assert!(at_constant_load(now(&r, &[0.1, 0.1]), RULES).is_empty());
    }
}
