//! Definitions of the key results: Poisson's ratio, strength, thresholds of cracks, friction angle.

use super::collected::{KeyResults, Point};
use super::definitions::{CAPPED_BEFORE, LATERAL_CHANGES, NO_GAIN, NO_HALF, RESOLVED, RIGID};

/// Fall of the axial stress below its peak, over the rise to it, after which the peak is passed.
/// Stresses of a specimen of some hundred grains fluctuate by less before it.
const PASSED: f64 = 0.01;
/// The same fall at the strain of the peak itself. Bonds that finish to break at the end of an increment take
/// up to 3 % of the rise before a test has passed its peak.
const PASSED_AT_ONCE: f64 = 0.1;
/// Relative difference of a strain to that of the peak, up to which a cycle has returned to it.
const RETURNS: f64 = 1e-9;
/// Maximum change of a constant lateral stress, over the change of the axial stress. A confining stress that is less,
/// as that of a plate that lifts off, is none.
const STAYS: f64 = 0.01;
/// Minimum number of broken bonds of which a hundredth is one.
const ENOUGH_CRACKS: usize = 100;
/// Part of the axial strain over which the residual strength is a mean.
const LAST: f64 = 0.2;
/// The mean begins beyond this many times the strain at the peak.
const BEYOND: f64 = 2.0;
/// Difference of the means over the two halves of that part, over the rise to the peak, up to which
/// the stress is level.
const LEVEL: f64 = 0.1;

const NOT_PASSED: &str = "the test ends before the axial stress has fallen by a hundredth of its \
                          rise without unloading, and without a collapse";
const NO_LATERAL_STRAIN: &str = "no lateral strain is measured";
const NO_BONDS: &str = "the specimen has no bonds";
const NOTHING_BROKE: &str =
    "no bond has broken: the stress was taken away, or grains without bonds gave way";
const CONTRACTS: &str = "the volume shrinks up to the peak";

