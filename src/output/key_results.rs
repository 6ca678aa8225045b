//! Key results of a run: moduli, peak, limit load, cracks, maximum residuals.
//!
//! They come only from increments with the status `solved`. If a result is not defined,
//! `not_defined` gives the reason.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use clastic_components::attempt::IncrementStatus;
use clastic_components::observation::Observation;

use super::mechanism::MechanismRecord;

/// Part of a run to which an increment belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Compaction, whose forces have no physical meaning.
    Preparation,
    /// Loading before the reference stage, for example confinement.
    Loading,
    /// The reference stage and later stages, in which strains exist.
    Reference,
}

/// Key results as in `run.json`; `None` for those that the run does not define.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Tangent modulus of the first increment of the reference stage that gains at least a
    /// thousandth of the peak. In earlier increments a platen may not have touched the specimen.
    /// `None` for a rigid specimen.
    pub youngs_modulus_pa: Option<f64>,
    /// Secant modulus from the start of the reference stage to half the peak.
    pub youngs_modulus_secant_half_peak_pa: Option<f64>,
    /// Axial stress with the maximum difference from that at the start of the reference stage.
    pub peak_stress_pa: Option<f64>,
    /// Axial strain at the peak.
    pub strain_at_peak: Option<f64>,
    /// Estimate of the relative error of the peak due to the size of the increments. It is the
    /// delay of ruptures, as a relative change of force, in the last increment up to the peak with
    /// ruptures. `None` without ruptures. It does not include the effect of another order or number
    /// of rounds, nor that of the state after a drop (`AllAtOnce`).
    pub peak_error_estimate: Option<f64>,
    /// Number of avalanches: ruptures at constant load, from the first to an equilibrium in which
    /// all bonds hold. 0 unless bonds break from event to event.
    pub avalanches: usize,
    /// Number of bonds broken in the largest avalanche.
    pub largest_avalanche: usize,
    /// Limit load: axial stress of the last increment before the first collapse. For a rigid
    /// specimen, which is at its limit whenever it carries load, it is the peak.
    pub limit_load_pa: Option<f64>,
    /// Mechanism of the first collapse that has one: its increment, margin and defect.
    pub mechanism: Option<MechanismRecord>,
    /// Porosity at the start of the reference stage.
    pub porosity: Option<f64>,
    /// Axial stress of the increment in which the first bond broke.
    pub first_crack_stress_pa: Option<f64>,
    /// Number of bonds ever created. Bonds that are neither intact nor broken were removed together
    /// with a wall.
    pub bonds_created: usize,
    /// Number of intact bonds.
    pub bonds_intact: usize,
    /// Number of broken bonds.
    pub bonds_broken: BrokenBonds,
    /// Maximum residuals of the run.
    pub worst_residuals: WorstResiduals,
    /// Solver iterations in all increments.
    pub solver_iterations: u64,
    /// Reasons for undefined key results, by their names.
    pub not_defined: BTreeMap<String, String>,
}

/// Number of broken bonds by mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BrokenBonds {
    /// In tension.
    pub tension: usize,
    /// In shear.
    pub shear: usize,
    /// In rolling.
    pub rolling: usize,
}

/// Maximum residuals over all increments that have a solution (not collapsed or locked).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorstResiduals {
    /// Residual of the balance.
    pub balance: Worst,
    /// Residual of the kinematics.
    pub kinematics: Worst,
    /// Residual of the limits.
    pub cone: Worst,
    /// Residual of the complementarity.
    pub complementarity: Worst,
}

/// A maximum and its increment (0 if none).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// The value. NaN counts as larger than all numbers and is null in JSON.
    pub value: f64,
    /// The first increment with this value.
    pub increment: u64,
}

impl Worst {
    fn see(&mut self, value: f64, increment: u64) {
        let worse = value > self.value || (value.is_nan() && !self.value.is_nan());
        if self.increment == 0 || worse {
            *self = Self { value, increment };
        }
    }
}

/// Collects the key results increment by increment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeyResults {
    rigid: bool,
    /// Stress that the stiffest contact would have at a strain of 1, Pa.
    stiffness: f64,
    /// Delay of ruptures in the last increment with ruptures.
    lag: Option<f64>,
    /// Start of the reference stage.
    start: Point,
    /// The last increment with load.
    last: Option<Point>,
    /// Increments from the reference stage on that have both a strain and a stress.
    curve: Vec<Point>,
    /// Whether the specimen collapsed, and the increment before the collapse.
    collapse: Option<Option<Point>>,
    /// Whether a bond broke, the stress of the first increment with a rupture, and whether that
    /// increment is solved.
    crack: Option<(Option<f64>, bool)>,
    results: Results,
}

