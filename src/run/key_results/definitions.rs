//! Definitions of the key results: modulus, peak, limit load, first crack.

use std::collections::BTreeMap;

use super::collected::{KeyResults, Point};
use super::results::Results;
use crate::run::measures::STRAIN_ERROR;

/// Stresses below this fraction of the stress that the stiffness of the grains alone would give at
/// this strain count as round-off. Loose packings have a thousandth of that stress.
const SOFTEST: f64 = 1e-9;

/// Changes of stress below this fraction of the maximum stress count as round-off.
pub(super) const RESOLVED: f64 = 1e-6;

// Reasons why a result is not defined.
pub(super) const NO_HALF: &str = "no increment comes to half the peak";
pub(super) const NO_GAIN: &str =
    "the strain does not change where the stress gains a thousandth of the peak";
/// Reason why a rigid specimen has no modulus.
pub const RIGID: &str = "nothing is elastic";
pub(super) const CAPPED_BEFORE: &str = "an increment that it would come from is capped";
const INERTIA: &str = "inertia carries a part of the load there: the kinetic energy is above a hundredth \
                       of the work; load more slowly, or in a static stage";
pub(super) const LATERAL_CHANGES: &str = "the lateral stress changes during the test";
const NO_CURVE: &str = "no increment from the start of the reference stage on has both an axial strain and \
                        an axial stress";
const UNKNOWN_START: &str = "the run starts from a saved state with other walls than its own or without a measured stress, \
                             and no earlier stage has measured the stress; put a loading stage of one \
                             increment before the reference stage";

impl KeyResults {
    /// The results so far.
    pub fn results(&self) -> Results {
        let mut reasons = BTreeMap::new();
        let mut defined = |name: &str, value: Result<f64, &str>| {
            value.map_err(|reason| reasons.insert(name.to_owned(), reason.to_owned())).ok()
        };
        let (mut results, peak) = (self.results.clone(), self.peak());
        results.youngs_modulus_pa =
            defined("youngs_modulus_pa", peak.and_then(|peak| self.tangent(peak)));
        let secant = peak.and_then(|peak| self.secant(peak));
        results.youngs_modulus_secant_half_peak_pa =
            defined("youngs_modulus_secant_half_peak_pa", secant);
        results.poissons_ratio =
            defined("poissons_ratio", peak.and_then(|peak| self.poissons_ratio(peak)));
        results.peak_stress_pa = defined("peak_stress_pa", peak);
        let strain = peak.and_then(|_| results.strain_at_peak.ok_or(NO_CURVE));
        results.strain_at_peak = defined("strain_at_peak", strain);
        results.strength_pa = defined("strength_pa", self.strength().map(|(_, peak)| peak.stress));
        results.residual_strength_pa = defined("residual_strength_pa", self.residual_strength());
        results.friction_angle_rad = defined("friction_angle_rad", self.friction_angle());
        results.limit_load_pa = defined("limit_load_pa", self.limit_load(peak));
        results.first_crack_stress_pa = defined("first_crack_stress_pa", self.first_crack());
        results.crack_initiation_stress_pa =
            defined("crack_initiation_stress_pa", self.crack_initiation());
        results.crack_damage_stress_pa = defined("crack_damage_stress_pa", self.crack_damage());
        let without = "the reference stage made no increment, or no specimen is there";
        results.porosity = defined("porosity", results.porosity.ok_or(without));
        if results.mechanism.is_none() {
            let reason = "no mechanism proves a collapse";
            reasons.insert("mechanism".to_owned(), reason.to_owned());
        }
        results.not_defined = reasons;
        results
    }

