//! Key results of strength tests: Poisson's ratio, crack thresholds, friction angle, residual
//! strength.

use super::definitions::{CAPPED_BEFORE, RIGID};
use super::{KeyResults, Point};

/// Change of the lateral stress over that of the axial stress up to which it counts as constant.
const CONSTANT: f64 = 0.01;

/// Share of the bonds that break up to the peak at which cracks are initiated: Potyondy and Cundall
/// (2004, Int. J. Rock Mech. Min. Sci. 41, 1329-1364).
const INITIATION: f64 = 0.01;

/// A lateral stress below this share of the axial one is that of a free surface.
const UNCONFINED: f64 = 1e-3;

/// A run has a residual strength if its strain goes on to this many times the strain at the peak.
const FAR: f64 = 2.0;

/// Scatter of the stress over its mean, and change of its mean over the peak, up to which the stress
/// counts as constant.
const STEADY: f64 = 0.1;

type Found = Result<f64, &'static str>;

impl KeyResults {
    /// Index of the peak on the curve.
    fn at_peak(&self, peak: f64) -> Option<usize> {
        self.curve.iter().position(|point| point.solved && point.stress == peak)
    }

    /// The curve up to the peak, which is its last point.
    fn up_to(&self, peak: f64) -> Result<&[Point], &'static str> {
        let at = self.at_peak(peak).ok_or("the peak is not on the curve")?;
        Ok(&self.curve[..=at])
    }

    pub(super) fn poisson(&self, peak: f64) -> Found {
        if self.rigid {
            return Err(RIGID);
        }
        let half = 0.5 * (peak - self.start.stress);
        let mut before = self.start;
        for here in self.up_to(peak)? {
            let gain = here.stress - self.start.stress;
            if gain / half < 1.0 {
                before = *here;
                continue;
            }
            if !(here.solved && before.solved) {
                return Err(CAPPED_BEFORE);
            }
            let gained = before.stress - self.start.stress;
            let part = (half - gained) / (gain - gained);
            let between = |of: fn(&Point) -> Option<f64>| -> Option<f64> {
                let (from, to) = (of(&before)?, of(here)?);
                Some(from + part * (to - from))
            };
            let lateral = between(|p| p.lateral_strain).ok_or("no lateral strain is measured")?;
            let start = self.start.lateral_stress;
            if let (Some(stress), Some(start)) = (between(|p| p.lateral_stress), start)
                && !((stress - start).abs() <= CONSTANT * half.abs())
            {
                return Err("the lateral stress changes on the way to half the peak");
            }
            let axial = before.strain + part * (here.strain - before.strain);
            let ratio = -lateral / axial;
            // Isotropic elasticity in the plane has no other ratios; NaN fails as well.
            return if half / axial > 0.0 && (-1.0..=1.0).contains(&ratio) {
                Ok(ratio)
            } else {
                Err("beyond -1 and 1: the specimen is not elastic up to half the peak")
            };
        }
        Err("no increment comes to half the peak")
    }

    pub(super) fn crack_initiation(&self, peak: f64) -> Found {
        let curve = self.up_to(peak)?;
        let broken = |point: &Point| point.broken.saturating_sub(self.start.broken);
        let all = curve.last().map_or(0, broken);
        if all == 0 {
            return Err("no bond broke up to the peak");
        }
        let few = ((INITIATION * all as f64).ceil() as usize).max(1);
        let first = curve.iter().find(|point| broken(point) >= few);
        match first {
            Some(point) if point.solved => Ok(point.stress),
            _ => Err("the increment that it would come from is capped"),
        }
    }

    pub(super) fn crack_damage(&self, peak: f64) -> Found {
        if peak < self.start.stress {
            return Err("the specimen is not compressed");
        }
        let curve = self.up_to(peak)?;
        let volumetric: Option<Vec<f64>> = curve.iter().map(|point| point.volumetric).collect();
        let volumetric = volumetric.ok_or("no volumetric strain is measured")?;
        let most = volumetric.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        match most {
            Some((_, most)) if !(most > 0.0) => Err("the volume grows from the start"),
            Some((at, _)) if at + 1 == curve.len() => Err("the volume shrinks up to the peak"),
            Some((at, _)) if !curve[at].solved => {
                Err("the increment that it would come from is capped")
            }
            Some((at, _)) => Ok(curve[at].stress),
            None => Err("the peak is not on the curve"),
        }
    }

    pub(super) fn friction_angle(&self, peak: f64) -> Found {
        let at = self.up_to(peak)?.last().ok_or("the peak is not on the curve")?;
        let lateral = at.lateral_stress.ok_or("no lateral stress is measured")?;
        let smaller = peak.min(lateral);
        if !(smaller > UNCONFINED * peak.abs().max(lateral.abs())) {
            return Err("one of the two stresses is not compressive at the peak");
        }
        Ok(((peak - lateral).abs() / (peak + lateral)).asin())
    }

    pub(super) fn residual(&self, peak: f64) -> Found {
        let at = self.at_peak(peak).ok_or("the peak is not on the curve")?;
        let (start, end) = (self.curve[at].strain, self.curve.last().map_or(0.0, |p| p.strain));
        if !(end.abs() >= FAR * start.abs()) || end * start <= 0.0 {
            return Err("the run does not go on to twice the strain at the peak");
        }
        let from = end - 0.25 * (end - start);
        let inside = |point: &&Point| point.solved && (point.strain - from) * (end - from) >= 0.0;
        let stresses: Vec<f64> =
            self.curve[at..].iter().filter(inside).map(|point| point.stress).collect();
        if stresses.len() < 4 {
            return Err("fewer than four solved increments in the last quarter after the peak");
        }
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        let all = mean(&stresses);
        let (first, second) = stresses.split_at(stresses.len() / 2);
        let square = stresses.iter().map(|s| (s - all).powi(2)).sum::<f64>();
        let deviation = (square / stresses.len() as f64).sqrt();
        let height = (peak - self.start.stress).abs();
        let drift = (mean(second) - mean(first)).abs();
        if drift <= STEADY * height && deviation <= STEADY * height {
            Ok(all)
        } else {
            Err("the stress still changes by more than a tenth of the peak at the end")
        }
    }
}