impl KeyResults {
    pub(super) fn poissons_ratio(&self, peak: f64) -> Result<f64, &'static str> {
        if self.rigid {
            return Err(RIGID);
        }
        let (from, _, _) = self.first_gain(peak).ok_or(NO_GAIN)?;
        let (before, here, part) = self.half_way(peak).ok_or(NO_HALF)?;
        if !from.solved {
            return Err(CAPPED_BEFORE);
        }
        self.is_elastic(&from, &here)?;
        // Strains are 0 where the reference stage begins.
        let at_start = |point: &Point| (point.strain == 0.0).then_some(0.0);
        let lateral = |point: &Point| point.lateral_strain.or(at_start(point));
        let at_half = |a: f64, b: f64| a + part * (b - a);
        let here_lateral = here.lateral_strain.ok_or(NO_LATERAL_STRAIN)?;
        let before_lateral = lateral(&before).ok_or(NO_LATERAL_STRAIN)?;
        let from_lateral = lateral(&from).ok_or(NO_LATERAL_STRAIN)?;
        let axial = at_half(before.strain, here.strain) - from.strain;
        let across = at_half(before_lateral, here_lateral) - from_lateral;
        if across.abs() <= RESOLVED * axial.abs() {
            return Err("the specimen is held sideways: the lateral strain stays");
        }
        let ratio = -across / axial;
        // Elastic in the plane: above 1 the volume would grow under compression.
        if ratio.abs() < 1.0 {
            Ok(ratio)
        } else {
            Err("at half the peak the lateral strain exceeds the axial one: not elastic")
        }
    }

    /// Whether the lateral stress is constant, within [`STAYS`], from the start of the stage to a
    /// point of the curve. Where it is not measured, it is that of walls beside the specimen. A
    /// specimen without stress at the start has no lateral one.
    pub(super) fn lateral_stays_to(&self, to: &Point) -> bool {
        let place = self.curve.iter().position(|point| point == to).unwrap_or(0);
        let start = self.start.lateral_stress.unwrap_or(self.start.beside);
        self.lateral_stays(Some(start), &self.curve[..=place])
    }

    /// Whether the lateral stress is constant, within [`STAYS`], over some points of the curve.
    fn lateral_stays(&self, start: Option<f64>, curve: &[Point]) -> bool {
        let (mut first, mut change, mut gain) = (start, 0.0_f64, 0.0_f64);
        for point in curve {
            let lateral = point.lateral_stress.unwrap_or(point.beside);
            change = change.max((lateral - *first.get_or_insert(lateral)).abs());
            gain = gain.max((point.stress - self.start.stress).abs());
        }
        change <= STAYS * gain
    }

    /// Place and point of the peak, if the test has passed it.
    pub(super) fn strength(&self) -> Result<(usize, Point), &'static str> {
        let peak = self.peak()?;
        let broken = self.curve.last().map_or(0, |last| last.broken);
        if self.results.bonds_created > 0 && broken == self.start.broken {
            return Err(NOTHING_BROKE);
        }
        let place = self.peak.ok_or(NOT_PASSED)?;
        let at = *self.curve.get(place).ok_or(NOT_PASSED)?;
        let start = self.start.lateral_stress;
        if !self.lateral_stays(start, &self.curve[..=place]) {
            return Err(LATERAL_CHANGES);
        }
        let rise = peak - self.start.stress;
        // Bonds also break at the strain of the peak. A cycle of unloading returns to that strain with less
        // stress and breaks nothing.
        let mut least = 1.0_f64;
        let fell = |point: &Point| {
            let strain = point.strain / at.strain;
            least = least.min(strain);
            let fall = (peak - point.stress) / rise;
            (fall >= PASSED && strain > 1.0 + RETURNS)
                || (fall >= PASSED_AT_ONCE && least > 1.0 - RETURNS)
        };
        let falls = self.curve[place + 1..].iter().any(fell);
        let collapses = self.collapse.flatten().is_some_and(|last| last.strain / at.strain >= 1.0);
        if falls || collapses { Ok((place, at)) } else { Err(NOT_PASSED) }
    }

    pub(super) fn residual_strength(&self) -> Result<f64, &'static str> {
        let (place, at) = self.strength()?;
        let end = self.curve.last().map_or(0.0, |point| point.strain / at.strain);
        let furthest = self.curve.iter().map(|p| p.strain / at.strain).fold(0.0, f64::max);
        if end < furthest {
            return Err("the specimen is unloaded at the end");
        }
        let begin = (1.0 - LAST) * end;
        if begin < BEYOND {
            return Err(
                "the test ends too close to the peak: the last fifth of its strain begins \
                        below twice the strain at the peak",
            );
        }
        let mean = |from: f64, to: f64| mean_over(&self.curve[place..], at.strain, from, to);
        let middle = 0.5 * (begin + end);
        let too_few = "the last fifth of the strain has too few increments";
        let first = mean(begin, middle).ok_or(too_few)?;
        let second = mean(middle, end).ok_or(too_few)?;
        if !((second - first).abs() <= LEVEL * (at.stress - self.start.stress).abs()) {
            return Err(
                "the stress is not level at the end: its means over the last two tenths of \
                        the strain differ by more than a tenth of the rise to the peak",
            );
        }
        Ok(0.5 * (first + second))
    }

    pub(super) fn friction_angle(&self) -> Result<f64, &'static str> {
        if self.results.bonds_created > 0 {
            return Err(
                "bonds give cohesion, which one test does not tell from friction; tests at \
                        several confining stresses do (`clastic envelope`)",
            );
        }
        let (_, at) = self.strength()?;
        let lateral = at.lateral_stress.ok_or("no lateral stress is measured")?;
        let (minor, major) = (at.stress.min(lateral), at.stress.max(lateral));
        if minor <= STAYS * major {
            return Err("no confining stress");
        }
        Ok(((major - minor) / (major + minor)).asin())
    }

    pub(super) fn crack_initiation(&self) -> Result<f64, &'static str> {
        if self.results.bonds_created == 0 {
            return Err(NO_BONDS);
        }
        let (place, at) = self.strength()?;
        let cracks = at.broken.saturating_sub(self.start.broken);
        if cracks < ENOUGH_CRACKS {
            return Err(
                "fewer than 100 bonds had broken at the peak, so that a hundredth of them \
                        is less than one: see first_crack_stress_pa",
            );
        }
        let initiated =
            |point: &&Point| 100 * point.broken.saturating_sub(self.start.broken) >= cracks;
        let found = self.curve[..=place].iter().find(initiated).unwrap_or(&at);
        Ok(found.stress)
    }

    pub(super) fn crack_damage(&self) -> Result<f64, &'static str> {
        if self.results.bonds_created == 0 {
            return Err(NO_BONDS);
        }
        let (place, at) = self.strength()?;
        if at.stress < self.start.stress {
            return Err("the test is no compression");
        }
        let mut least: Option<(f64, Point)> = None;
        for point in &self.curve[..=place] {
            let volume = point.volume.ok_or("no volumetric strain is measured")?;
            if least.is_none_or(|(most, _)| volume > most) {
                least = Some((volume, *point));
            }
        }
        let (most, found) = least.ok_or(CONTRACTS)?;
        if most <= 0.0 {
            return Err("the volume grows from the start");
        }
        let back = at.volume.map_or(0.0, |volume| most - volume);
        if back <= RESOLVED * most {
            return Err(CONTRACTS);
        }
        Ok(found.stress)
    }
}

/// Mean of the stress over the strain between two values, by trapezoids. Strains are in units of
/// `unit`. `None` where no increment lies between.
fn mean_over(curve: &[Point], unit: f64, from: f64, to: f64) -> Option<f64> {
    let (mut area, mut width) = (0.0, 0.0);
    for pair in curve.windows(2) {
        let (a, b) = (pair[0].strain / unit, pair[1].strain / unit);
        let (left, right) = (a.max(from), b.min(to));
        if right > left {
            let at =
                |x: f64| pair[0].stress + (x - a) / (b - a) * (pair[1].stress - pair[0].stress);
            area += 0.5 * (at(left) + at(right)) * (right - left);
            width += right - left;
        }
    }
    (width > 0.0).then(|| area / width)
}
