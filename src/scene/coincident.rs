//! Particles at the position of another particle.

use std::collections::HashMap;

use crate::text::diagnostic::MAX_SHOWN;

/// Centres closer than this fraction of the smaller radius count as one position.
const ONE_PLACE: f64 = 1e-9;

/// The first `MAX_SHOWN` pairs of disks (x, y, r) at one position: the earlier disk for each later
/// one.
///
/// Larger overlaps are permitted, because an elastic specimen may start compressed.
pub(super) fn coincident(disks: &[(f64, f64, f64)]) -> Vec<(usize, usize)> {
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
            if pairs.len() == MAX_SHOWN {
                break;
            }
        } else {
            cells.entry((cell(x), cell(y))).or_default().push(i);
        }
    }
    pairs
}
