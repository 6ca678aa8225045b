//! Shapes of walls: infinite lines, thin plates with two ends, and thin circular arcs.
//!
//! A line has material on its left only. A plate or an arc is a thin obstacle without thickness:
//! a disk touches it on the side where its centre is, and beyond an end it touches the end point.

use std::f64::consts::PI;

use bevy_ecs::prelude::*;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::wall::Wall;

/// Shape of a wall for contact. Vectors are relative to the wall's
/// [`BodyPosition`](crate::body::BodyPosition). A wall without this component is a
/// [`Line`](Self::Line).
#[derive(Component, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Component))]
pub enum WallShape {
    /// An infinite line with material on its left.
    #[default]
    Line,
    /// The straight piece between the two ends.
    Segment,
    /// A circular arc.
    Arc {
        /// Centre of the circle, m.
        centre: DVec2,
        /// Radius of the circle, m.
        radius: f64,
        /// Unit vector from the centre to the middle of the arc.
        axis: DVec2,
        /// Half of the opening angle, rad; pi for a whole circle, which has no ends.
        half_angle: f64,
    },
}

/// The point of a wall that is nearest to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Unit vector from the wall to the place. At a line: the inward normal.
    pub outward: DVec2,
    /// Distance, m. At a line it is negative on the outer side.
    pub distance: f64,
    /// Curvature of the wall at the point.
    pub curve: Curve,
}

/// How a wall is curved at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// Straight.
    Flat,
    /// Part of a circle about this centre (relative to the wall, m), with the disk outside of it.
    /// An end point is a circle without radius.
    Round(DVec2),
    /// Part of a circle about this centre, with the disk inside of it.
    Hollow(DVec2),
}

impl WallShape {
    /// The point of the wall that is nearest to `place`, which is relative to the wall's position,
    /// m.
    #[inline]
    pub fn nearest(&self, inward: DVec2, half_length: f64, place: DVec2) -> Nearest {
        match self {
            Self::Line => {
                Nearest { outward: inward, distance: place.dot(inward), curve: Curve::Flat }
            }
            thin => thin.nearest_of_thin(inward, half_length, place),
        }
    }

    /// A separate function, so that [`nearest`](Self::nearest) of a line stays a single product.
    fn nearest_of_thin(&self, inward: DVec2, half_length: f64, place: DVec2) -> Nearest {
        match self {
            Self::Line => flat(inward, place.dot(inward)),
            Self::Segment => {
                // The inward normal is the tangent turned by +90 degrees.
                let tangent = -inward.perp();
                let along = place.dot(tangent);
                if along.abs() <= half_length {
                    return flat(inward, place.dot(inward));
                }
                point(half_length.copysign(along) * tangent, place, inward)
            }
            Self::Arc { centre, radius, axis, half_angle } => {
                let from = place - *centre;
                let far = from.length();
                let out = if far > 0.0 { from / far } else { *axis };
                if !opens(*half_angle, *axis, out) {
                    let side = axis.perp_dot(out).signum();
                    let end =
                        *centre + *radius * DVec2::from_angle(side * half_angle).rotate(*axis);
                    return point(end, place, inward);
                }
                let (outward, curve) = if far < *radius {
                    (-out, Curve::Hollow(*centre))
                } else {
                    (out, Curve::Round(*centre))
                };
                Nearest { outward, distance: (far - radius).abs(), curve }
            }
        }
    }

    /// Whether the straight segment between two places, relative to the wall, crosses it. Nothing
    /// crosses a line: on its outer side distances are negative.
    #[inline]
    pub fn is_crossed(&self, inward: DVec2, half_length: f64, [start, finish]: [DVec2; 2]) -> bool {
        let way = finish - start;
        match self {
            Self::Line => false,
            Self::Segment => {
                let (before, after) = (start.dot(inward), finish.dot(inward));
                if (before < 0.0) == (after < 0.0) {
                    return false;
                }
                let at = start + way * (before / (before - after));
                at.perp_dot(inward).abs() <= half_length
            }
            Self::Arc { centre, radius, axis, half_angle } => {
                let from = start - *centre;
                let (a, b) = (way.length_squared(), from.dot(way));
                let c = from.length_squared() - radius * radius;
                let root = (b * b - a * c).sqrt();
                // Without a real root the segment misses the circle: comparisons with NaN fail.
                [(-b - root) / a, (-b + root) / a].into_iter().any(|s| {
                    let out = (from + s * way) / *radius;
                    s > 0.0 && s <= 1.0 && opens(*half_angle, *axis, out)
                })
            }
        }
    }

    /// The shape turned about the wall's position. `by` is the unit vector (cos, sin) of the angle.
    pub fn turned(self, by: DVec2) -> Self {
        let direction = |unit: DVec2| by.rotate(unit).normalize();
        match self {
            Self::Line | Self::Segment => self,
            Self::Arc { centre, radius, axis, half_angle } => {
                Self::Arc { centre: by.rotate(centre), radius, axis: direction(axis), half_angle }
            }
        }
    }

