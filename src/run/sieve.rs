//! Radii of disks from a sieve curve.

use super::random::Random;

/// Stream of the generator for the order of the radii, apart from that of the places.
const ORDER: u64 = 1;

/// Radii of `count` disks (m) whose masses follow a sieve curve, in a random order.
///
/// The curve has diameters (m), ascending, and the per cent by mass that pass them, from 0 to 100;
/// it is linear in the logarithm of the diameter between its points. The mass of a disk goes with
/// its area, so that between two points the number of disks goes with `d^-3`. The radii are the
/// quantiles of that distribution by number at the middle of `count` equal parts: the packing
/// follows the curve as closely as this number of disks allows.
pub fn radii(passing: &[(f64, f64)], count: u32, seed: u64) -> Vec<f64> {
    let square = |d: f64| d.powi(-2);
    // Number of disks in each step of the curve, up to a common factor.
    let numbers: Vec<f64> = passing
        .windows(2)
        .map(|step| {
            let ((d0, p0), (d1, p1)) = (step[0], step[1]);
            (p1 - p0) / (d1 / d0).ln() * (square(d0) - square(d1))
        })
        .collect();
    let all: f64 = numbers.iter().sum();
    let mut radii: Vec<f64> = (0..count)
        .map(|k| {
            let mut rest = (f64::from(k) + 0.5) / f64::from(count) * all;
            let mut at = 0;
            while at + 1 < numbers.len() && rest > numbers[at] {
                rest -= numbers[at];
                at += 1;
            }
            let [(d0, _), (d1, _)] = [passing[at], passing[at + 1]];
            let part = (rest / numbers[at]).clamp(0.0, 1.0);
            0.5 * (square(d0) - part * (square(d0) - square(d1))).sqrt().recip()
        })
        .collect();
    let mut random = Random::stream(seed, ORDER);
    for k in (1..radii.len()).rev() {
        // The bias of the remainder is below 1e-12 for 5 million disks.
        radii.swap(k, (random.integer() % (k as u64 + 1)) as usize);
    }
    radii
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A well graded sand: 0.6, 1.2, 2.4 and 4.8 mm.
    const SAND: [(f64, f64); 4] = [(0.6e-3, 0.0), (1.2e-3, 25.0), (2.4e-3, 70.0), (4.8e-3, 100.0)];

    /// Per cent by mass of disks below a diameter.
    fn passes(radii: &[f64], diameter: f64) -> f64 {
        let mass = |radii: &mut dyn Iterator<Item = &f64>| radii.map(|r| r * r).sum::<f64>();
        let below = mass(&mut radii.iter().filter(|r| 2.0 * **r < diameter));
        100.0 * below / mass(&mut radii.iter())
    }

    #[test]
    fn the_disks_follow_the_curve() {
        for seed in [5, 71, 902] {
            let disks = radii(&SAND, 4000, seed);
            for (d, wanted) in SAND {
                let found = passes(&disks, d);
                assert!((found - wanted).abs() < 0.3, "{found} % pass {d}, not {wanted} %");
            }
            // Between points the curve is linear in ln d: half of a step at its geometric mean.
            for step in SAND.windows(2) {
                let ((d0, p0), (d1, p1)) = (step[0], step[1]);
                let found = passes(&disks, (d0 * d1).sqrt());
                assert!((found - 0.5 * (p0 + p1)).abs() < 0.3, "{found} %");
            }
        }
        // The order is random, the sizes are not.
        let (mut a, mut b) = (radii(&SAND, 50, 1), radii(&SAND, 50, 2));
        assert_ne!(a, b);
        a.sort_unstable_by(f64::total_cmp);
        b.sort_unstable_by(f64::total_cmp);
        assert_eq!(a, b);
    }

    #[test]
    fn a_step_without_mass_has_no_disk() {
        let gap = [(1.0, 0.0), (2.0, 50.0), (4.0, 50.0), (8.0, 100.0)];
        let disks = radii(&gap, 3000, 1);
        assert!(disks.iter().all(|r| !(2.01..3.99).contains(&(2.0 * r))));
        assert!((passes(&disks, 3.0) - 50.0).abs() < 1.0);
        assert_eq!(radii(&[(1.0, 0.0), (1.5, 100.0)], 1, 1).len(), 1);
    }
}
