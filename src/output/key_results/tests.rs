//! Tests of the key results.

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
