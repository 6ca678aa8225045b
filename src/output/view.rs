//! The visible part of a picture: the specimen without its stray disks.
//!
//! A disk that has left the specimen would otherwise shrink everything else in the picture.

use glam::DVec2;

/// Part of the disks at either end of an axis that may be strays.
const STRAY: f64 = 0.01;
/// Minimum distance of a stray from the others, over the extent of the others.
const APART: f64 = 0.25;

/// The range along an axis that shows disks with these lower and upper ends, m: that of all disks
/// but those that are far outside of the inner 98 %. `None` without disks.
pub fn range(mut low: Vec<f64>, mut high: Vec<f64>) -> Option<[f64; 2]> {
    let last = low.len().checked_sub(1)?;
    let strays = (STRAY * last as f64) as usize;
    let inner = [
        *low.select_nth_unstable_by(strays, f64::total_cmp).1,
        *high.select_nth_unstable_by(last - strays, f64::total_cmp).1,
    ];
    let apart = APART * (inner[1] - inner[0]);
    let lowest = low.iter().copied().filter(|x| *x >= inner[0] - apart).fold(inner[0], f64::min);
    let highest = high.iter().copied().filter(|x| *x <= inner[1] + apart).fold(inner[1], f64::max);
    Some([lowest, highest])
}

/// Ends of walls as a picture of disks between two corners shows them: none is farther outside than
/// a stray disk may be.
pub fn near((low, high): (DVec2, DVec2), walls: &[[DVec2; 2]]) -> impl Iterator<Item = DVec2> {
    let apart = APART * (high - low);
    walls.iter().flatten().map(move |x| x.clamp(low - apart, high + apart))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strays_do_not_shrink_the_view_and_nothing_else_is_cut() {
        let ends = |centres: &[f64]| {
            let low = centres.iter().map(|x| x - 0.5).collect();
            range(low, centres.iter().map(|x| x + 0.5).collect())
        };
        let mut centres: Vec<f64> = (0..200).map(f64::from).collect();
        assert_eq!(ends(&centres), Some([-0.5, 199.5]));
        // One that rolls away at the foot belongs to the picture, one that is gone does not.
        centres.push(230.0);
        assert_eq!(ends(&centres), Some([-0.5, 230.5]));
        centres.push(1e4);
        assert_eq!(ends(&centres), Some([-0.5, 230.5]));
        // Of a few disks none is a stray.
        assert_eq!(ends(&[0.0, 1.0, 50.0]), Some([-0.5, 50.5]));
        assert_eq!(ends(&[]), None);
    }
}
