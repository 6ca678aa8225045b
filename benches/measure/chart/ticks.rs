//! Ticks of the axes of a chart: as many as have room for their labels.

use std::ops::Range;

use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;

use super::page;

/// Maximum and minimum number of ticks asked for. Plotters draws at most that number.
const NUMBER: (usize, usize) = (10, 3);
/// Size of a label, and space between two of them, in sizes of the font.
const LABEL: f64 = 0.93;
const GAP: f64 = 0.7;

/// Number of ticks of a horizontal axis of this length, in sizes of the font.
pub fn beside(range: &Range<f64>, length: f64) -> usize {
    let span = range.end - range.start;
    number(range, length, |a, b| {
        let half = |x: f64| 0.5 * page::width(&tick(x, span), LABEL);
        half(a) + GAP + half(b)
    })
}

/// Number of ticks of a vertical axis of this length, in sizes of the font.
pub fn above(range: &Range<f64>, length: f64) -> usize {
    number(range, length, |_, _| LABEL + GAP)
}

/// The largest number of ticks with this distance or more between each two.
fn number(range: &Range<f64>, length: f64, distance: impl Fn(f64, f64) -> f64) -> usize {
    let em = length / (range.end - range.start);
    let coordinate = RangedCoordf64::from(range.clone());
    let fits = |number: &usize| {
        let places = coordinate.key_points(*number);
        places.windows(2).all(|pair| (pair[1] - pair[0]) * em >= distance(pair[0], pair[1]))
    };
    (NUMBER.1..=NUMBER.0).rev().find(fits).unwrap_or(NUMBER.1)
}

/// A label of a tick without digits of round-off, on an axis with the given span.
pub fn tick(value: f64, span: f64) -> String {
    let value = if value.abs() < 1e-9 * span { 0.0 } else { value };
    let rounded = format!("{value:.6e}").parse().unwrap_or(value) + 0.0;
    if rounded != 0.0 && !(1e-4..1e6).contains(&f64::abs(rounded)) {
        return format!("{rounded:e}");
    }
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        let found = [0.1 + 0.2, 1e-17, 250.0, 2e-7, -0.0].map(|v| tick(v, 1.0));
        assert_eq!(found, ["0.3", "0", "250", "2e-7", "0"]);
        assert_eq!(tick(1e-17, 1e-16), "1e-17");
    }

    #[test]
    fn labels_have_room() {
        // Labels of one digit have room where those of six have not.
        assert_eq!(beside(&(0.0..10.0), 20.0), 10);
        assert!(beside(&(0.0..1.1e-3), 20.0) < 8, "{}", beside(&(0.0..1.1e-3), 20.0));
        assert!(above(&(0.0..0.8), 30.0) > above(&(0.0..0.8), 8.0));
        assert_eq!(above(&(0.0..1.0), 0.1), NUMBER.1);
        for (range, length) in [(0.0..0.75, 9.0), (176.0..810.0, 8.0), (-2.7..0.93, 11.0)] {
            let n = above(&range, length);
            let places = RangedCoordf64::from(range.clone()).key_points(n);
            let em = length / (range.end - range.start);
            assert!(places.len() >= 2, "{range:?}");
            assert!(places.windows(2).all(|p| (p[1] - p[0]) * em > 1.0), "{range:?} {places:?}");
        }
    }
}
