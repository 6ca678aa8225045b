//! Delaunay triangulation of the centres, and the reach up to which it is known to hold every pair
//! of disks.

use glam::DVec2;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::grid::ROUNDING;

/// A centre with the number of its disk: spade merges coincident points and may reorder.
struct Site {
    position: Point2<f64>,
    id: u32,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// Replaces `out` by the edges `i < j` of the Delaunay triangulation of `positions` (m), in no
/// particular order.
///
/// Returns `false`, with `out` empty, if no triangulation contains *all* centres: fewer than three,
/// all on a line, two of them coincident, or one that spade refuses (not finite, or beyond the
/// range of its exact predicates).
pub fn edges(positions: &[DVec2], out: &mut Vec<(u32, u32)>) -> bool {
    out.clear();
    let sites = (0u32..)
        .zip(positions)
        .map(|(id, x)| Site { position: Point2::new(x.x, x.y), id })
        .collect();
    let Ok(triangulation) = DelaunayTriangulation::<Site>::bulk_load(sites) else {
        return false;
    };
    if triangulation.num_vertices() < positions.len() || triangulation.num_inner_faces() == 0 {
        return false;
    }
    out.extend(triangulation.undirected_edges().map(|edge| {
        let [a, b] = edge.vertices().map(|vertex| vertex.data().id);
        (a.min(b), a.max(b))
    }));
    true
}

/// Maximum gap (m) up to which every pair of disks is joined by an edge of *every* Delaunay
/// triangulation of the centres, if no *edge* overlaps by more than `max_overlap` (m, >= 0). `None`
/// if not even all touching pairs are edges.
///
/// With the two largest radii `A >= B`, the smallest `m` and the overlap `o`:
///
/// ```text
/// R = sqrt((A + m - o)² + (B + m - o)²) - A - B
/// ```
///
/// For many disks of one largest radius M that is `√2 (m - o) - (2 - √2) M`: without overlaps,
/// positive while `M / m < 1 + √2`.
///
/// # Proof
///
/// The centres are distinct, or [`edges`] refuses them. Let no *pair* overlap by more than o <= m.
/// If the pair (a, b), of gap g, is not an edge of some Delaunay triangulation, then the closed
/// disk on the diameter ab holds a third centre c (else the edge is Gabriel's, and in every
/// triangulation), from which ab is seen at no less than a right angle:
///
/// ```text
/// (a + b + g)² >= |ca|² + |cb|² >= (a + c - o)² + (b + c - o)² >= (a + m - o)² + (b + m - o)²
/// ```
///
/// so `g >= f(a, b) = sqrt((a + m - o)² + (b + m - o)²) - a - b`. Its derivative by a is
/// `(a + m - o)/sqrt(…) - 1 <= 0`, and likewise by b. f is at its minimum for the two largest
/// disks, and so `g >= R`. Every pair with `g < R` is an edge.
///
/// It suffices that no *edge* overlaps by more than o, if `R >= -o`. Suppose that a pair overlaps
/// by more than o and is no edge. Its disk has a third centre c. If neither (a, c) nor (b, c)
/// overlapped by more than o, the inequalities above would hold and give `g >= R >= -o`, which
/// contradicts the overlap. So one of the two pairs overlaps by more than o, and it is shorter than
/// ab. Repeated, this ends, because the number of pairs is finite. It ends at an edge that overlaps
/// by more than o, which contradicts the condition.
pub fn complete_reach(radii: &[f64], max_overlap: f64) -> Option<f64> {
    let mut smallest = f64::INFINITY;
    let (mut largest, mut second) = (0.0_f64, 0.0_f64);
    for &r in radii {
        if !r.is_finite() {
            return None;
        }
        smallest = smallest.min(r);
        second = second.max(r.min(largest));
        largest = largest.max(r);
    }
    let third = smallest - max_overlap;
    // Written so that NaN fails. Without disks the next check fails.
    if !(max_overlap >= 0.0 && third >= 0.0) {
        return None;
    }
    let sum = largest + second;
    let reach = DVec2::new(largest + third, second + third).length() - sum;
    // Less the possible round-off of this value and of the gaps compared with it. This also makes
    // the inequality strict.
    let reach = reach - ROUNDING * (sum + largest);
    (reach >= 0.0 && reach.is_finite()).then_some(reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detect_contacts::grid::{gap, pairs_within};
    use crate::detect_contacts::test_packings::*;
    use proptest::prelude::*;

    /// Pairs within `reach`, and which of them are no edges.
    fn missed(positions: &[DVec2], radii: &[f64], reach: f64) -> (usize, Vec<(u32, u32)>) {
        let (mut joined, mut near) = (Vec::new(), Vec::new());
        assert!(edges(positions, &mut joined));
        pairs_within(positions, radii, reach, &mut near);
        let all = near.len();
        near.retain(|pair| !joined.contains(pair));
        (all, near)
    }

    #[test]
    fn unusable_sets_are_refused() {
        let refused = |positions: &[DVec2]| {
            let mut out = vec![(7, 7)];
            !edges(positions, &mut out) && out.is_empty()
        };
        let (a, b, c) = (DVec2::ZERO, DVec2::X, DVec2::Y);
        assert!(refused(&[]) && refused(&[a]) && refused(&[a, b]));
        assert!(refused(&[a, b, 2.0 * b, 5.0 * b]), "collinear");
        assert!(refused(&[a, b, c, b]), "coincident");
        assert!(
            refused(&[a, b, c, DVec2::new(f64::NAN, 0.0)]) && refused(&[a, b, c, DVec2::INFINITY])
        );
        assert!(
            refused(&[a, b, c, DVec2::splat(1e300)]) && refused(&[a, b, c, DVec2::splat(1e-300)])
        );
        assert!(!refused(&[a, b, c]));
    }

    #[test]
    fn edges_carry_the_ids_of_their_disks() {
        let mut out = Vec::new();
        assert!(edges(&[DVec2::Y, DVec2::ZERO, 3.0 * DVec2::X, DVec2::new(3.0, 1.5)], &mut out));
        out.sort_unstable();
        assert_eq!(out, [(0, 1), (0, 2), (0, 3), (1, 2), (2, 3)]);
    }

    #[test]
    fn reach_of_known_radii() {
        let reach = |radii: &[f64], overlap| complete_reach(radii, overlap);
        let expected = 2_f64.sqrt() * 0.3 - (2.0 - 2_f64.sqrt()) * 0.6;
        assert!((reach(&[0.3, 0.6, 0.6], 0.0).unwrap() - expected).abs() < 1e-12);
        let silver = 1.0 + 2_f64.sqrt();
        assert!(reach(&[1.0, silver - 1e-6, silver - 1e-6], 0.0).is_some());
        assert_eq!(reach(&[1.0, silver + 1e-6, silver + 1e-6], 0.0), None);
        assert!(reach(&[1.0, 1.0, 1.0, 100.0], 0.0).is_some(), "one large disk among equal ones");
        assert_eq!(reach(&[1.0, 1.0, 1.0], 1.5), None);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
            assert_eq!(reach(&[1.0, 1.0, bad], 0.0), None);
            assert_eq!(reach(&[1.0; 3], bad), None);
        }
        assert_eq!(reach(&[], 0.0), None);
    }

    /// Two large disks with two small ones in the waists between them, each overlapping both by
    /// `overlap`: beyond the reach the triangulation joins the small ones instead.
    #[test]
    fn reach_is_sharp() {
        for (overlap, small) in [(0.0, 1.0), (0.0, 1.7), (0.1, 1.5)] {
            let large = 2.0;
            let radii = [large, large, small, small];
            let bound = complete_reach(&radii, overlap).unwrap();
            for (gap, complete) in [(bound - 1e-9, true), (bound + 1e-9, false)] {
                let half = large + 0.5 * gap;
                let side = large + small - overlap;
                let height = (side * side - half * half).sqrt();
                let (x, y) = (DVec2::new(half, 0.0), DVec2::new(0.0, height));
                let (_, missed) = missed(&[-x, x, -y, y], &radii, gap + 1e-12);
                assert_eq!(!missed.contains(&(0, 1)), complete, "{overlap} {small} {gap}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]

        #[test]
        fn reach_is_sound_in_touching_packings(seed: u64, ratio in 1.0..2.41) {
            let (positions, radii) = touching(&mut Random(seed), 60, ratio);
            let mut joined = Vec::new();
            prop_assert!(edges(&positions, &mut joined));
            if let Some(bound) = complete_reach(&radii, 1e-9) {
                let (near, missed) = missed(&positions, &radii, bound);
                prop_assert!(near > 0 && missed.is_empty());
            }
        }

        /// With the overlap taken from the edges alone, of disks that overlap at random.
        #[test]
        fn overlap_of_edges_bounds_that_of_pairs(seed: u64, ratio in 1.0..2.41, swelling in 0.5..1.6) {
            let (positions, mut radii) = touching(&mut Random(seed), 40, ratio);
            let mut random = Random(!seed);
            for radius in &mut radii {
                *radius *= swelling * (1.0 + 0.1 * random.unit());
            }
            let overlap = |pairs: &[(u32, u32)]| pairs.iter().fold(0.0_f64, |maximum, &(a, b)| {
                let (a, b) = (a as usize, b as usize);
                maximum.max(-gap((positions[a], positions[b]), (radii[a], radii[b])))
            });
            let (mut joined, mut all) = (Vec::new(), Vec::new());
            prop_assert!(edges(&positions, &mut joined));
            pairs_within(&positions, &radii, f64::INFINITY, &mut all);
            if let Some(bound) = complete_reach(&radii, overlap(&joined)) {
                prop_assert_eq!(overlap(&joined), overlap(&all));
                prop_assert!(missed(&positions, &radii, bound).1.is_empty());
            }
        }
    }
}