    /// Axial stress at the peak.
    pub(super) fn peak(&self) -> Result<f64, &'static str> {
        let peak = self.results.peak_stress_pa.ok_or(NO_CURVE)?;
        if self.is_start_unknown {
            return Err(UNKNOWN_START);
        }
        let maximum = |of: fn(&Point) -> f64| self.curve.iter().map(of).fold(0.0, f64::max);
        let stress = maximum(|p| p.stress.abs()).max(self.start.stress.abs());
        let strain = maximum(|p| p.strain.abs());
        let round_off = (RESOLVED * stress).max(SOFTEST * self.stiffness * strain);
        if (peak - self.start.stress).abs() <= round_off {
            return Err(
                "the axial stress stays as it is at the start of the reference stage, but for round-off",
            );
        }
        Ok(peak)
    }

    fn tangent(&self, peak: f64) -> Result<f64, &'static str> {
        if self.rigid {
            return Err(RIGID);
        }
        let (before, here, solved) = self.first_gain(peak).ok_or(NO_GAIN)?;
        if !solved {
            return Err(CAPPED_BEFORE);
        }
        if moves(&here, &before) {
            return Err(INERTIA);
        }
        self.is_elastic(&before, &here)?;
        positive((here.stress - before.stress) / (here.strain - before.strain))
    }

    /// The first rise of the stress by a thousandth of the peak: its last point is the first one
    /// whose stress differs by as much from that of an earlier point with another strain, and its
    /// first point is the last such point. Before, a platen may not have touched the specimen. Also
    /// whether all points from the first to the last are solved.
    pub(super) fn first_gain(&self, peak: f64) -> Option<(Point, Point, bool)> {
        let touch = 1e-3 * (peak - self.start.stress).abs();
        // What moved before a static stage is not the state that the stage begins with.
        let rests = |first: &Point| first.kinetic == 0.0 && moves(first, &self.start);
        let start = (!self.curve.first().is_some_and(rests)).then_some(&self.start);
        let points: Vec<&Point> = start.into_iter().chain(&self.curve).collect();
        let mut stress = [self.start.stress; 2];
        let mut strain = [self.start.strain; 2];
        for (k, here) in points.iter().enumerate() {
            stress = [stress[0].min(here.stress), stress[1].max(here.stress)];
            strain = [strain[0].min(here.strain), strain[1].max(here.strain)];
            if stress[1] - stress[0] < touch || !differ(strain) {
                continue;
            }
            let differs = |before: &&Point| {
                differ([here.strain, before.strain]) && (here.stress - before.stress).abs() >= touch
            };
            if let Some(first) = points[..k].iter().rposition(differs) {
                let solved = points[first..=k].iter().all(|point| point.solved);
                return Some((*points[first], **here, solved));
            }
        }
        None
    }

    fn secant(&self, peak: f64) -> Result<f64, &'static str> {
        if self.rigid {
            return Err(RIGID);
        }
        let (before, here, part) = self.half_way(peak).ok_or(NO_HALF)?;
        self.is_elastic(&self.start, &here)?;
        let strain = before.strain + part * (here.strain - before.strain);
        if !differ([strain, 0.0]) {
            return Err(NO_GAIN);
        }
        positive(0.5 * (peak - self.start.stress) / strain)
    }

    /// Whether springs alone respond between two points, under a constant lateral stress.
    pub(super) fn is_elastic(&self, from: &Point, to: &Point) -> Result<(), &'static str> {
        if moves(from, to) {
            return Err(INERTIA);
        }
        if self.lateral_stays_to(to) { Ok(()) } else { Err(LATERAL_CHANGES) }
    }

    /// The increment that comes to half the peak: the points before and after it, and the part of
    /// it after which half is reached.
    pub(super) fn half_way(&self, peak: f64) -> Option<(Point, Point, f64)> {
        let half = 0.5 * (peak - self.start.stress);
        let gain = |point: &Point| point.stress - self.start.stress;
        let befores = std::iter::once(&self.start).chain(&self.curve);
        let mut pairs = befores.zip(&self.curve).map(|(before, here)| (*before, *here));
        let (before, here) = pairs.find(|(_, here)| half != 0.0 && gain(here) / half >= 1.0)?;
        let part = (half - gain(&before)) / (here.stress - before.stress);
        Some((before, here, part))
    }

    fn limit_load(&self, peak: Result<f64, &'static str>) -> Result<f64, &'static str> {
        if self.rigid {
            return peak;
        }
        let last = self.collapse.ok_or("the specimen did not collapse")?;
        Ok(last.ok_or("the last increment before the collapse has no axial stress")?.stress)
    }

    fn first_crack(&self) -> Result<f64, &'static str> {
        let stress = self.crack.ok_or("no bond broke")?;
        stress.ok_or("the increment in which the first bond broke has no axial stress")
    }
}

/// Kinetic energy over the work on the way between two points from which inertia counts.
///
/// 1e-2: a wave with this share of the energy changes stresses by a tenth.
const MOVING: f64 = 1e-2;

/// Whether two strains differ by more than the round-off of measured distances.
fn differ([a, b]: [f64; 2]) -> bool {
    (a - b).abs() > STRAIN_ERROR
}

/// Whether inertia carries a part of the load at the second of two points of the curve.
fn moves(from: &Point, to: &Point) -> bool {
    let work = 0.5 * (to.stress - from.stress) * (to.strain - from.strain);
    to.kinetic > MOVING * work.abs()
}

/// A modulus, which must be positive: the stress rises with the strain.
fn positive(modulus: f64) -> Result<f64, &'static str> {
    if modulus > 0.0 && modulus.is_finite() {
        Ok(modulus)
    } else {
        Err("the stress does not rise with the strain")
    }
}
