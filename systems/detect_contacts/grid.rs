//! Exact neighbour search: every pair of disks within a reach of each other.
//!
//! Disks are sorted into classes by size, the disks of a class into horizontal rows as high as its
//! widest pair, and those of a row by x. A disk then looks in two rows of its own class and in
//! three of every coarser one, in a window of x. Only rows with disks in them exist, so memory is
//! O(n) however far the disks are spread.

use std::ops::ControlFlow;

use glam::DVec2;

/// Ratio of the sizes at the two ends of a class. In a wide class small disks search windows that
/// are cut for large ones; narrow classes mean more classes to search. With 2, radii that spread
/// over decades take half as long again, and 4 gains nothing over 3.
const CLASS_RATIO: f64 = 3.0;

/// Disks smaller than this part of the largest share the finest class, which bounds the number of
/// classes.
const FINEST_PART: f64 = 1e-6;

/// Relative allowance for the rounding of a gap, a sum of four terms. A generous value only widens
/// searches.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Gap between two disks, `|xⱼ - xᵢ| - rᵢ - rⱼ` (m): negative where they overlap, NaN where a
/// position is not finite.
///
/// Every search of this folder uses this function, so that all list the same pairs to the last bit.
#[inline]
pub fn gap(positions: (DVec2, DVec2), radii: (f64, f64)) -> f64 {
    // The sum of the radii first: the gap is then the same for (i, j) and (j, i).
    positions.0.distance(positions.1) - (radii.0 + radii.1)
}

/// A disk as the search sees it.
struct Disk {
    /// Class and row, ordered as (class, row); see [`Class::key`].
    key: i64,
    place: DVec2,
    radius: f64,
    id: u32,
}

/// The disks of one class of sizes.
struct Class {
    /// First key of the class.
    base: i64,
    /// Largest radius of the class.
    radius: f64,
    row_height: f64,
    /// Range of its disks in the sorted table.
    begin: usize,
    end: usize,
}

impl Class {
    /// Key of the row that holds the height `y`. The search relies on it never decreasing with `y`,
    /// in floating point too. Heights beyond ±2³¹ rows share the outermost row, which costs time
    /// but loses no pair.
    fn key(&self, y: f64) -> i64 {
        self.base + i64::from((y / self.row_height).floor() as i32)
    }
}

/// All pairs `i < j` with [`gap`] `<= reach`, sorted.
///
/// `positions` and `radii` (m, not negative) are of equal length; `reach` (m) may be negative (deep
/// overlaps only) or infinite (all pairs). A disk whose position or radius is not finite is in no
/// pair.
pub fn pairs_within(positions: &[DVec2], radii: &[f64], reach: f64) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    let _ = visit_pairs(positions, radii, reach, |pair| {
        pairs.push(pair);
        ControlFlow::Continue(())
    });
    pairs.sort_unstable();
    pairs
}

