//! What a run comes down to: moduli, peak, limit load, cracks, worst residuals.

use serde::{Deserialize, Serialize};

use clastic_components::attempt::IncrementStatus;
use clastic_components::observation::Observation;

use super::mechanism::MechanismRecord;

/// Part of a run to which an increment belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Compaction: its forces mean nothing.
    Preparation,
    /// Loading before the reference stage, such as confinement.
    Loading,
    /// The reference stage and what follows: strains exist.
    Reference,
}

/// The key results, as `run.json` has them; none where a run does not define them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Tangent of the first increment of the reference stage that gains at least a thousandth of
    /// the peak: before that a platen may still be on its way. None for a rigid specimen.
    pub youngs_modulus_pa: Option<f64>,
    /// Secant from the start of the reference stage to half the peak.
    pub youngs_modulus_secant_half_peak_pa: Option<f64>,
    /// Axial stress that is farthest from that at the start of the reference stage.
    pub peak_stress_pa: Option<f64>,
    /// Axial strain there.
    pub strain_at_peak: Option<f64>,
    /// Limit load: axial stress of the last increment before the first collapse; for a rigid
    /// specimen, which is at its limit as soon as it carries load, the peak.
    pub limit_load_pa: Option<f64>,
    /// The mechanism of the first collapse that has one: its increment, margin and defect.
    pub mechanism: Option<MechanismRecord>,
    /// Porosity at the start of the reference stage.
    pub porosity: Option<f64>,
    /// Axial stress of the increment in which the first bond broke.
    pub first_crack_stress_pa: Option<f64>,
    /// Bonds ever created.
    pub bonds_created: usize,
    /// Bonds that hold.
    pub bonds_intact: usize,
    /// Bonds that broke.
    pub bonds_broken: BrokenBonds,
    /// Greatest residuals of the run.
    pub worst_residuals: WorstResiduals,
    /// Solver iterations of all increments.
    pub solver_iterations: u64,
}

/// Broken bonds by mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BrokenBonds {
    /// In tension.
    pub tension: usize,
    /// In shear.
    pub shear: usize,
    /// In rolling.
    pub rolling: usize,
}

/// Greatest residuals over all increments, those without a solution (collapsed, locked) left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorstResiduals {
    /// Of the balance.
    pub balance: Worst,
    /// Of the kinematics.
    pub kinematics: Worst,
    /// Of the limits.
    pub cone: Worst,
    /// Of the complementarity.
    pub complementarity: Worst,
}

/// A greatest value and its increment (0 where there is none).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// The value; not a number is the worst of all and becomes null in JSON.
    pub value: f64,
    /// The first increment that has it.
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

/// Gathers the key results, one increment after the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KeyResults {
    rigid: bool,
    /// Axial stress at the start of the reference stage, Pa.
    start: f64,
    /// Axial stress of the last increment that carried load, Pa.
    last_stress: Option<f64>,
    /// Strain and stress of the reference stage on.
    curve: Vec<[f64; 2]>,
    collapse_seen: bool,
    crack_seen: bool,
    results: Results,
}

impl KeyResults {
    /// Results of a run that has not begun. `rigid`: nothing in the specimen is elastic.
    #[must_use]
    pub fn new(rigid: bool) -> Self {
        Self { rigid, ..Default::default() }
    }

    /// Sets the porosity.
    pub fn set_porosity(&mut self, porosity: Option<f64>) {
        self.results.porosity = porosity;
    }

    /// Takes the mechanism of a collapse into account. Says whether it is the first one.
    pub fn see_mechanism(&mut self, mechanism: MechanismRecord) -> bool {
        let first = self.results.mechanism.is_none();
        self.results.mechanism.get_or_insert(mechanism);
        first
    }

    /// Whether there was a mechanism.
    #[must_use]
    pub fn has_mechanism(&self) -> bool {
        self.results.mechanism.is_some()
    }

    /// Takes an increment into account. Says whether it is the peak so far.
    pub fn observe(&mut self, o: &Observation, phase: Phase) -> bool {
        let results = &mut self.results;
        let [tension, shear, rolling] = o.broken;
        results.bonds_broken = BrokenBonds { tension, shear, rolling };
        results.bonds_intact = o.bonds;
        results.bonds_created = o.bonds + tension + shear + rolling;
        results.solver_iterations += u64::from(o.iterations);
        let collapsed = o.status == IncrementStatus::Collapsed;
        if !collapsed && o.status != IncrementStatus::Locked {
            let (worst, r) = (&mut results.worst_residuals, &o.residuals);
            worst.balance.see(r.balance, o.increment);
            worst.kinematics.see(r.kinematics, o.increment);
            worst.cone.see(r.cone, o.increment);
            worst.complementarity.see(r.complementarity, o.increment);
        }
        if phase == Phase::Preparation {
            self.start = 0.0;
            return false;
        }
        if collapsed && !self.collapse_seen {
            self.collapse_seen = true;
            results.limit_load_pa = self.last_stress;
        }
        if !o.ruptures.is_empty() && !self.crack_seen {
            self.crack_seen = true;
            results.first_crack_stress_pa = o.axial_stress;
        }
        let Some(stress) = o.axial_stress else { return false };
        self.last_stress = Some(stress);
        if phase == Phase::Loading {
            self.start = stress;
            return false;
        }
        let Some(strain) = o.axial_strain else { return false };
        self.curve.push([strain, stress]);
        let height = |stress: f64| (stress - self.start).abs();
        let peak = results.peak_stress_pa.is_none_or(|peak| height(stress) > height(peak));
        if peak {
            results.peak_stress_pa = Some(stress);
            results.strain_at_peak = Some(strain);
        }
        peak
    }

    /// The results so far.
    #[must_use]
    pub fn results(&self) -> Results {
        let mut results = self.results.clone();
        if self.rigid {
            results.limit_load_pa = results.peak_stress_pa;
        } else {
            results.youngs_modulus_pa = self.tangent();
            results.youngs_modulus_secant_half_peak_pa = self.secant();
        }
        results
    }

    fn tangent(&self) -> Option<f64> {
        let touch = 1e-3 * (self.results.peak_stress_pa? - self.start).abs();
        let mut before = [0.0, self.start];
        for [strain, stress] in &self.curve {
            if *strain != before[0] && (stress - before[1]).abs() >= touch {
                return Some((stress - before[1]) / (strain - before[0]));
            }
            before = [*strain, *stress];
        }
        None
    }

    fn secant(&self) -> Option<f64> {
        let half = 0.5 * (self.results.peak_stress_pa? - self.start);
        let mut before = [0.0, 0.0];
        for [strain, stress] in &self.curve {
            let here = [*strain, stress - self.start];
            if half != 0.0 && here[1] / half >= 1.0 {
                let part = (half - before[1]) / (here[1] - before[1]);
                let strain = before[0] + part * (here[0] - before[0]);
                return Some(half / strain).filter(|modulus| modulus.is_finite());
            }
            before = here;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use clastic_components::program::Residuals;

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
