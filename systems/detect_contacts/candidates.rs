//! Candidate pairs of disks, kept from one increment to the next while the disks move little (a
//! Verlet list).

use bevy_ecs::prelude::*;
use glam::DVec2;

use super::grid::{self, ROUNDING};

/// Skin of the list, mean radii.
///
/// 0.1: a thicker skin means fewer rebuilds and a longer list.
const SKIN: f64 = 0.1;
/// Maximum width of a complete list beyond what is asked for, mean radii. A wider one is rebuilt.
///
/// 1: after one violent increment all quiet ones would otherwise go through its many pairs.
const MAX_EXCESS: f64 = 1.0;

/// Pairs of disks that are, or may soon be, within reach of each other.
///
/// The list is built with a *skin*: it holds every pair with gap <= reach + skin. It therefore
/// holds every pair with gap <= reach until two disks have together moved farther than the skin.
/// Which of its pairs are within reach does not depend on when it was built, so that a resumed run
/// finds the pairs of an uninterrupted one.
#[derive(Resource, Clone, Debug, Default)]
pub struct CandidatePairs {
    pairs: Vec<(u32, u32)>,
    /// Reach (m) that the list was complete to when it was built, skin included.
    built_reach: f64,
    built_positions: Vec<DVec2>,
    built_radii: Vec<f64>,
    mean_radius: f64,
}

impl CandidatePairs {
    /// Makes sure that every pair with gap <= `reach` (m) is listed, and returns whether the list
    /// had to be rebuilt.
    ///
    /// It is rebuilt if it may not be [complete](Self::is_complete), or if it is much wider than
    /// `reach`. A disk is in no pair while its position or radius is not finite.
    pub fn ensure(&mut self, positions: &[DVec2], radii: &[f64], reach: f64) -> bool {
        let excess = self.built_reach - reach - SKIN * self.mean_radius;
        let too_wide = excess > MAX_EXCESS * self.mean_radius;
        if !too_wide && self.is_complete(positions, radii, reach) {
            return false;
        }
        self.rebuild(positions, radii, reach);
        true
    }

    /// The listed pairs `(a, b)`, `a < b`, sorted.
    pub fn pairs(&self) -> &[(u32, u32)] {
        &self.pairs
    }

    /// Whether every pair with gap <= `reach` (m) at these positions is certainly listed. This
    /// holds if the list was built for these disks and `reach + d₁ + d₂` is at most the reach that
    /// it was built for. d₁ and d₂ are the two largest displacements since then: no gap has closed
    /// by more than their sum.
    pub fn is_complete(&self, positions: &[DVec2], radii: &[f64], reach: f64) -> bool {
        positions.len() == self.built_positions.len()
            && radii == self.built_radii
            && reach + max_approach(&self.built_positions, positions) <= self.built_reach
    }

    /// The listed pairs with gap <= `reach` (m) at these positions, sorted. These are all such
    /// pairs if the list [is complete](Self::is_complete) there.
    pub fn within(
        &self,
        positions: &[DVec2],
        radii: &[f64],
        reach: f64,
    ) -> impl Iterator<Item = (u32, u32)> {
        self.pairs.iter().copied().filter(move |&pair| gap(positions, radii, pair) <= reach)
    }

    fn rebuild(&mut self, positions: &[DVec2], radii: &[f64], reach: f64) {
        // A disk without a finite radius is in no pair, and must not spoil the skin of the others.
        let usable = || radii.iter().copied().filter(|r| r.is_finite());
        self.mean_radius = usable().sum::<f64>() / usable().count().max(1) as f64;
        let skin = SKIN * self.mean_radius;
        // The list reaches farther than stated, by the possible round-off of gaps and
        // displacements.
        let largest = usable().fold(0.0, f64::max);
        let guard = ROUNDING * (2.0 * largest + reach.abs() + skin);
        self.built_reach = reach + skin;
        self.pairs = grid::pairs_within(positions, radii, self.built_reach + guard);
        self.built_positions = positions.to_vec();
        self.built_radii = radii.to_vec();
    }
}

fn gap(positions: &[DVec2], radii: &[f64], (a, b): (u32, u32)) -> f64 {
    let (a, b) = (a as usize, b as usize);
    grid::gap((positions[a], positions[b]), (radii[a], radii[b]))
}

