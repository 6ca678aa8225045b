//! Disks for the tests of this folder.

use glam::DVec2;

use super::grid::gap;

/// Splitmix64: small, and the same everywhere.
pub struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in the unit square.
    pub fn point(&mut self) -> DVec2 {
        DVec2::new(self.unit(), self.unit())
    }
}

/// All pairs, by looking at all pairs.
pub(crate) fn brute_force(positions: &[DVec2], radii: &[f64], reach: f64) -> Vec<(u32, u32)> {
    let n = positions.len();
    let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
    let near =
        pairs.filter(|&(i, j)| gap((positions[i], positions[j]), (radii[i], radii[j])) <= reach);
    near.map(|(i, j)| (i as u32, j as u32)).collect()
}

/// Disks anywhere in a square around the origin, with radii from 1/ratio to 1: they may overlap.
pub fn uniform(random: &mut Random, n: usize, side: f64, ratio: f64) -> (Vec<DVec2>, Vec<f64>) {
    let positions = (0..n).map(|_| side * (random.point() - 0.5)).collect();
    (positions, (0..n).map(|_| ratio.powf(-random.unit())).collect())
}

/// Equal disks that touch on a square lattice.
pub fn lattice(columns: u32, spacing: f64) -> (Vec<DVec2>, Vec<f64>) {
    let points = (0..columns * columns)
        .map(|i| spacing * DVec2::new((i % columns).into(), (i / columns).into()));
    (points.collect(), vec![0.5 * spacing; (columns * columns) as usize])
}

/// Disks with radii from 1/ratio to 1, all but the first two set against two others, none
/// overlapping by more than rounding.
pub fn touching(random: &mut Random, n: usize, ratio: f64) -> (Vec<DVec2>, Vec<f64>) {
    let mut positions = vec![DVec2::ZERO, 2.0 * DVec2::X];
    let mut radii = vec![1.0, 1.0];
    while radii.len() < n {
        // Half of them of the extreme sizes, among which the reach of a pair varies most.
        let exponent = [0.0, 1.0, random.unit(), random.unit()][(4.0 * random.unit()) as usize];
        let radius = ratio.powf(-exponent);
        let i = (random.unit() * radii.len() as f64) as usize;
        let j = (random.unit() * radii.len() as f64) as usize;
        let (a, b) = (radii[i] + radius, radii[j] + radius);
        let between = positions[j] - positions[i];
        let distance = between.length();
        if i == j || distance > a + b {
            continue;
        }
        let along = (a * a - b * b + distance * distance) / (2.0 * distance);
        let across = (a * a - along * along).max(0.0).sqrt();
        let position = positions[i] + (along * between + across * between.perp()) / distance;
        if positions.iter().zip(&radii).all(|(x, r)| gap((*x, position), (*r, radius)) > -1e-10) {
            positions.push(position);
            radii.push(radius);
        }
    }
    (positions, radii)
}
