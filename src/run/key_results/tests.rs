//! Tests of the key results.

use clastic_components::attempt::IncrementStatus;
use clastic_components::observation::Observation;
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
    let mut key = KeyResults { stiffness: 1e6, ..KeyResults::new(false) };
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
fn a_peak_may_be_capped_and_a_tangent_may_not() {
    let all = partly_capped(&[(0.01, 128.0, true), (0.02, 300.0, true)]);
    assert_eq!((all.peak_stress_pa, all.strain_at_peak), (Some(300.0), Some(0.02)));
    assert!(all.peak_is_capped && all.limit_load_pa == Some(300.0));
    near(all.youngs_modulus_secant_half_peak_pa, 150.0 / (0.01 + 0.01 * 22.0 / 172.0));
    assert!(all.not_defined["youngs_modulus_pa"].contains("capped"), "{:?}", all.not_defined);
    // The slope between a solved and a capped increment is no modulus.
    let some = partly_capped(&[(0.01, 90.0, true), (0.02, 150.0, false), (0.03, 200.0, false)]);
    assert_eq!((some.peak_stress_pa, some.strain_at_peak), (Some(200.0), Some(0.03)));
    assert!(!some.peak_is_capped);
    assert_eq!((some.youngs_modulus_pa, some.limit_load_pa), (None, Some(200.0)));
    assert!(some.not_defined["youngs_modulus_pa"].contains("capped"));
    let later = partly_capped(&[(0.01, 100.0, false), (0.02, 150.0, true)]);
    near(later.youngs_modulus_pa, 1e4);
    near(later.peak_stress_pa, 150.0);
    assert_eq!((later.limit_load_pa, later.peak_is_capped), (Some(150.0), true));
}

/// A tenth of the work is motion: neither modulus nor Poisson's ratio, but a peak.
#[test]
fn elastic_constants_are_no_result_of_inertia() {
    let rows = [(0.01, 100.0), (0.02, 200.0), (0.03, 50.0)];
    for (share, is_defined) in [(0.1, false), (0.001, true)] {
        let mut key = KeyResults { stiffness: 1e6, ..KeyResults::new(false) };
        for (k, (strain, stress)) in rows.iter().enumerate() {
            key.kinetic = share * 0.5 * strain * stress;
            let row = at(1 + k as u64, Some(*strain), Some(*stress));
            let row = Observation { lateral_strain: Some(-0.3 * strain), ..row };
            key.observe(&row, Phase::Reference);
        }
        let found = key.results();
        for (name, value) in [
            ("youngs_modulus_pa", found.youngs_modulus_pa),
            ("youngs_modulus_secant_half_peak_pa", found.youngs_modulus_secant_half_peak_pa),
            ("poissons_ratio", found.poissons_ratio),
        ] {
            assert_eq!(value.is_some(), is_defined, "{name}");
            assert!(is_defined || found.not_defined[name].contains("inertia"), "{name}");
        }
        near(found.strength_pa, 200.0);
    }
}

/// The modulus of a static test was refused for the motion of the stage before.
#[test]
fn a_static_stage_does_not_begin_with_the_motion_of_the_stage_before() {
    let mut key = KeyResults { stiffness: 1e6, ..KeyResults::new(false) };
    key.kinetic = 1.0;
    key.observe(&at(1, None, Some(7.0)), Phase::Loading);
    key.kinetic = 0.0;
    for (k, (strain, stress)) in [(0.01, 100.0), (0.02, 200.0), (0.03, 50.0)].iter().enumerate() {
        key.observe(&at(2 + k as u64, Some(*strain), Some(*stress)), Phase::Reference);
    }
    near(key.results().youngs_modulus_pa, 1e4);
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
    // Two platens that move alike strain nothing: the modulus was 1e18 Pa.
    let alike = partly_capped(&[(1e-16, 100.0, false), (-4e-15, 200.0, false)]);
    assert_eq!(alike.youngs_modulus_pa, None);
    assert_eq!(alike.youngs_modulus_secant_half_peak_pa, None);
    assert!(alike.not_defined["youngs_modulus_pa"].contains("strain does not change"));
    // A decreasing stress is neither round-off nor a modulus.
    let falls = partly_capped(&[(0.01, -128.0, false)]);
    assert_eq!((falls.youngs_modulus_pa, falls.peak_stress_pa), (None, Some(-128.0)));
    assert!(falls.not_defined["youngs_modulus_pa"].contains("does not rise"));
}