/// An increment on the curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Point {
    /// Axial strain; 0 before the reference stage.
    strain: f64,
    /// Axial stress, Pa.
    stress: f64,
    /// Whether the status is `solved`; false if a maximum number of passes was reached.
    solved: bool,
}

/// A start without stress.
const FREE: Point = Point { strain: 0.0, stress: 0.0, solved: true };

/// Changes of stress below this fraction of the maximum stress count as round-off.
const RESOLVED: f64 = 1e-6;

/// Stresses below this fraction of the stress that the stiffness of the grains alone would give at
/// this strain count as round-off. Loose packings have a thousandth of that stress.
const SOFTEST: f64 = 1e-9;

const NO_CURVE: &str = "no increment from the start of the reference stage on has both an axial strain and \
                        an axial stress";
/// Reason why a rigid specimen has no modulus.
pub const RIGID: &str = "nothing is elastic";
const CAPPED_BEFORE: &str = "an increment that it would come from is capped";

impl KeyResults {
    /// Results before the run. `rigid` means that nothing in the specimen is elastic.
    #[must_use]
    pub fn new(rigid: bool) -> Self {
        Self {
            rigid,
            stiffness: 0.0,
            lag: None,
            start: FREE,
            last: None,
            curve: Vec::new(),
            collapse: None,
            crack: None,
            results: Results::default(),
        }
    }

    /// Sets the stiffness of the stiffest contact over the thickness, Pa. Stresses that are small
    /// relative to it count as round-off.
    #[must_use]
    pub fn with_stiffness(self, stiffness: f64) -> Self {
        Self { stiffness, ..self }
    }

    /// Sets the porosity.
    pub fn set_porosity(&mut self, porosity: Option<f64>) {
        self.results.porosity = porosity;
    }

    /// Records the mechanism of a collapse. Returns whether it is the first one.
    pub fn see_mechanism(&mut self, mechanism: MechanismRecord) -> bool {
        let first = self.results.mechanism.is_none();
        self.results.mechanism.get_or_insert(mechanism);
        first
    }

    /// Whether a mechanism was recorded.
    #[must_use]
    pub fn has_mechanism(&self) -> bool {
        self.results.mechanism.is_some()
    }

    /// Records the number of bonds created so far.
    pub fn see_bonds(&mut self, created: usize) {
        // Bonds to a removed wall no longer exist, so the number of existing bonds may decrease.
        self.results.bonds_created = self.results.bonds_created.max(created);
    }

    /// Records an increment. Returns whether it is the peak so far.
    pub fn observe(&mut self, o: &Observation, phase: Phase) -> bool {
        let results = &mut self.results;
        let [tension, shear, rolling] = o.broken;
        results.bonds_broken = BrokenBonds { tension, shear, rolling };
        results.bonds_intact = o.bonds;
        self.see_bonds(o.bonds + tension + shear + rolling);
        let results = &mut self.results;
        results.solver_iterations += u64::from(o.iterations);
        let collapsed = o.status == IncrementStatus::Collapsed;
        if !collapsed {
            let (worst, r) = (&mut results.worst_residuals, &o.residuals);
            worst.balance.see(r.balance, o.increment);
            worst.kinematics.see(r.kinematics, o.increment);
            worst.cone.see(r.cone, o.increment);
            worst.complementarity.see(r.complementarity, o.increment);
        }
        if phase == Phase::Preparation {
            self.start = FREE;
            return false;
        }
        let solved = o.status == IncrementStatus::Solved;
        if collapsed && self.collapse.is_none() {
            self.collapse = Some(self.last);
        }
        if !o.ruptures.is_empty() && self.crack.is_none() {
            self.crack = Some((o.axial_stress, solved));
        }
        if o.in_avalanche {
            return false;
        }
        let Some(stress) = o.axial_stress else { return false };
        let point = Point { strain: o.axial_strain.unwrap_or_default(), stress, solved };
        self.last = Some(point);
        if phase == Phase::Loading {
            self.start = Point { strain: 0.0, ..point };
            return false;
        }
        if o.axial_strain.is_none() {
            return false;
        }
        self.curve.push(point);
        let height = |stress: f64| (stress - self.start.stress).abs();
        let results = &mut self.results;
        let peak =
            solved && results.peak_stress_pa.is_none_or(|peak| height(stress) > height(peak));
        if o.rupture_lag > 0.0 {
            self.lag = Some(o.rupture_lag);
        }
        if peak {
            results.peak_stress_pa = Some(stress);
            results.strain_at_peak = Some(point.strain);
            results.peak_error_estimate = self.lag;
        }
        peak
    }

