//! Pieces of the walls of a scene: a polyline is several walls under one name.

use std::f64::consts::PI;

use clastic_components::wall::Wall;
use clastic_components::wall_shape::WallShape;
use glam::DVec2;

use crate::scene::format as scene;

/// A straight or curved piece of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// Middle of the piece, or the centre of a whole circle, m.
    pub position: DVec2,
    /// Direction and length.
    pub wall: Wall,
    /// Shape for contact.
    pub shape: WallShape,
}

impl Piece {
    /// Distance of a place from the piece, m; negative behind a line.
    pub fn distance(&self, place: DVec2) -> f64 {
        let Self { position, wall, shape } = self;
        shape.nearest(wall.inward(), wall.half_length, place - *position).distance
    }
}

/// Number of pieces of a wall. Each is a body with an identity of its own.
pub fn count(wall: &scene::Wall) -> u32 {
    match &wall.shape {
        scene::WallShape::Polyline(corners) => corners.len() as u32 + 1,
        _ => 1,
    }
}

/// The pieces of a wall from its start to its end.
pub fn pieces(wall: &scene::Wall) -> Vec<Piece> {
    let (start, end) = (DVec2::from(wall.start), DVec2::from(wall.end));
    match &wall.shape {
        scene::WallShape::Line => vec![straight(start, end, WallShape::Line)],
        scene::WallShape::Segment => vec![straight(start, end, WallShape::Segment)],
        scene::WallShape::Arc { through } => vec![arc(start, DVec2::from(*through), end)],
        scene::WallShape::Polyline(corners) => {
            let corners = corners.iter().map(|corner| DVec2::from(*corner));
            let points: Vec<_> =
                std::iter::once(start).chain(corners).chain(std::iter::once(end)).collect();
            points.windows(2).map(|ends| straight(ends[0], ends[1], WallShape::Segment)).collect()
        }
    }
}

/// Minimum distance of the centre of a particle from a wall when the wall or the particle comes, over
/// its radius. The side of a closer particle from a thin wall is not clear, and a line presses on it
/// with half of its radius.
pub const CUT: f64 = 0.5;

/// Whether a wall cuts through a disk, where it is drawn: a line, if the centre is on its inner side.
/// One that is yet to come at the outermost particles cuts through none.
pub fn is_cut(wall: &scene::Wall, place: DVec2, radius: f64) -> bool {
    wall.is_placed()
        && pieces(wall).iter().any(|piece| (0.0..CUT * radius).contains(&piece.distance(place)))
}

/// The wall with all its points moved, from a place to another, and turned about it. `by` is the
/// unit vector (cos, sin) of the angle.
pub fn moved(wall: &scene::Wall, from: DVec2, by: DVec2, to: DVec2) -> scene::Wall {
    let shift = |(x, y): (f64, f64)| {
        if by == DVec2::X {
            let by = to - from;
            return (x + by.x, y + by.y);
        }
        (to + by.rotate(DVec2::new(x, y) - from)).into()
    };
    let mut wall = wall.clone();
    (wall.start, wall.end) = (shift(wall.start), shift(wall.end));
    match &mut wall.shape {
        scene::WallShape::Line | scene::WallShape::Segment => {}
        scene::WallShape::Polyline(corners) => {
            corners.iter_mut().for_each(|corner| *corner = shift(*corner));
        }
        scene::WallShape::Arc { through } => *through = shift(*through),
    }
    wall
}

fn straight(start: DVec2, end: DVec2, shape: WallShape) -> Piece {
    let wall = Wall {
        tangent: (end - start).normalize_or(DVec2::X),
        half_length: 0.5 * start.distance(end),
    };
    Piece { position: 0.5 * (start + end), wall, shape }
}

/// The arc from `start` through a point to `end`. If it ends where it starts it is the circle on
/// the diameter from there to the point.
fn arc(start: DVec2, through: DVec2, end: DVec2) -> Piece {
    if start == end {
        let centre = 0.5 * (start + through);
        let radius = 0.5 * start.distance(through);
        let inward = (centre - start) / radius;
        let wall = Wall { tangent: -inward.perp(), half_length: radius };
        let shape = WallShape::Arc { centre: DVec2::ZERO, radius, axis: inward, half_angle: PI };
        return Piece { position: centre, wall, shape };
    }
    let Piece { position: middle, wall, .. } = straight(start, end, WallShape::Line);
    let (half, from) = (wall.half_length, through - middle);
    let height = from.dot(wall.inward());
    // Distance of the centre from the chord, on the side of the inward normal: all three points are
    // at the same distance from it.
    let offset = (from.length_squared() - half * half) / (2.0 * height);
    let axis = wall.inward() * height.signum();
    let radius = half.hypot(offset);
    let centre = middle + offset * wall.inward();
    let half_angle = half.atan2(-offset * height.signum());
    let position = centre + radius * axis;
    let shape = WallShape::Arc { centre: centre - position, radius, axis, half_angle };
    Piece { position, wall, shape }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A wall of this shape.
    pub(in crate::run) fn drawn(
        start: (f64, f64),
        end: (f64, f64),
        shape: scene::WallShape,
    ) -> scene::Wall {
        scene::Wall {
            name: "w".into(),
            start,
            end,
            shape,
            contact: scene::Contact::default(),
            bond: None,
            present: true,
            touching: false,
            probe: None,
        }
    }

    fn of(shape: scene::WallShape, start: (f64, f64), end: (f64, f64)) -> Vec<Piece> {
        let wall = drawn(start, end, shape);
        assert_eq!(count(&wall) as usize, pieces(&wall).len());
        pieces(&wall)
    }

    #[test]
    fn an_arc_goes_through_its_three_points() {
        let angle = |a: f64| (1.0 + 2.0 * a.cos(), -0.5 + 2.0 * a.sin());
        for (from, to) in [(0.3, 1.9), (1.9, 0.3), (-0.2, 4.5), (4.5, -0.2), (0.0, PI)] {
            let through = angle(from + 0.3 * (to - from));
            let shape = scene::WallShape::Arc { through };
            let list = of(shape, angle(from), angle(to));
            let WallShape::Arc { centre, radius, axis, half_angle } = list[0].shape else {
                panic!("no arc")
            };
            let close = |a: DVec2, b: (f64, f64)| a.distance(DVec2::from(b)) < 1e-14;
            assert!(close(list[0].position + centre, (1.0, -0.5)));
            assert!(
                (radius - 2.0).abs() < 1e-14
                    && (half_angle - 0.5 * (to - from).abs()).abs() < 1e-14
            );
            let middle = 0.5 * (from + to);
            assert!(close(axis, (middle.cos(), middle.sin())));
        }
    }
}
