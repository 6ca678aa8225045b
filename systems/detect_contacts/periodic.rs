//! Pairs of disks in a periodic cell, with the images of disks near its sides.

use clastic_components::cell::PeriodicCell;
use glam::DVec2;

use super::grid;

/// All pairs `a < b` of which the nearest images have a gap of at most `reach`, m, sorted. The
/// reach ends where a pair could have two images within it.
pub fn pairs_within(
    cell: &PeriodicCell,
    positions: &[DVec2],
    radii: &[f64],
    reach: f64,
) -> Vec<(u32, u32)> {
    let largest = radii.iter().copied().fold(0.0, f64::max);
    let reach = reach.min(cell.max_branch() - 2.0 * largest);
    let margin = 2.0 * largest + reach;
    let n = positions.len();
    let mut of: Vec<u32> = (0..n as u32).collect();
    let mut places: Vec<DVec2> = positions.iter().map(|x| cell.wrapped(*x)).collect();
    let mut sizes = radii[..n].to_vec();
    for i in 0..n {
        for row in [-1.0, 0.0, 1.0] {
            let y = places[i].y + row * cell.height;
            if y < -margin || y > cell.height + margin {
                continue;
            }
            let x = places[i].x + row * cell.tilt;
            let x = x - (x / cell.width).floor() * cell.width;
            for column in [-1.0, 0.0, 1.0] {
                let image = DVec2::new(x + column * cell.width, y);
                let is_itself = row == 0.0 && column == 0.0;
                if !is_itself && image.x >= -margin && image.x <= cell.width + margin {
                    of.push(i as u32);
                    places.push(image);
                    sizes.push(radii[i]);
                }
            }
        }
    }
    let mut pairs = grid::pairs_within(&places, &sizes, reach);
    pairs.retain_mut(|(a, b)| {
        let own = (*a as usize) < n || (*b as usize) < n;
        let (x, y) = (of[*a as usize], of[*b as usize]);
        (*a, *b) = (x.min(y), x.max(y));
        own && x != y
    });
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detect_contacts::tests::{Random, uniform};
    use clastic_components::cell::CellControl;

    /// In cells of any tilt, with disks anywhere, the pairs are those of the nearest images.
    #[test]
    fn all_pairs_of_nearest_images() {
        for (seed, tilt) in [(1, 0.0), (2, 3.3), (3, -25.0)] {
            let cell = PeriodicCell {
                width: 12.0,
                height: 10.0,
                tilt,
                shear: 0.0,
                stress: [0.0; 3],
                controls: [CellControl::default(); 3],
                by_mean: false,
            };
            let (positions, radii) = uniform(&mut Random(seed), 60, 40.0, 2.0);
            let radii: Vec<f64> = radii.iter().map(|r| r / radii[0].max(1.0)).collect();
            let largest = radii.iter().copied().fold(0.0, f64::max);
            let reach = 4.9 - 2.0 * largest;
            let mut all = Vec::new();
            for a in 0..60_u32 {
                for b in a + 1..60 {
                    let (i, j) = (a as usize, b as usize);
                    let apart = positions[j] - positions[i];
                    let gap = (apart + cell.shift(apart)).length() - radii[i] - radii[j];
                    if gap <= reach {
                        all.push((a, b));
                    }
                }
            }
            assert!(!all.is_empty());
            assert_eq!(pairs_within(&cell, &positions, &radii, reach), all);
        }
    }
}
