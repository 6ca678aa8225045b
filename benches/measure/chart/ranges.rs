//! Ranges of axes and points of lines.

/// Maximum number of points of a line. Closer points cannot be distinguished.
const MAX_POINTS: usize = 2000;

/// A range that contains all values with a margin, and is never empty.
pub(super) fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let room = if high > low { 0.04 * (high - low) } else { low.abs().max(1.0) };
    // Most curves begin at zero, so the axis begins there if zero is near.
    (if (0.0..=room).contains(&low) { 0.0 } else { low - room })..(high + room)
}

/// Every n-th point, and the last one.
pub(super) fn thin(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> {
    let step = points.len().div_ceil(MAX_POINTS).max(1);
    let last = if points.len() % step == 1 || step == 1 { None } else { points.last() };
    points.iter().step_by(step).chain(last).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_ends() {
        for n in [1, 2, 2000, 2001, 4001, 12_345] {
            let points: Vec<_> = (0..n).map(|k| (f64::from(k), 0.0)).collect();
            let thinned: Vec<_> = thin(&points).collect();
            assert!(thinned.len() <= MAX_POINTS + 1);
            assert_eq!((thinned.first(), thinned.last()), (points.first(), points.last()));
            assert!(thinned.windows(2).all(|w| w[0].0 < w[1].0));
        }
    }
}