/// 3000 increments to the peak, none of which gains a thousandth of it, after 500 in which the
/// platen does not touch the specimen. Then the motion goes back along another slope.
#[test]
fn a_modulus_needs_no_large_increment_and_not_the_way_back() {
    use Phase::Reference;
    let mut rows: Vec<_> =
        (1..=500).map(|k| (Reference, Some(-1e-5 * f64::from(500 - k)), Some(0.0))).collect();
    let rise =
        (1..=3000).map(|k| (Reference, Some(1e-5 * f64::from(k)), Some(10.0 * f64::from(k))));
    rows.extend(rise);
    rows.push((Reference, Some(0.02), Some(10.0)));
    near(run(false, &rows).results().youngs_modulus_pa, 1e6);
}

/// A fall before the rise, several points at one strain, and tension over several increments.
#[test]
fn a_modulus_is_the_slope_of_the_first_rise() {
    use Phase::{Loading, Reference};
    // The stress falls by 20 of 1000 Pa at the first strain: that is the first change of stress.
    let fall = [(Reference, Some(0.01), Some(-20.0)), (Reference, Some(0.02), Some(1000.0))];
    let results = run(false, &fall).results();
    assert_eq!(results.youngs_modulus_pa, None);
    assert!(results.not_defined["youngs_modulus_pa"].contains("does not rise"));
    // The stress rises at a strain that stays: no slope comes from there.
    let held = [
        (Loading, None, Some(0.0)),
        (Reference, Some(0.0), Some(50.0)),
        (Reference, Some(0.0), Some(100.0)),
        (Reference, Some(0.01), Some(200.0)),
    ];
    near(run(false, &held).results().youngs_modulus_pa, 1e4);
    let pulled: Vec<_> = (1..=4000)
        .map(|k| (Reference, Some(-1e-6 * f64::from(k)), Some(-2.0 * f64::from(k))))
        .collect();
    near(run(false, &pulled).results().youngs_modulus_pa, 2e6);
}

