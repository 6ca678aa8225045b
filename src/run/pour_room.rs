//! Room for a grain in an opening: places at which it overlaps no grain and no wall.

use bevy_ecs::prelude::*;
use glam::DVec2;

use clastic_components::prelude::*;

use super::random::Random;
use super::wall_pieces::Piece;
use crate::scene::format::Opening;

/// Minimum gap to other bodies, in radii: far above the round-off of a place, so that no pair
/// overlaps, and far below any length that matters.
const CLEARANCE: f64 = 1e-6;
/// Number of places that are tried in one increment. In a rectangle every try is on another row; on
/// a line all but the first are for walls in the way, since the room among grains is known exactly.
const TRIES: usize = 16;

/// Disks and walls of a world at one moment.
pub(super) struct Room {
    disks: Vec<(DVec2, f64)>,
    walls: Vec<Piece>,
}

impl Room {
    pub(super) fn new(world: &mut World) -> Self {
        let mut disks = world.query::<(&Particle, &BodyPosition)>();
        let disks = disks.iter(world).map(|(disk, place)| (place.0, disk.radius)).collect();
        let mut walls = world.query::<(&Wall, &BodyPosition, Option<&WallShape>)>();
        let walls = walls.iter(world).map(|(wall, x, shape)| Piece {
            position: x.0,
            wall: *wall,
            shape: shape.copied().unwrap_or_default(),
        });
        Self { disks, walls: walls.collect() }
    }

    /// Adds a disk.
    pub(super) fn take(&mut self, place: DVec2, radius: f64) {
        self.disks.push((place, radius));
    }

    /// A place for a grain in an opening, uniform over the room on a row; `None` if none was found.
    pub(super) fn find(
        &self,
        opening: Opening,
        radius: f64,
        mut numbers: impl FnMut() -> Random,
    ) -> Option<DVec2> {
        (0..TRIES).find_map(|_| {
            let mut random = numbers();
            let row = match opening {
                Opening::Segment { start, end } => [start.into(), end.into()],
                Opening::Box { min, max } => {
                    let (min, max) = (DVec2::from(min), DVec2::from(max));
                    let y = random.between(min.y + radius, max.y - radius);
                    [DVec2::new(min.x, y), DVec2::new(max.x, y)]
                }
            };
            let place = self.on_row(row, radius, random.unit())?;
            let clears = |wall: &Piece| wall.distance(place) >= radius * (1.0 + CLEARANCE);
            self.walls.iter().all(clears).then_some(place)
        })
    }

    /// The place at a share (0 to 1) of the room that the disks leave on a row.
    fn on_row(&self, [start, end]: [DVec2; 2], radius: f64, share: f64) -> Option<DVec2> {
        let along = (end - start).normalize_or(DVec2::X);
        let limits = (radius, start.distance(end) - radius);
        // Parts of the row on which the centre would be too near to a disk.
        let mut taken: Vec<(f64, f64)> = self
            .disks
            .iter()
            .filter_map(|(place, other)| {
                let reach = (radius + other) * (1.0 + CLEARANCE);
                let from = *place - start;
                let (at, height) = (from.dot(along), from.perp_dot(along));
                let half = (reach * reach - height * height).sqrt();
                // Not a number where the disk does not reach the row.
                (half > 0.0).then_some((at - half, at + half))
            })
            .collect();
        taken.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut free = Vec::new();
        let mut at = limits.0;
        for (from, to) in taken.into_iter().chain([(limits.1, f64::INFINITY)]) {
            // The last part ends at the limit itself.
            let to_limit = from.min(limits.1);
            if to_limit > at || (to_limit == at && at == limits.1) {
                free.push((at, to_limit));
            }
            at = at.max(to);
            if at > limits.1 {
                break;
            }
        }
        let room: f64 = free.iter().map(|(from, to)| to - from).sum();
        let mut left = share * room;
        let last = *free.last()?;
        for (from, to) in free {
            if left < to - from {
                return Some(start + along * (from + left));
            }
            left -= to - from;
        }
        Some(start + along * last.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW: [DVec2; 2] = [DVec2::ZERO, DVec2::new(10.0, 0.0)];

    fn room(disks: &[(f64, f64, f64)]) -> Room {
        let disks = disks.iter().map(|(x, y, r)| (DVec2::new(*x, *y), *r)).collect();
        Room { disks, walls: Vec::new() }
    }

    #[test]
    fn the_centre_is_anywhere_but_near_a_disk_or_an_end() {
        let disks = [(3.0, 0.0, 0.5), (7.0, 1.2, 1.0), (7.5, -3.0, 0.5)];
        let room = room(&disks);
        for k in 0..=1000 {
            let place = room.on_row(ROW, 1.0, f64::from(k) / 1000.0).unwrap();
            assert!((1.0..=9.0).contains(&place.x) && place.y == 0.0);
            for (x, y, r) in disks {
                assert!(place.distance(DVec2::new(x, y)) >= r + 1.0, "{place}");
            }
        }
        // 1 to 1.5, 4.5 to 5.4 and 8.6 to 9: half of the room ends at 4.9.
        let middle = room.on_row(ROW, 1.0, 0.5).unwrap().x;
        assert!((middle - 4.9).abs() < 1e-4, "{middle}");
    }

    #[test]
    fn a_grain_that_just_fits_has_one_place_and_a_full_row_none() {
        assert_eq!(room(&[]).on_row(ROW, 5.0, 0.3).unwrap().x, 5.0);
        assert_eq!(room(&[]).on_row(ROW, 5.1, 0.3), None);
        assert_eq!(room(&[(5.0, 9.9, 5.0)]).on_row(ROW, 5.0, 0.3), None);
        assert_eq!(room(&[(2.0, 0.0, 2.0), (8.0, 0.0, 2.0)]).on_row(ROW, 1.1, 0.3), None);
    }
}