/// Number of the pairs that [`pairs_within`] lists, up to `most`. Memory stays O(n) even if the
/// list of pairs would not fit into it.
pub fn count_within(positions: &[DVec2], radii: &[f64], reach: f64, most: usize) -> usize {
    let mut count = 0;
    let _ = visit_pairs(positions, radii, reach, |_| {
        count += 1;
        if count < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    count.min(most)
}

/// Shows every pair to `visit`, until it breaks off.
fn visit_pairs(
    positions: &[DVec2],
    radii: &[f64],
    reach: f64,
    mut visit: impl FnMut((u32, u32)) -> ControlFlow<()>,
) -> ControlFlow<()> {
    debug_assert_eq!(positions.len(), radii.len());
    if reach.is_nan() || reach == f64::NEG_INFINITY {
        return ControlFlow::Continue(()); // no gap is within it, and no window can be made of it
    }
    let (disks, classes) = classify(positions, radii, reach);

    for (c, class) in classes.iter().enumerate() {
        let own = &disks[class.begin..class.end];
        let mut above = 0;
        for (i, disk) in own.iter().enumerate() {
            // A pair of one class is met once, from the earlier disk of the table: later in its
            // row, or in the next row, through which the window slides as the disks come in order.
            let width = width(disk.radius + class.radius, reach);
            meet(disk, &own[i + 1..], disk.key, width, reach, &mut visit)?;
            let window = (disk.key + 1, disk.place.x - class.row_height);
            while own.get(above).is_some_and(|d| (d.key, d.place.x) < window) {
                above += 1;
            }
            meet(disk, &own[above..], disk.key + 1, width, reach, &mut visit)?;
        }
        for coarser in &classes[c + 1..] {
            let rows = &disks[coarser.begin..coarser.end];
            for disk in own {
                let width = width(disk.radius + coarser.radius, reach);
                let DVec2 { x, y } = disk.place;
                for key in coarser.key(y - width)..=coarser.key(y + width) {
                    let first = rows.partition_point(|d| (d.key, d.place.x) < (key, x - width));
                    meet(disk, &rows[first..], key, width, reach, &mut visit)?;
                }
            }
        }
    }
    ControlFlow::Continue(())
}

/// Maximum distance along x or y of two disks whose radii sum to `radii` and whose gap, as
/// rounded, is within `reach`.
fn width(radii: f64, reach: f64) -> f64 {
    radii + reach + ROUNDING * (radii + reach.abs())
}

/// Visits the pairs of `disk` with the disks at the head of `rows` that are in the row `key` and
/// within `width`.
#[inline]
fn meet(
    disk: &Disk,
    rows: &[Disk],
    key: i64,
    width: f64,
    reach: f64,
    visit: &mut impl FnMut((u32, u32)) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let right = disk.place.x + width;
    for other in rows.iter().take_while(|d| d.key == key && d.place.x <= right) {
        if gap((disk.place, other.place), (disk.radius, other.radius)) <= reach {
            visit((disk.id.min(other.id), disk.id.max(other.id)))?;
        }
    }
    ControlFlow::Continue(())
}

/// Table of the disks, sorted by class, row and x, and the classes from the finest to the coarsest.
fn classify(positions: &[DVec2], radii: &[f64], reach: f64) -> (Vec<Disk>, Vec<Class>) {
    // Half of the reach is added to each disk: where the reach is much larger than the radii, one
    // class is best.
    let size = |radius: f64| radius + 0.5 * reach;
    let usable = || {
        let disks = (0u32..).zip(positions).zip(radii);
        disks.filter(|((_, x), r)| x.is_finite() && r.is_finite()).map(|((id, x), r)| (id, *x, *r))
    };
    let (smallest, largest) = usable()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, _, r)| {
            (size(r).min(low), size(r).max(high))
        });
    let mut limits = vec![smallest.max(largest * FINEST_PART)];
    while let Some(&last) = limits.last()
        && last * CLASS_RATIO < largest
    {
        limits.push(last * CLASS_RATIO);
    }

    let class_of = |radius: f64| limits[1..].partition_point(|limit| *limit <= size(radius));
    let mut classes: Vec<Class> = (0..limits.len() as i64)
        .map(|c| Class { base: c << 33, radius: 0.0, row_height: 0.0, begin: 0, end: 0 })
        .collect();
    for (_, _, r) in usable() {
        let class = &mut classes[class_of(r)];
        class.radius = class.radius.max(r);
        class.end += 1;
    }
    let mut begin = 0;
    for class in &mut classes {
        (class.begin, class.end) = (begin, begin + class.end);
        begin = class.end;
        // The widest pair takes up less than a row. The difference exceeds the round-off of a
        // height divided by the height of a row, up to 2³¹ rows. So the pair never reaches beyond
        // the next row.
        class.row_height = (width(2.0 * class.radius, reach) * (1.0 + 1e-5)).max(f64::MIN_POSITIVE);
    }

    let mut disks: Vec<Disk> = usable()
        .map(|(id, place, radius)| Disk {
            key: classes[class_of(radius)].key(place.y),
            place,
            radius,
            id,
        })
        .collect();
    disks.sort_unstable_by(|a, b| a.key.cmp(&b.key).then(a.place.x.total_cmp(&b.place.x)));
    classes.retain(|class| class.begin < class.end);
    (disks, classes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detect_contacts::tests::*;
    use proptest::prelude::*;

    fn check(positions: &[DVec2], radii: &[f64], reach: f64) -> usize {
        let found = pairs_within(positions, radii, reach);
        assert_eq!(found, brute_force(positions, radii, reach));
        assert_eq!(count_within(positions, radii, reach, usize::MAX), found.len());
        assert_eq!(count_within(positions, radii, reach, 7), found.len().min(7));
        found.len()
    }

    #[test]
    fn few_disks() {
        assert_eq!(check(&[], &[], 1.0), 0);
        assert_eq!(check(&[DVec2::ONE], &[1.0], 1.0), 0);
        assert_eq!(check(&[DVec2::ONE, DVec2::new(4.0, 1.0)], &[1.0, 1.5], 0.5), 1);
        assert_eq!(check(&[DVec2::ONE, DVec2::new(4.0, 1.0)], &[1.0, 1.5], 0.49), 0);
    }

    #[test]
    fn degenerate_sets() {
        assert_eq!(check(&[DVec2::ONE; 9], &[0.5; 9], 0.0), 36);
        assert_eq!(check(&[DVec2::ONE; 9], &[0.0; 9], 0.0), 36);
        for direction in [DVec2::X, DVec2::Y, DVec2::new(0.6, 0.8), DVec2::NEG_Y] {
            let line: Vec<_> = (0..50).map(|i| f64::from(i) * direction).collect();
            assert_eq!(check(&line, &[0.5; 50], 1e-9), 49);
        }
        let (positions, radii) = lattice(12, 1.0);
        assert_eq!(check(&positions, &radii, 0.0), 2 * 12 * 11);
        assert_eq!(check(&positions, &radii, 0.5), 2 * 12 * 11 + 2 * 11 * 11);
    }

    #[test]
    fn reaches_of_every_kind() {
        let (positions, radii) = uniform(&mut Random(5), 60, 10.0, 3.0);
        assert_eq!(check(&positions, &radii, f64::INFINITY), 60 * 59 / 2);
        for none in [f64::NAN, f64::NEG_INFINITY, -1e3] {
            assert_eq!(check(&positions, &radii, none), 0);
        }
        assert!(check(&positions, &radii, -0.5) > 0);
    }

    #[test]
    fn disks_that_are_not_finite_are_in_no_pair() {
        let (mut positions, mut radii) = lattice(4, 1.0);
        positions[3].x = f64::NAN;
        positions[12].x = -f64::NAN; // sorts before all numbers
        positions[7].y = f64::INFINITY;
        radii[9] = f64::NAN;
        let found = pairs_within(&positions, &radii, 1.0);
        assert!(
            !found.is_empty()
                && found.iter().all(|(a, b)| [3, 7, 9, 12].iter().all(|i| a != i && b != i))
        );
        check(&positions, &radii, 1.0);
    }

    /// Clusters so far apart, and so far out, that rows and the numbers themselves run out.
    #[test]
    fn clusters_at_any_distance() {
        for far in [1e6, 1e10, 1e15, 1e18, 1e300, f64::MAX] {
            let (mut positions, radii) = uniform(&mut Random(3), 120, 8.0, 10.0);
            for (i, position) in positions.iter_mut().enumerate() {
                *position += far * [DVec2::ZERO, DVec2::NEG_ONE, DVec2::ONE][i % 3];
            }
            assert!(check(&positions, &radii, 0.1) > 0);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]

        #[test]
        fn agrees_with_brute_force(
            seed: u64, n in 0..200_usize, ratio in 1.0..100.0, extent in -1.0..6.0, reach in -0.5..2.0,
        ) {
            let (positions, radii) = uniform(&mut Random(seed), n, 10_f64.powf(extent), ratio);
            check(&positions, &radii, reach);
        }

        /// Gaps of exactly the reach, on the borders of rows.
        #[test]
        fn agrees_on_borders(columns in 1..12_u32, spacing in 0.1..10.0, steps in 0..4_u32) {
            let (positions, radii) = lattice(columns, spacing);
            check(&positions, &radii, f64::from(steps) * spacing);
        }

        /// Equal numbers of disks per area at every scale of 1:100: every class is in use.
        #[test]
        fn agrees_across_classes(seed: u64, reach in 0.0..0.5) {
            let mut random = Random(seed);
            let radii: Vec<f64> = (0..300).map(|_| 0.05 * 100_f64.powf(random.unit())).collect();
            let positions: Vec<_> = radii.iter().map(|_| 30.0 * random.point()).collect();
            check(&positions, &radii, reach);
        }
    }
}
