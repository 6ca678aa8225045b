//! Snap-back: after a rupture the imposed motion goes back until the next bond is at its limit and
//! all others hold. Pure functions of trials.
//!
//! A trial is the solution at a fraction s <= 0 of the increment with bonds of unlimited strength.
//! At s = 0, with the imposed motion where it was when the bond broke, some bond is above its
//! limit. The overloads R_i of the bonds are interpolated linearly between two trials. The bonds
//! above their limits come back to them at the roots s_i of R_i = 1, and all of them hold from the
//! minimum of these roots on. That is the nearest state with max R = 1.

use clastic_components::findings::EventTrial;

use crate::event_search::maximum;

/// Maximum number of trials. Each contact that changes costs one or two.
const MAX_TRIALS: u32 = 16;
/// From this trial on, every second trial bisects the interval.
const BISECT_FROM: u32 = 6;
/// Distance below the limit at which interpolations aim.
const EXACT: f64 = 1e-7;

/// The consequence of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Return {
    /// All bonds hold at s = 0: nothing has to go back.
    Holds,
    /// The trial is the root: the bond with this index is at its limit.
    Root(usize),
    /// Solve at this fraction.
    Try(f64),
    /// No state on the way back has max R = 1.
    NoRoot,
}

/// The decision on trial number `trials`, counted from 0. `above` is the last trial in which bonds
/// were above their limits, and `holding` the last one in which all were below. The imposed motion
/// goes back to the fraction `-furthest` at most.
#[must_use]
pub fn decide(
    above: Option<&EventTrial>,
    holding: Option<&EventTrial>,
    trial: &EventTrial,
    trials: u32,
    furthest: f64,
    tolerance: f64,
) -> Return {
    let most = maximum(trial);
    let at = trial.fraction;
    if (1.0 - tolerance..=1.0).contains(&most) {
        let bond = (0..trial.overloads.len())
            .max_by(|i, j| trial.overloads[*i].total_cmp(&trial.overloads[*j]).then(j.cmp(i)));
        return bond.map_or(Return::Holds, Return::Root);
    }
    let holds = most < 1.0;
    if holds && at == 0.0 {
        return Return::Holds;
    }
    if trials >= MAX_TRIALS {
        return Return::NoRoot;
    }
    let aim = 1.0 - EXACT.min(0.5 * tolerance);
    let target = match (holds, above, holding) {
        // From the start, as if the overload were in proportion to the way.
        (false, None, _) => -(1.0 - aim / most) * furthest,
        // Beyond both trials so far.
        (false, Some(last), None) => match roots([last, trial], trial, aim) {
            Some(target) => target,
            None => return Return::NoRoot,
        },
        (false, Some(_), Some(holding)) => between([trial, holding], aim, trials),
        (true, Some(above), _) => between([above, trial], aim, trials),
        (true, None, _) => return Return::NoRoot,
    };
    if target >= -furthest {
        Return::Try(target)
    } else if at > -furthest && holding.is_none() {
        // The estimate may be wrong.
        Return::Try(-furthest)
    } else {
        Return::NoRoot
    }
}

/// Minimum of the fractions at which the bonds above their limits in `of` have the overload `aim`,
/// by the line through two trials. `None` if one of them does not come back.
fn roots([first, second]: [&EventTrial; 2], of: &EventTrial, aim: f64) -> Option<f64> {
    let way = second.fraction - first.fraction;
    let mut target = f64::INFINITY;
    for (i, r) in of.overloads.iter().enumerate().filter(|(_, r)| **r > 1.0) {
        let slope = (second.overloads[i] - first.overloads[i]) / way;
        if !(slope > 0.0) {
            return None;
        }
        target = target.min(of.fraction - (r - aim) / slope);
    }
    target.is_finite().then_some(target)
}

/// The next fraction between a trial with bonds above their limits and one in which all hold.
fn between([above, holding]: [&EventTrial; 2], aim: f64, trials: u32) -> f64 {
    let (low, high) = (holding.fraction, above.fraction);
    let target = roots([above, holding], above, aim).unwrap_or(low);
    let bisects = trials >= BISECT_FROM && trials.is_multiple_of(2);
    if target > low && target < high && !bisects { target } else { 0.5 * (low + high) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Goes back along piecewise linear overloads.
    fn search(response: impl Fn(f64) -> Vec<f64>, furthest: f64) -> (Return, f64, u32) {
        let (mut above, mut holding): (Option<EventTrial>, Option<EventTrial>) = (None, None);
        let mut fraction = 0.0;
        for trials in 0.. {
            let overloads = response(fraction);
            let trial = EventTrial { fraction, overloads, change: 0.0, is_solved: true };
            match decide(above.as_ref(), holding.as_ref(), &trial, trials, furthest, 1e-3) {
                Return::Try(next) => {
                    let side = if maximum(&trial) > 1.0 { &mut above } else { &mut holding };
                    *side = Some(trial);
                    fraction = next;
                }
                end => return (end, fraction, trials),
            }
        }
        unreachable!()
    }

    #[test]
    fn where_all_bonds_hold_nothing_goes_back() {
        assert_eq!(search(|s| vec![0.5 + s, 0.9 + s], 3.0), (Return::Holds, 0.0, 0));
    }

    #[test]
    fn the_last_of_the_overloaded_bonds_to_hold_decides() {
        // They hold from -0.5, -0.6 and 0 on.
        let (end, at, trials) = search(|s| vec![1.5 + s, 1.3 + 0.5 * s, 0.2 + s], 5.0);
        assert_eq!((end, trials), (Return::Root(1), 2));
        assert!((at + 0.6).abs() < 1e-6, "{at}");
    }

    #[test]
    fn a_bent_way_back_is_followed() {
        let response = |s: f64| vec![1.2 + s.max(-0.1) + 0.05 * (s + 0.1).min(0.0)];
        let (end, at, trials) = search(response, 8.0);
        assert_eq!(end, Return::Root(0));
        assert!((at + 2.1).abs() < 0.021 && trials <= 10, "{at} {trials}");
    }

    #[test]
    fn a_bond_that_does_not_come_back_has_no_root() {
        assert_eq!(search(|s| vec![1.5 + s, 1.2 - 0.1 * s], 5.0).0, Return::NoRoot);
        assert_eq!(search(|s| vec![1.5 + 0.1 * s], 2.0).0, Return::NoRoot);
    }
}