    /// Records an avalanche in which this number of bonds broke.
    pub fn see_avalanche(&mut self, bonds: usize) {
        self.results.avalanches += 1;
        self.results.largest_avalanche = self.results.largest_avalanche.max(bonds);
    }

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

#[cfg(test)]
mod tests {
    use clastic_cone::program::Residuals;

    use super::*;

    fn at(increment: u64, strain: Option<f64>, stress: Option<f64>) -> Observation {
        Observation { increment, axial_strain: strain, axial_stress: stress, ..Default::default() }
    }

    fn near(found: Option<f64>, expected: f64) {
        let found = found.unwrap_or(f64::NAN);
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} for {expected}");
    }

    fn run(rigid: bool, rows: &[(Phase, Option<f64>, Option<f64>)]) -> KeyResults {
        let mut key = KeyResults::new(rigid);
        for (k, (phase, strain, stress)) in rows.iter().enumerate() {
            key.observe(&at(1 + k as u64, *strain, *stress), *phase);
        }
        key
    }

    #[test]
    fn moduli_and_peak_count_from_the_start_of_the_reference_stage() {
        use Phase::{Loading, Preparation, Reference};
        let results = run(
            false,
            &[
                (Preparation, None, Some(9e9)),
                (Loading, None, Some(50.0)),
                (Loading, None, Some(100.0)),
                (Reference, Some(0.0), Some(100.0)),
                (Reference, Some(0.01), Some(200.0)),
                (Reference, Some(0.02), Some(280.0)),
                (Reference, Some(0.03), Some(340.0)),
                (Reference, Some(0.04), Some(90.0)),
            ],
        )
        .results();
        near(results.youngs_modulus_pa, 1e4);
        // Half the rise of 240 lies a quarter of the way from 100 to 180, at a strain of 0.0125.
        near(results.youngs_modulus_secant_half_peak_pa, 120.0 / 0.0125);
        near(results.peak_stress_pa, 340.0);
        near(results.strain_at_peak, 0.03);
        assert_eq!(results.limit_load_pa, None);
    }

    /// Results of a reference stage with rows of strain, stress, and whether the increment is
    /// capped.
    fn partly_capped(rows: &[(f64, f64, bool)]) -> Results {
        let mut key = KeyResults::new(false).with_stiffness(1e6);
        for (k, (strain, stress, capped)) in rows.iter().enumerate() {
            let status = if *capped { IncrementStatus::Capped } else { IncrementStatus::Solved };
            let row = at(1 + k as u64, Some(*strain), Some(*stress));
            key.observe(&Observation { status, ..row }, Phase::Reference);
        }
        let collapse = Observation { status: IncrementStatus::Collapsed, ..at(99, None, None) };
        key.observe(&collapse, Phase::Reference);
        key.results()
    }

    #[test]
    fn key_results_come_from_solved_increments_only() {
        let all = partly_capped(&[(0.01, -128.0, true), (0.02, 300.0, true)]);
        for (name, value) in [
            ("youngs_modulus_pa", all.youngs_modulus_pa),
            ("youngs_modulus_secant_half_peak_pa", all.youngs_modulus_secant_half_peak_pa),
            ("peak_stress_pa", all.peak_stress_pa),
            ("strain_at_peak", all.strain_at_peak),
            ("limit_load_pa", all.limit_load_pa),
        ] {
            assert_eq!(value, None, "{name}");
            assert!(all.not_defined[name].contains("capped"), "{name}: {:?}", all.not_defined);
        }
        // The peak comes from solved increments. The slope between a solved and a capped increment
        // is no modulus.
        let some = partly_capped(&[(0.01, 90.0, true), (0.02, 150.0, false), (0.03, 200.0, false)]);
        assert_eq!((some.peak_stress_pa, some.strain_at_peak), (Some(200.0), Some(0.03)));
        assert_eq!((some.youngs_modulus_pa, some.limit_load_pa), (None, Some(200.0)));
        assert!(some.not_defined["youngs_modulus_pa"].contains("capped"));
        let later = partly_capped(&[(0.01, 100.0, false), (0.02, 150.0, true)]);
        near(later.youngs_modulus_pa, 1e4);
        near(later.peak_stress_pa, 100.0);
        assert_eq!(later.limit_load_pa, None);
        assert!(!later.not_defined.contains_key("peak_stress_pa"));
    }

