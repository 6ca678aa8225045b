//! Walls that come at the outermost particles, so that a rig fits a specimen whose outline is not
//! known beforehand: one that was cut out of a packing.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use super::disks::ends;
use super::wall_pieces::{Piece, moved, pieces};
use crate::scene::format as scene;

/// Gap at which a wall touches a particle, over the radius of the particle.
///
/// 1e-9: far below the overlaps of elastic contacts and far above the round-off of places.
const TOUCHES: f64 = 1e-9;

/// The wall, moved along its inward normal from the outside until it touches the first particle.
/// The normal is on the left of the way from its start to its end. `None` if it meets no particle.
pub(super) fn placed(world: &mut World, wall: &scene::Wall) -> Option<scene::Wall> {
    let mut particles = world.query::<(&Particle, &BodyPosition)>();
    let disks: Vec<_> = particles.iter(world).map(|(p, x)| (x.0, p.radius)).collect();
    let by = travel(wall, &disks)?;
    Some(moved(wall, DVec2::ZERO, DVec2::X, by))
}

/// Vector from the drawn place to that at which the wall touches. The wall advances by its distance
/// from the nearest disk, so that it reaches none before the last step.
fn travel(wall: &scene::Wall, disks: &[(DVec2, f64)]) -> Option<DVec2> {
    let (start, end) = (DVec2::from(wall.start), DVec2::from(wall.end));
    let inward = (end - start).perp().try_normalize()?;
    let pieces = pieces(wall);
    let gap = |travel: f64| {
        let gaps = disks.iter().flat_map(|(place, radius)| {
            pieces
                .iter()
                .map(move |piece| (piece.distance(*place - travel * inward) - radius, *radius))
        });
        gaps.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    // From a place where no part of the wall reaches the lowest disk, to one beyond the highest.
    let along = |x: DVec2| x.dot(inward);
    let (wall_low, wall_high) =
        ends(pieces.iter().map(|piece| (along(piece.position), reach(piece))))?;
    let (low, high) = ends(disks.iter().map(|(x, radius)| (along(*x), *radius)))?;
    let mut travel = low - wall_high - (high - low);
    while travel <= high - wall_low {
        let (gap, radius) = gap(travel)?;
        if gap <= TOUCHES * radius {
            return Some(travel * inward);
        }
        travel += gap;
    }
    None
}

/// Maximum distance of a part of the piece from its position, m. The drawn part of a line touches
/// like the rest of it, which is all at the same height.
fn reach(piece: &Piece) -> f64 {
    match piece.shape {
        WallShape::Line => 0.0,
        WallShape::Segment => piece.wall.half_length,
        WallShape::Arc { radius, .. } => 2.0 * radius,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::wall_pieces::tests::drawn as wall;

    const DISKS: [(DVec2, f64); 3] =
        [(DVec2::new(0.0, 0.0), 1.0), (DVec2::new(3.0, 0.5), 0.5), (DVec2::new(9.0, -2.0), 1.5)];

    /// A line touches the disk that reaches farthest, whether it is drawn outside or within.
    #[test]
    fn a_line_touches_the_outermost_disk() {
        for y in [-50.0, 0.2, 3.0] {
            let line = wall((-1.0, y), (1.0, y), scene::WallShape::Line);
            let by = travel(&line, &DISKS).unwrap();
            assert!(by.x.abs() < 1e-12 && (y + by.y + 3.5).abs() < 1e-8, "{y}: {by}");
        }
    }

    /// A segment passes beside the lowest disk, and one that no disk is above meets none.
    #[test]
    fn a_segment_touches_what_is_above_it() {
        let segment = wall((2.0, 7.0), (4.0, 7.0), scene::WallShape::Segment);
        let by = travel(&segment, &DISKS).unwrap();
        assert!((7.0 + by.y).abs() < 1e-8, "{by}");
        let beside = wall((20.0, 0.0), (22.0, 0.0), scene::WallShape::Segment);
        assert_eq!(travel(&beside, &DISKS), None);
    }

    /// The end of an inclined segment meets a disk at its side: their distance is the radius.
    #[test]
    fn the_end_of_a_segment_meets_a_disk_at_its_side() {
        let segment = wall((-3.0, -9.0), (-0.6, -9.0), scene::WallShape::Segment);
        let by = travel(&segment, &DISKS[..1]).unwrap();
        // At x = -0.6 the unit circle is at y = -0.8.
        assert!((-9.0 + by.y + 0.8).abs() < 1e-7, "{by}");
    }

    /// A deep bell above the disks comes down over them until it touches the highest.
    #[test]
    fn a_deep_polyline_touches_with_its_roof() {
        let shape = scene::WallShape::Polyline(vec![(20.0, 90.0), (-20.0, 90.0)]);
        let bell = wall((20.0, 10.0), (-20.0, 10.0), shape);
        let by = travel(&bell, &DISKS).unwrap();
        assert!((90.0 + by.y - 1.0).abs() < 1e-8, "{by}");
    }

    /// A hollow jaw whose radius is greater than that of the disk touches it in the middle.
    #[test]
    fn a_jaw_touches_a_disk_in_the_middle() {
        let arc = scene::WallShape::Arc { through: (0.0, -9.0) };
        let jaw = wall((-1.0, -8.7), (1.0, -8.7), arc);
        let by = travel(&jaw, &DISKS[..1]).unwrap();
        assert!((-9.0 + by.y + 1.0).abs() < 1e-8, "{by}");
    }
}