/// Sum of the two largest displacements (m): no gap can have closed by more. Infinite where a disk
/// has come back from a position that was not finite.
fn max_approach(before: &[DVec2], now: &[DVec2]) -> f64 {
    let (mut first, mut second) = (0.0_f64, 0.0_f64);
    for (before, now) in before.iter().zip(now) {
        let squared = if now.is_finite() { (now - before).length_squared() } else { 0.0 };
        let squared = if squared.is_nan() { f64::INFINITY } else { squared };
        second = second.max(squared.min(first));
        first = first.max(squared);
    }
    first.sqrt() + second.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detect_contacts::tests::*;
    use proptest::prelude::*;

    /// Brings the list up to date and checks it against all pairs.
    fn check(list: &mut CandidatePairs, positions: &[DVec2], radii: &[f64], reach: f64) -> bool {
        let rebuilt = list.ensure(positions, radii, reach);
        let near: Vec<_> = list.within(positions, radii, reach).collect();
        assert_eq!(near, brute_force(positions, radii, reach));
        assert!(list.pairs().is_sorted() && list.pairs().iter().all(|(a, b)| a < b));
        rebuilt
    }

    #[test]
    fn built_once_while_nothing_moves() {
        let (positions, radii) = lattice(10, 1.0);
        let mut list = CandidatePairs::default();
        assert!(check(&mut list, &positions, &radii, 0.05));
        for _ in 0..3 {
            assert!(!check(&mut list, &positions, &radii, 0.05));
        }
    }

    #[test]
    fn rebuilt_when_the_disks_are_others() {
        let (mut positions, mut radii) = lattice(6, 1.0);
        let mut list = CandidatePairs::default();
        assert!(check(&mut list, &positions, &radii, 0.05));
        radii[4] *= 1.5;
        assert!(check(&mut list, &positions, &radii, 0.05));
        radii.pop();
        positions.pop();
        assert!(check(&mut list, &positions, &radii, 0.05));
        assert!(check(&mut list, &[], &[], 0.05));
        assert!(!check(&mut list, &[], &[], 0.05));
    }

    #[test]
    fn rebuilt_when_the_reach_outgrows_the_skin() {
        let (positions, radii) = lattice(6, 1.0);
        let mut list = CandidatePairs::default();
        check(&mut list, &positions, &radii, 0.05);
        assert!(!check(&mut list, &positions, &radii, 0.09));
        assert!(check(&mut list, &positions, &radii, 0.2));
        assert!(!check(&mut list, &positions, &radii, 0.05), "a wider list stays good");
    }

    #[test]
    fn a_radius_that_is_not_finite_spoils_no_other_pair() {
        let (positions, mut radii) = lattice(5, 1.0);
        for bad in [f64::NAN, f64::INFINITY] {
            radii[7] = bad;
            let mut list = CandidatePairs::default();
            list.ensure(&positions, &radii, 0.05);
            assert_eq!(list.pairs().len(), 2 * 5 * 4 - 4);
        }
    }

    #[test]
    fn rebuilt_when_much_too_wide() {
        let (positions, radii) = lattice(6, 1.0);
        let mut list = CandidatePairs::default();
        check(&mut list, &positions, &radii, 3.0);
        let wide = list.pairs().len();
        assert!(check(&mut list, &positions, &radii, 0.05));
        assert!(list.pairs().len() < wide / 4);
        assert!(check(&mut list, &positions, &radii, f64::INFINITY));
        assert!(!check(&mut list, &positions, &radii, f64::INFINITY));
        assert!(check(&mut list, &positions, &radii, 0.05));
    }

    #[test]
    fn disks_lost_and_found() {
        let (mut positions, radii) = lattice(5, 1.0);
        let mut list = CandidatePairs::default();
        let home = positions[7];
        for position in [home, DVec2::NAN, home, DVec2::INFINITY, home + 0.01, home] {
            positions[7] = position;
            check(&mut list, &positions, &radii, 0.05);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        /// Random walks, with now and then a leap.
        #[test]
        fn no_pair_is_missed_in_motion(
            seed: u64, ratio in 1.0..4.0, step in -4.0..0.0, reach in 0.0..0.3,
        ) {
            let mut random = Random(seed);
            let (mut positions, radii) = touching(&mut random, 50, ratio);
            let (mut list, mut rebuilds) = (CandidatePairs::default(), 0);
            for _ in 0..30 {
                rebuilds += u32::from(check(&mut list, &positions, &radii, reach));
                let leap = if random.unit() < 0.1 { 10.0 } else { 1.0 };
                for position in &mut positions {
                    *position += leap * 10_f64.powf(step) * (random.point() - 0.5);
                }
            }
            check(&mut list, &positions, &radii, reach);
            prop_assert!(step > -3.0 || rebuilds <= 3);
        }

        /// Two disks head on, the fastest way to use up a skin, beside one at rest.
        #[test]
        fn no_pair_is_missed_head_on(step in 1e-3..0.1, reach in 0.0..0.2) {
            let mut list = CandidatePairs::default();
            for i in 0..200 {
                let x = DVec2::new(3.0 - f64::from(i) * step, 0.0);
                check(&mut list, &[-x, x, 9.0 * DVec2::Y], &[0.5; 3], reach);
            }
        }
    }
}