    #[test]
    fn round_off_is_no_modulus_and_no_peak() {
        // Stresses under a platen without contact: round-off of either sign, and zero.
        for stress in [-1e-11, 1e-11, 0.0] {
            let results = partly_capped(&[(0.01, stress, false), (0.02, 3.0 * stress, false)]);
            assert_eq!((results.youngs_modulus_pa, results.peak_stress_pa), (None, None));
            assert!(results.not_defined["youngs_modulus_pa"].contains("round-off"));
        }
        // A case with confining stress.
        use Phase::{Loading, Reference};
        let rows = [
            (Loading, None, Some(2e5)),
            (Reference, Some(0.01), Some(2e5 - 1e-4)),
            (Reference, Some(0.02), Some(2e5 + 1e-3)),
        ];
        assert_eq!(run(false, &rows).results().youngs_modulus_pa, None);
        // A decreasing stress is neither round-off nor a modulus.
        let falls = partly_capped(&[(0.01, -128.0, false)]);
        assert_eq!((falls.youngs_modulus_pa, falls.peak_stress_pa), (None, Some(-128.0)));
        assert!(falls.not_defined["youngs_modulus_pa"].contains("does not rise"));
    }

    #[test]
    fn a_tension_test_peaks_in_tension() {
        use Phase::Reference;
        let rows = [(Reference, Some(-0.1), Some(-5.0)), (Reference, Some(-0.2), Some(-0.5))];
        let results = run(false, &rows).results();
        near(results.peak_stress_pa, -5.0);
        near(results.youngs_modulus_pa, 50.0);
        near(results.youngs_modulus_secant_half_peak_pa, 50.0);
    }

    #[test]
    fn a_rigid_specimen_has_a_limit_load_and_no_modulus() {
        use Phase::Reference;
        let rows = [(Reference, Some(5e-5), Some(1.14e9)), (Reference, Some(1e-4), Some(0.0))];
        let results = run(true, &rows).results();
        near(results.limit_load_pa, 1.14e9);
        assert_eq!(results.youngs_modulus_pa, None);
        assert_eq!(results.youngs_modulus_secant_half_peak_pa, None);
    }

    #[test]
    fn the_first_collapse_gives_the_limit_load() {
        let mut key = run(false, &[(Phase::Reference, Some(1e-3), Some(7.0))]);
        let collapse = Observation { status: IncrementStatus::Collapsed, ..at(2, None, None) };
        key.observe(&collapse, Phase::Reference);
        key.observe(&at(3, Some(2e-3), Some(1.0)), Phase::Reference);
        key.observe(&collapse, Phase::Reference);
        near(key.results().limit_load_pa, 7.0);
    }

    #[test]
    fn residuals_keep_the_worst_and_do_not_lose_what_is_no_number() {
        let mut key = KeyResults::new(false);
        for (increment, balance) in [(1, 1e-12), (2, 3e-9), (3, f64::NAN), (4, 1.0)] {
            let residuals = Residuals { balance, cone: 1e-10, ..Default::default() };
            key.observe(&Observation { residuals, ..at(increment, None, None) }, Phase::Reference);
        }
        let worst = key.results().worst_residuals;
        assert!(worst.balance.value.is_nan());
        assert_eq!(worst.balance.increment, 3);
        assert_eq!(worst.cone, Worst { value: 1e-10, increment: 1 });
    }

    #[test]
    fn bonds_are_counted() {
        let mut key = KeyResults::new(false);
        let row = Observation { bonds: 5, broken: [1, 2, 3], iterations: 7, ..at(1, None, None) };
        key.observe(&row, Phase::Reference);
        let results = key.results();
        assert_eq!((results.bonds_created, results.bonds_intact), (11, 5));
        assert_eq!(results.bonds_broken, BrokenBonds { tension: 1, shear: 2, rolling: 3 });
        assert_eq!(results.solver_iterations, 7);
    }
}
