//! Wall clock: medians of repeated measurements.

use std::time::Instant;

/// Number of repetitions of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repetitions {
    /// Minimum number.
    pub minimum: usize,
    /// Maximum number.
    pub maximum: usize,
    /// Time after which only the minimum number is made, s.
    pub seconds: f64,
}

/// Calls `measure`, which returns the seconds that count, and returns their median.
pub fn median(repetitions: &Repetitions, mut measure: impl FnMut() -> f64) -> f64 {
    let clock = Instant::now();
    let mut times = Vec::new();
    while times.len() < repetitions.minimum
        || (times.len() < repetitions.maximum
            && clock.elapsed().as_secs_f64() < repetitions.seconds)
    {
        times.push(measure());
    }
    middle(&mut times)
}

/// The median of some numbers; NaN without numbers.
pub fn middle(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    match numbers.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => numbers[n / 2],
        n => 0.5 * (numbers[n / 2 - 1] + numbers[n / 2]),
    }
}

/// Seconds that a call takes, and its result.
pub fn time<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let clock = Instant::now();
    let out = run();
    (clock.elapsed().as_secs_f64(), out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(middle(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(middle(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(middle(&mut []).is_nan());
        let mut next = 0.0;
        let repetitions = Repetitions { minimum: 3, maximum: 9, seconds: 0.0 };
        let found = median(&repetitions, || {
            next += 1.0;
            next
        });
        assert_eq!((found, next), (2.0, 3.0));
    }
}
