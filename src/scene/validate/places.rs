//! Particles that are where something else is.

use std::collections::HashMap;

use crate::scene::format::Wall;

/// Centres closer than this fraction of the smaller radius are one place.
const ONE_PLACE: f64 = 1e-9;

/// How far behind a wall a centre may be, in radii: rounding in a generated scene.
const BEHIND: f64 = 1e-6;

/// The first pairs of disks (x, y, r) at one place: for each later disk the earlier one.
///
/// Larger overlaps are legitimate: an elastic specimen may start compressed.
pub(in crate::scene) fn coincident(disks: &[(f64, f64, f64)], most: usize) -> Vec<(usize, usize)> {
    let usable = |(x, y, r): (f64, f64, f64)| x.is_finite() && y.is_finite() && r.is_finite();
    let largest = disks.iter().filter(|disk| usable(**disk)).fold(0.0, |r, disk| disk.2.max(r));
    let reach = ONE_PLACE * largest;
    if reach <= 0.0 {
        return Vec::new();
    }
    // Cells somewhat larger than the reach: mostly a disk meets its own cell only.
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

/// Distance of neighbouring numbers at a place, m.
pub(super) fn finest((x, y): (f64, f64)) -> f64 {
    f64::EPSILON * x.abs().max(y.abs())
}

/// Whether a disk's centre lies on the outer side of a wall. For contact a wall is an infinite line:
/// beyond the ends of its drawn segment as well.
pub(super) fn is_behind(wall: &Wall, (x, y): (f64, f64), radius: f64) -> bool {
    let along = (wall.end.0 - wall.start.0, wall.end.1 - wall.start.1);
    let from = (x - wall.start.0, y - wall.start.1);
    let length = along.0.hypot(along.1);
    let inward = (along.0 * from.1 - along.1 * from.0) / length;
    inward < -BEHIND * radius
}
