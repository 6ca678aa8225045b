//! Definitions of the key results.

use std::collections::BTreeMap;

use super::{KeyResults, Point, Results};

/// Changes of stress below this fraction of the maximum stress count as round-off.
const RESOLVED: f64 = 1e-6;

/// Stresses below this fraction of the stress that the stiffness of the grains alone would give at
/// this strain count as round-off. Loose packings have a thousandth of that stress.
const SOFTEST: f64 = 1e-9;

const NO_CURVE: &str = "no increment from the start of the reference stage on has both an axial strain and \
                        an axial stress";
const UNKNOWN_START: &str = "the run starts from a saved state, whose stress no stage before the reference stage tells; \
                             put a loading stage of one increment before it";
/// Reason why a rigid specimen has no modulus.
pub const RIGID: &str = "nothing is elastic";
const CAPPED_BEFORE: &str = "an increment that it would come from is capped";

impl KeyResults {
    /// The results so far.
    #[must_use]
    pub fn results(&self) -> Results {
        let mut results = self.results.clone();
        let mut reasons = BTreeMap::new();
        let mut defined = |names: &[&str], value: Result<f64, &str>| match value {
            Ok(value) => Some(value),
            Err(reason) => {
                reasons.extend(names.iter().map(|name| ((*name).to_owned(), reason.to_owned())));
                None
            }
        };
        let peak = self.peak();
        results.peak_stress_pa = defined(&["peak_stress_pa", "strain_at_peak"], peak);
        if peak.is_err() {
            results.strain_at_peak = None;
        }
        results.youngs_modulus_pa =
            defined(&["youngs_modulus_pa"], peak.and_then(|peak| self.tangent(peak)));
        results.youngs_modulus_secant_half_peak_pa = defined(
            &["youngs_modulus_secant_half_peak_pa"],
            peak.and_then(|peak| self.secant(peak)),
        );
        results.limit_load_pa = defined(&["limit_load_pa"], self.limit_load(peak));
        results.first_crack_stress_pa = defined(&["first_crack_stress_pa"], self.first_crack());
        let _ = defined(
            &["porosity"],
            results
                .porosity
                .ok_or("the reference stage made no increment, or no specimen is there"),
        );
        let mechanism = results.mechanism.map(|mechanism| mechanism.margin);
        let _ = defined(&["mechanism"], mechanism.ok_or("no mechanism proves a collapse"));
        results.not_defined = reasons;
        results
    }

    /// Axial stress at the peak.
    fn peak(&self) -> Result<f64, &'static str> {
        let Some(peak) = self.results.peak_stress_pa else {
            return Err(if self.curve.is_empty() {
                NO_CURVE
            } else {
                "all increments that have both an axial strain and an axial stress are capped"
            });
        };
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
        let touch = 1e-3 * (peak - self.start.stress).abs();
        let mut before = self.start;
        for here in &self.curve {
            let gain = here.stress - before.stress;
            if here.strain != before.strain && gain.abs() >= touch {
                if !(here.solved && before.solved) {
                    return Err(CAPPED_BEFORE);
                }
                return positive(gain / (here.strain - before.strain));
            }
            before = *here;
        }
        Err("no increment that strains the specimen gains a thousandth of the peak")
    }

    fn secant(&self, peak: f64) -> Result<f64, &'static str> {
        if self.rigid {
            return Err(RIGID);
        }
        let half = 0.5 * (peak - self.start.stress);
        let mut before = Point { stress: 0.0, ..self.start };
        for point in &self.curve {
            let here = Point { stress: point.stress - self.start.stress, ..*point };
            if half != 0.0 && here.stress / half >= 1.0 {
                if !(here.solved && before.solved) {
                    return Err(CAPPED_BEFORE);
                }
                let part = (half - before.stress) / (here.stress - before.stress);
                let strain = before.strain + part * (here.strain - before.strain);
                return positive(half / strain);
            }
            before = here;
        }
        Err("no increment comes to half the peak")
    }

    fn limit_load(&self, peak: Result<f64, &'static str>) -> Result<f64, &'static str> {
        if self.rigid {
            return peak;
        }
        let last = self.collapse.ok_or("the specimen did not collapse")?;
        let last = last.ok_or("no increment before the collapse has an axial stress")?;
        if last.solved {
            Ok(last.stress)
        } else {
            Err("the increment before the collapse is capped")
        }
    }

    fn first_crack(&self) -> Result<f64, &'static str> {
        let (stress, solved) = self.crack.ok_or("no bond broke")?;
        let stress =
            stress.ok_or("the increment in which the first bond broke has no axial stress")?;
        if solved {
            Ok(stress)
        } else {
            Err("the increment in which the first bond broke is capped")
        }
    }
}

/// A modulus, which must be positive: the stress rises with the strain.
fn positive(modulus: f64) -> Result<f64, &'static str> {
    if modulus > 0.0 && modulus.is_finite() {
        Ok(modulus)
    } else {
        Err("the stress does not rise with the strain")
    }
}
