//! Particles at the position of another particle, or behind a wall.

use std::collections::HashMap;

use crate::scene::format::Wall;

/// Centres closer than this fraction of the smaller radius count as one position.
const ONE_PLACE: f64 = 1e-9;

/// Permitted distance of a centre behind a wall, in radii, for rounding in a generated scene.
const BEHIND: f64 = 1e-6;

/// The first pairs of disks (x, y, r) at one position: the earlier disk for each later one.
///
/// Larger overlaps are permitted, because an elastic specimen may start compressed.
pub(in crate::scene) fn coincident(disks: &[(f64, f64, f64)], most: usize) -> Vec<(usize, usize)> {
    let usable = |(x, y, r): (f64, f64, f64)| x.is_finite() && y.is_finite() && r.is_finite();
    let largest = disks.iter().filter(|disk| usable(**disk)).fold(0.0, |r, disk| disk.2.max(r));
    let reach = ONE_PLACE * largest;
    if reach <= 0.0 {
        return Vec::new();
    }
    // The cells are larger than the reach, so that most disks are compared within one cell only.
    let cell = |x: f64| (x / (8.0 * reach)).floor() as i64;
    let mut cells: HashMap<(i64, i64), Vec<usize>> = HashMap::with_capacity(disks.len());
    let mut pairs = Vec::new();
    for (i, &(x, y, r)) in disks.iter().enumerate().filter(|(_, disk)| usable(**disk)) {
        let near = |&j: &usize| {
            let (ox, oy, or) = disks[j];
            (x - ox).hypot(y - oy) < ONE_PLACE * r.min(or)
        };
        let earlier = (cell(x - reach)..=cell(x + reach))
            .flat_map(|a| (cell(y - reach)..=cell(y + reach)).map(move |b| (a, b)))
            .filter_map(|key| cells.get(&key)?.iter().copied().find(near))
            .min();
        if let Some(earlier) = earlier {
            pairs.push((earlier, i));
            if pairs.len() == most {
                break;
            }
        } else {
            cells.entry((cell(x), cell(y))).or_default().push(i);
        }
    }
    pairs
}

/// Spacing of floating-point numbers at a position, m.
pub(super) fn finest((x, y): (f64, f64)) -> f64 {
    f64::EPSILON * x.abs().max(y.abs())
}

/// Whether the centre of a disk is on the outer side of a wall that is a line: also beyond the ends
/// of its drawn segment.
pub(super) fn is_behind(wall: &Wall, (x, y): (f64, f64), radius: f64) -> bool {
    if !wall.shape.is_line() {
        return false;
    }
    let along = (wall.end.0 - wall.start.0, wall.end.1 - wall.start.1);
    let from = (x - wall.start.0, y - wall.start.1);
    let length = along.0.hypot(along.1);
    let inward = (along.0 * from.1 - along.1 * from.0) / length;
    inward < -BEHIND * radius
}