    /// Radius (m) and half the opening angle (rad) of an arc.
    pub fn circle(&self) -> Option<(f64, f64)> {
        match self {
            Self::Arc { radius, half_angle, .. } => Some((*radius, *half_angle)),
            Self::Line | Self::Segment => None,
        }
    }

    /// The drawn line from start to end, as points relative to the wall's position, m.
    pub fn outline(&self, wall: &Wall) -> Vec<DVec2> {
        let Self::Arc { centre, radius, axis, half_angle } = self else {
            let half = wall.tangent * wall.half_length;
            return vec![-half, half];
        };
        let at = |angle: f64| *centre + *radius * DVec2::from_angle(angle).rotate(*axis);
        let pieces = (half_angle / OUTLINE_STEP).ceil().max(1.0) as i32;
        (-pieces..=pieces).map(|k| at(half_angle * f64::from(k) / f64::from(pieces))).collect()
    }
}

/// Angle of a piece of a drawn arc, rad. The chord is within 1e-3 radii of the arc.
const OUTLINE_STEP: f64 = 0.08;

/// Whether a direction from the centre of an arc meets the arc. A whole circle has no ends.
fn opens(half_angle: f64, axis: DVec2, out: DVec2) -> bool {
    half_angle >= PI || out.dot(axis) >= half_angle.cos()
}

/// Contact with a plate, whose two sides are alike.
fn flat(inward: DVec2, height: f64) -> Nearest {
    let outward = if height < 0.0 { -inward } else { inward };
    Nearest { outward, distance: height.abs(), curve: Curve::Flat }
}

/// Contact with an end point. If the centre lies on the point, any fixed normal will do.
fn point(end: DVec2, place: DVec2, inward: DVec2) -> Nearest {
    let from = place - end;
    let distance = from.length();
    let outward = if distance > 0.0 { from / distance } else { inward };
    Nearest { outward, distance, curve: Curve::Round(end) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: DVec2 = DVec2::Y;

    fn plate() -> WallShape {
        WallShape::Segment
    }

    fn cup() -> WallShape {
        WallShape::Arc { centre: DVec2::ZERO, radius: 2.0, axis: -DVec2::Y, half_angle: PI / 4.0 }
    }

    #[test]
    fn a_plate_has_two_sides_and_two_ends() {
        let at = |x, y| plate().nearest(UP, 1.0, DVec2::new(x, y));
        assert_eq!((at(0.5, 0.3).outward, at(0.5, 0.3).distance), (UP, 0.3));
        assert_eq!((at(0.5, -0.3).outward, at(0.5, -0.3).distance), (-UP, 0.3));
        let end = at(1.3, 0.4);
        assert!((end.distance - 0.5).abs() < 1e-15);
        assert!(end.outward.distance(DVec2::new(0.6, 0.8)) < 1e-15);
        assert_eq!(end.curve, Curve::Round(DVec2::X));
        assert_eq!(at(-1.3, 0.4).curve, Curve::Round(-DVec2::X));
    }

    #[test]
    fn an_arc_is_hollow_inside_round_outside_and_ends_at_its_opening() {
        let at = |x, y| cup().nearest(UP, 1.4, DVec2::new(x, y));
        let inside = at(0.0, -1.5);
        assert_eq!((inside.outward, inside.distance), (UP, 0.5));
        assert_eq!(inside.curve, Curve::Hollow(DVec2::ZERO));
        let outside = at(0.0, -2.5);
        assert_eq!((outside.outward, outside.distance), (-UP, 0.5));
        assert_eq!(outside.curve, Curve::Round(DVec2::ZERO));
        let end = DVec2::new(2.0_f64.sqrt(), -(2.0_f64.sqrt()));
        let Nearest { distance, curve: Curve::Round(centre), .. } = at(2.0, 0.0) else {
            panic!("an end point is round")
        };
        assert!(centre.distance(end) < 1e-15);
        assert!((distance - end.distance(DVec2::new(2.0, 0.0))).abs() < 1e-15);
    }

    #[test]
    fn ways_through_a_wall_cross_it() {
        let crosses = |shape: WallShape, a: (f64, f64), b: (f64, f64)| {
            shape.is_crossed(UP, 1.0, [a.into(), b.into()])
        };
        assert!(crosses(plate(), (0.0, 1.0), (0.5, -1.0)));
        assert!(!crosses(plate(), (0.0, 1.0), (0.5, 0.5)));
        assert!(!crosses(plate(), (1.5, 1.0), (1.5, -1.0)));
        assert!(!crosses(WallShape::Line, (0.0, 1.0), (0.0, -1.0)));
        assert!(crosses(cup(), (0.0, 0.0), (0.0, -3.0)));
        assert!(crosses(cup(), (-3.0, -1.8), (3.0, -1.8)), "in and out again");
        assert!(!crosses(cup(), (0.0, 0.0), (0.0, 3.0)), "the opening");
        assert!(!crosses(cup(), (0.0, 0.0), (0.0, -1.9)));
    }
}
