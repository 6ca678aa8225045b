//! Curves within a window.

use std::ops::Range;

/// A point of a curve.
type Point = (f64, f64);

/// The pieces of a curve through points that lie within a window, cut at its border. A point that
/// is not finite ends a piece.
#[must_use]
pub fn clipped(points: &[Point], x: &Range<f64>, y: &Range<f64>) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    for pair in points.windows(2) {
        let Some([from, to]) = within([pair[0], pair[1]], x, y) else { continue };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// The part of a segment within a window (Liang and Barsky 1984).
fn within([a, b]: [Point; 2], x: &Range<f64>, y: &Range<f64>) -> Option<[Point; 2]> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (from, to, range) in [(a.0, b.0, x), (a.1, b.1, y)] {
        let way = to - from;
        if way == 0.0 {
            if from < range.start || from > range.end {
                return None;
            }
            continue;
        }
        let ends = [(range.start - from) / way, (range.end - from) / way];
        enter = enter.max(ends[0].min(ends[1]));
        leave = leave.min(ends[0].max(ends[1]));
    }
    let finite = [a.0, a.1, b.0, b.1].iter().all(|v| v.is_finite());
    let at = |t: f64| (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
    // Ends within the window stay as they are.
    let first = if enter == 0.0 { a } else { at(enter) };
    let last = if leave == 1.0 { b } else { at(leave) };
    (finite && enter < leave).then_some([first, last])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_end_at_the_border_of_the_window() {
        let window = (0.0..2.0, 0.0..1.0);
        let cut = |points: &[Point]| clipped(points, &window.0, &window.1);
        // Up through the window, out at the top at x = 1, and back at x = 1.5.
        let curve = [(-1.0, -1.0), (0.5, 0.5), (1.25, 1.25), (1.75, 0.75), (3.0, 0.75)];
        let expected = vec![
            vec![(0.0, 0.0), (0.5, 0.5), (1.0, 1.0)],
            vec![(1.5, 1.0), (1.75, 0.75), (2.0, 0.75)],
        ];
        assert_eq!(cut(&curve), expected);
        // Outside on one side, and past a corner.
        assert!(cut(&[(-1.0, 0.5), (-0.5, 0.9)]).is_empty());
        assert!(cut(&[(-1.0, 0.5), (0.5, 2.0)]).is_empty());
        assert_eq!(cut(&[(0.1, 0.2), (0.3, f64::NAN), (0.4, 0.2)]).len(), 0);
    }
}
