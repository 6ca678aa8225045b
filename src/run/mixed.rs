//! Start positions in a periodic cell: a grid of disks, mixed until it has no order left.
//!
//! A cell shrinks in the same proportion along all directions and has no walls, so that a packing in it keeps
//! the order of its start. The disks move as those of a hard-disk liquid: each in turn by a random step,
//! unless it would overlap another one there (Metropolis et al. 1953, J. Chem. Phys. 21, 1087-1092).

use clastic_components::cell::PeriodicCell;
use clastic_systems::detect_contacts::periodic::pairs_within;
use glam::DVec2;

use super::random::Random;

/// Number of steps of each disk. Half of them leave directions of neighbours by chance where the spacing is
/// 1.2 maximum diameters and radii are spread by 1 : 1.7 or more.
const STEPS: usize = 100;
/// Maximum step along an axis, over the mean gap of the grid. A third of such steps is free.
const REACH: f64 = 1.5;

/// Moves disks at `places`, m, of these radii, m, and puts them into the cell.
pub(super) fn mix(cell: &PeriodicCell, radii: &[f64], places: &mut [DVec2], random: &mut Random) {
    let largest = radii.iter().copied().fold(0.0, f64::max);
    let count = radii.len().max(1) as f64;
    let mean = radii.iter().sum::<f64>() / count;
    let step = REACH * ((cell.area() / count).sqrt() - 2.0 * mean);
    // Two disks approach by up to two diagonals of a step in a sweep, and have one image within reach.
    let approach = 8.0_f64.sqrt();
    let step = step.min((cell.max_branch() - 2.0 * largest) / approach).max(0.0);
    for _ in 0..STEPS {
        let mut near = vec![Vec::new(); places.len()];
        for (a, b) in pairs_within(cell, places, radii, approach * step) {
            near[a as usize].push(b as usize);
            near[b as usize].push(a as usize);
        }
        for i in 0..places.len() {
            let by = DVec2::new(random.between(-step, step), random.between(-step, step));
            let to = cell.wrapped(places[i] + by);
            let is_free = |j: &usize| {
                let apart = places[*j] - to;
                (apart + cell.shift(apart)).length_squared() >= (radii[i] + radii[*j]).powi(2)
            };
            if near[i].iter().all(is_free) {
                places[i] = to;
            }
        }
    }
}
