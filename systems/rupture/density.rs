//! Density of ruptures, which measures how closely bonds follow each other in reaching their
//! limits: a pure function of two states of an increment.

use clastic_components::findings::EventTrial;

/// Relative change of the contact forces over which bonds that reach their limits are counted.
const WINDOW: f64 = 0.05;
/// Minimum count: from fewer bonds the density of a small specimen is a matter of chance.
const MIN_COUNT: usize = 10;

/// Density of ruptures between a state and a trial: the share of the bonds that reach their limits
/// per relative change of the contact forces,
///
/// ```text
/// density = n / (N WINDOW)
/// ```
///
/// with N bonds in all, and n bonds that reach their limits from the first crossing on until the
/// forces have changed by the fraction `WINDOW` more. Overloads are extrapolated linearly, so that
/// the density depends on the length of the trial only where the response is not linear. It is 0 if
/// n is below `MIN_COUNT`, as where all overloads decrease.
pub fn density(below: &EventTrial, trial: &EventTrial) -> f64 {
    let (_, due) = due(below, trial);
    if due.len() < MIN_COUNT {
        0.0
    } else {
        due.len() as f64 / (trial.overloads.len() as f64 * WINDOW)
    }
}

/// The fraction of the first crossing, and the bonds that reach their limits from there on until
/// the forces have changed by the fraction `WINDOW` more. Without a crossing the fraction is
/// infinite.
pub fn due(below: &EventTrial, trial: &EventTrial) -> (f64, Vec<usize>) {
    let step = trial.fraction - below.fraction;
    let overloads = below.overloads.iter().zip(&trial.overloads);
    let crossings: Vec<f64> =
        overloads.map(|(from, to)| below.fraction + distance(*from, [*from, *to], step)).collect();
    let first = crossings.iter().copied().fold(f64::INFINITY, f64::min);
    let rate = trial.change / trial.fraction;
    // An infinite crossing is not within: its difference to the first one is infinite or NaN.
    let within = |i: &usize| (crossings[*i] - first) * rate <= WINDOW;
    (first, (0..crossings.len()).filter(within).collect())
}

/// Part of the increment after which a bond with the overload `at` reaches its limit, if its
/// overload goes on to change by `to - from` in each `step`; infinite if it decreases.
pub fn distance(at: f64, [from, to]: [f64; 2], step: f64) -> f64 {
    if to > from { (1.0 - at).max(0.0) / (to - from) * step } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(fraction: f64, overloads: Vec<f64>) -> EventTrial {
        EventTrial { fraction, overloads, change: 0.2 * fraction, is_solved: true }
    }

    /// Bonds with overloads s/c at the fraction s.
    fn at(fraction: f64, crossings: &[f64]) -> EventTrial {
        state(fraction, crossings.iter().map(|c| fraction / c).collect())
    }

    #[test]
    fn the_density_does_not_depend_on_the_length_of_the_trial() {
        // Forces change by 0.05 in a quarter of the increment: 13 of 100 crossings, from 1.0 on.
        let crossings: Vec<f64> = (0..100).map(|i| 1.0 + 0.02 * f64::from(i)).collect();
        for fraction in [0.01, 0.3, 1.0] {
            let density = density(&at(0.0, &crossings), &at(fraction, &crossings));
            assert!((density - 13.0 / (100.0 * 0.05)).abs() < 1e-9, "{density}");
        }
    }

    #[test]
    fn few_bonds_have_no_density() {
        let crossings = [0.5; MIN_COUNT - 1];
        assert_eq!(density(&at(0.0, &crossings), &at(1.0, &crossings)), 0.0);
        let crossings = [0.5; MIN_COUNT];
        assert!((density(&at(0.0, &crossings), &at(1.0, &crossings)) - 20.0).abs() < 1e-9);
        // Unloading brings no bond to its limit.
        assert_eq!(density(&at(1.0, &crossings), &at(0.5, &crossings)), 0.0);
    }

    #[test]
    fn the_distance_to_a_limit_is_extrapolated() {
        assert!((distance(0.8, [0.5, 0.8], 3.0) - 2.0).abs() < 1e-12);
        assert_eq!(distance(0.8, [0.9, 0.8], 1.0), f64::INFINITY);
        assert_eq!(distance(1.2, [0.9, 1.2], 0.1), 0.0);
    }
}