/// A capped increment within the first rise.
#[test]
fn a_modulus_comes_from_solved_increments_only() {
    let rows: Vec<_> =
        (1..=3000).map(|k| (1e-5 * f64::from(k), 10.0 * f64::from(k), k == 2)).collect();
    let results = partly_capped(&rows);
    assert_eq!(results.youngs_modulus_pa, None);
    assert!(results.not_defined["youngs_modulus_pa"].contains("capped"));
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

/// A specimen that gave way after its platen was gone had the last stress of the platen as its limit load.
#[test]
fn a_stress_that_is_no_longer_measured_is_no_limit_load() {
    let mut key = run(false, &[(Phase::Reference, Some(1e-3), Some(7.0))]);
    key.observe(&at(2, None, None), Phase::Reference);
    let collapse = Observation { status: IncrementStatus::Collapsed, ..at(3, None, None) };
    key.observe(&collapse, Phase::Reference);
    assert_eq!(key.results().limit_load_pa, None);
    assert_eq!(key.results().strength_pa, None);
    near(key.results().peak_stress_pa, 7.0);
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

/// A row under a lateral stress: strains and stresses, broken bonds.
#[derive(Clone, Copy)]
struct Row {
    axial: f64,
    lateral: f64,
    stress: f64,
    confining: f64,
    broken: usize,
}

fn row(axial: f64, lateral: f64, stress: f64, broken: usize) -> Row {
    Row { axial, lateral, stress, confining: 100.0, broken }
}

/// Compression from a stress of 100 Pa with a peak of 500 Pa at 4 %.
const TEST: [(f64, f64, f64, usize); 12] = [
    (0.0, 0.0, 100.0, 5),
    (0.01, -0.002, 200.0, 5),
    (0.02, -0.004, 300.0, 6),
    (0.03, -0.02, 400.0, 10),
    (0.04, -0.05, 500.0, 205),
    (0.05, -0.07, 300.0, 230),
    (0.08, -0.1, 210.0, 260),
    (0.10, -0.12, 190.0, 270),
    (0.11, -0.13, 210.0, 275),
    (0.12, -0.14, 190.0, 276),
    (0.13, -0.15, 200.0, 277),
    (0.14, -0.16, 200.0, 278),
];

/// The results of these rows; `bonds` were there.
fn tested(rows: &[Row], bonds: usize) -> Results {
    let mut key = KeyResults::new(false);
    let bond = |broken| if bonds > 0 { (bonds - broken, [broken, 0, 0]) } else { (0, [0; 3]) };
    let mut see = |k: usize, row: &Row, phase| {
        let (bonds, broken) = bond(row.broken);
        let loading = phase == Phase::Loading;
        let strain = |value: f64| (!loading).then_some(value);
        let record = Observation {
            lateral_strain: strain(row.lateral),
            volumetric_strain: strain(1.0 - (1.0 - row.axial) * (1.0 - row.lateral)),
            lateral_stress: Some(row.confining),
            bonds,
            broken,
            ..at(1 + k as u64, strain(row.axial), Some(row.stress))
        };
        key.observe(&record, phase);
    };
    see(0, &rows[0], Phase::Loading);
    for (k, row) in rows.iter().enumerate().skip(1) {
        see(k, row, Phase::Reference);
    }
    key.results()
}

fn whole() -> Vec<Row> {
    TEST.iter().map(|r| row(r.0, r.1, r.2, r.3)).collect()
}

fn reason<'a>(results: &'a Results, name: &str) -> &'a str {
    results.not_defined.get(name).map_or("", String::as_str)
}

#[test]
fn results_of_a_test_past_its_peak_are_those_by_hand() {
    let results = tested(&whole(), 1000);
    // Half of the rise of 400 is reached at 300 Pa, where the strains are 2 % and -0.4 %.
    near(results.poissons_ratio, 0.2);
    near(results.strength_pa, 500.0);
    // From 11.2 % to 14 %: trapezoids of the strain between its rows.
    let first = (0.008 * 0.5 * (206.0 + 190.0) + 0.006 * 0.5 * (190.0 + 196.0)) / 0.014;
    let second = (0.004 * 0.5 * (196.0 + 200.0) + 0.01 * 200.0) / 0.014;
    near(results.residual_strength_pa, 0.5 * (first + second));
    // Of 200 cracks between the start and the peak two had appeared at 400 Pa, five to be exact.
    near(results.crack_initiation_stress_pa, 400.0);
    // 1 - (1 - e_a)(1 - e_l) is 0.01592, 0.0106 and -0.008: the volume turns at 300 Pa.
    near(results.crack_damage_stress_pa, 300.0);
    assert!(reason(&results, "friction_angle_rad").contains("cohesion"));
    let sand: Vec<_> = whole().iter().map(|row| Row { broken: 0, ..*row }).collect();
    let results = tested(&sand, 0);
    // sin phi = (500 - 100) / (500 + 100).
    near(results.friction_angle_rad, (2.0_f64 / 3.0).asin());
    for name in ["crack_initiation_stress_pa", "crack_damage_stress_pa"] {
        assert!(reason(&results, name).contains("no bonds"), "{name}");
    }
}

