//! Corners of lines in a picture: a wall is an infinite line for contact, and is drawn between two
//! ends that go with it. As walls move, these ends part or cross.

use glam::DVec2;

/// Maximum distance of an end from its corner, over the length of the line.
const NEAR: f64 = 0.3;
/// Minimum sine of the angle between two lines that have a corner.
const SQUARE: f64 = 0.05;

/// The lines with ends at their corners: where a line meets another one near an end of either.
/// Other ends stay.
pub fn joined(lines: &[[DVec2; 2]]) -> Vec<[DVec2; 2]> {
    let mut joined = lines.to_vec();
    for (k, line) in lines.iter().enumerate() {
        for end in 0..2 {
            let others = lines.iter().enumerate().filter(|(other, _)| *other != k);
            let nearest = others
                .filter_map(|(_, other)| corner(*line, end, *other))
                .min_by(|x, y| x.0.total_cmp(&y.0));
            if let Some((_, corner)) = nearest {
                joined[k][end] = corner;
            }
        }
    }
    joined
}

/// The corner that a line has with another one near one of its ends, and how far it is from there.
fn corner(line: [DVec2; 2], end: usize, other: [DVec2; 2]) -> Option<(f64, DVec2)> {
    let (along, across) = (line[1] - line[0], other[1] - other[0]);
    let turn = along.perp_dot(across);
    if !(turn.abs() > SQUARE * along.length() * across.length()) {
        return None;
    }
    let part = (other[0] - line[end]).perp_dot(across) / turn;
    let corner = line[end] + part * along;
    let away = other.map(|x| x.distance(corner)).into_iter().fold(f64::INFINITY, f64::min);
    (part.abs() <= NEAR && away <= NEAR * across.length())
        .then(|| (part.abs() * along.length(), corner))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(x0: f64, y0: f64, x1: f64, y1: f64) -> [DVec2; 2] {
        [DVec2::new(x0, y0), DVec2::new(x1, y1)]
    }

    #[test]
    fn walls_meet_after_a_confinement() {
        // A box of 4 x 8 whose walls have moved: right inwards, top downwards, left outwards.
        let walls = [
            line(0.0, 0.0, 4.0, 0.0),
            line(3.8, 0.0, 3.8, 8.0),
            line(4.0, 7.5, 0.0, 7.5),
            line(-0.1, 8.0, -0.1, 0.0),
        ];
        let expected = [
            line(-0.1, 0.0, 3.8, 0.0),
            line(3.8, 0.0, 3.8, 7.5),
            line(3.8, 7.5, -0.1, 7.5),
            line(-0.1, 7.5, -0.1, 0.0),
        ];
        for (joined, expected) in joined(&walls).iter().zip(expected) {
            assert!((0..2).all(|k| joined[k].distance(expected[k]) < 1e-12), "{joined:?}");
        }
    }

    #[test]
    fn ends_without_a_corner_stay() {
        // Two platens, a wall in the middle of nowhere, and a line without length.
        let walls = [
            line(0.0, 0.0, 1.0, 0.0),
            line(1.0, 2.0, 0.0, 2.0),
            line(5.0, 0.9, 5.0, 1.1),
            line(0.5, 0.0, 0.5, 0.0),
        ];
        assert_eq!(joined(&walls), walls);
    }
}