#[test]
fn a_test_that_ends_before_its_peak_has_no_strength() {
    let results = tested(&whole()[..5], 1000);
    near(results.peak_stress_pa, 500.0);
    for name in ["strength_pa", "residual_strength_pa", "crack_initiation_stress_pa"] {
        assert!(reason(&results, name).contains("the test ends before"), "{name}");
    }
    // A stress that was imposed and taken away broke nothing: a tunnel had a "strength".
    let bonded: Vec<_> = whole().iter().map(|row| Row { broken: 0, ..*row }).collect();
    assert!(reason(&tested(&bonded, 1000), "strength_pa").contains("no bond has broken"));
    // Unloading is no failure: the strain falls with the stress.
    let mut unloaded = whole()[..5].to_vec();
    unloaded.extend([row(0.03, -0.045, 350.0, 205), row(0.02, -0.04, 200.0, 205)]);
    let results = tested(&unloaded, 1000);
    assert_eq!((results.strength_pa, results.residual_strength_pa), (None, None));
    // A cycle returns to the strain of its start, where the stress is lower than before.
    let mut cycled = whole()[..5].to_vec();
    cycled.extend([row(0.02, -0.04, 200.0, 205), row(0.04, -0.05, 450.0, 205)]);
    assert_eq!(tested(&cycled, 1000).strength_pa, None);
}

#[test]
fn bonds_that_break_at_the_strain_of_the_peak_give_a_strength() {
    let mut avalanche = whole()[..5].to_vec();
    avalanche.extend([row(0.04, -0.05, 300.0, 250), row(0.04, -0.05, 100.0, 280)]);
    near(tested(&avalanche, 1000).strength_pa, 500.0);
    // Bonds that finish to break take less, and the stress goes on to rise.
    let mut relaxed = whole()[..5].to_vec();
    relaxed.push(row(0.04, -0.05, 480.0, 210));
    assert_eq!(tested(&relaxed, 1000).strength_pa, None);
}

#[test]
fn no_poissons_ratio_where_the_sides_are_held_or_pressed() {
    let held: Vec<_> = whole().iter().map(|row| Row { lateral: 0.0, ..*row }).collect();
    assert!(reason(&tested(&held, 0), "poissons_ratio").contains("held sideways"));
    // An oedometer: the lateral stress rises with the axial one.
    let pressed: Vec<_> =
        whole().iter().map(|row| Row { confining: 0.5 * row.stress, ..*row }).collect();
    let results = tested(&pressed, 0);
    for name in ["poissons_ratio", "strength_pa", "friction_angle_rad"] {
        assert!(reason(&results, name).contains("lateral stress changes"), "{name}");
    }
    let dilates: Vec<_> =
        whole().iter().map(|row| Row { lateral: -1.5 * row.axial, ..*row }).collect();
    assert!(reason(&tested(&dilates, 0), "poissons_ratio").contains("not elastic"));
}

#[test]
fn thresholds_of_cracks_need_enough_of_them_and_a_volume_that_turns() {
    let few: Vec<_> =
        whole().iter().map(|r| Row { broken: 5 + (r.broken - 5) / 4, ..*r }).collect();
    let results = tested(&few, 1000);
    assert!(reason(&results, "crack_initiation_stress_pa").contains("fewer than 100"));
    let shrinks: Vec<_> = whole().iter().map(|row| Row { lateral: 0.0, ..*row }).collect();
    assert!(reason(&tested(&shrinks, 1000), "crack_damage_stress_pa").contains("shrinks"));
    let grows: Vec<_> =
        whole().iter().map(|row| Row { lateral: -2.0 * row.axial, ..*row }).collect();
    assert!(reason(&tested(&grows, 1000), "crack_damage_stress_pa").contains("grows"));
}

#[test]
fn no_residual_strength_where_the_stress_still_falls() {
    let mut falls = whole();
    for row in &mut falls[7..] {
        row.stress = 500.0 - 3000.0 * (row.axial - 0.04);
    }
    assert!(reason(&tested(&falls, 0), "residual_strength_pa").contains("not level"));
    assert!(reason(&tested(&whole()[..6], 0), "residual_strength_pa").contains("too close"));
}
