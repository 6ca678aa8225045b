//! Statements of the paper about the biaxial test (4.5), on the 400 disks of `biaxial_small`: the
//! strength R of the bonds is 0 (no bonds), 10, 50 and 100 kPa. After the peak the round-off of
//! another machine may change the curve of so small a specimen: bounds there are wide.

use std::sync::LazyLock;

use crate::common::{assert_relative, load_with_specimen, next, stage};
use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;
use clastic::run::stages::Script;
use clastic::run::{EndedBy, Outcome, Simulation};
use clastic::scene::format::{RollingLimit, Stage, Stop};

/// Stress on the side walls, Pa.
const CONFINEMENT: f64 = 200e3;
/// Axial strain at the end.
const END: f64 = 0.12;

/// A test: every increment, and those of the shearing alone.
struct Test {
    /// Strength of the bonds, Pa.
    strength: f64,
    confined: Vec<Observation>,
    sheared: Vec<Observation>,
}

impl Test {
    fn run(strength: f64, rolling: RollingLimit, end: f64) -> Self {
        let mut loaded = load_with_specimen("biaxial_small");
        let scene = &mut loaded.scene;
        scene.rupture.rolling = rolling;
        stage(scene, "load").stop = vec![Stop::Above("axial_strain".to_owned(), end)];
        if strength > 0.0 {
            let bond = scene.materials.get_mut("sand").and_then(|m| m.bond.as_mut()).unwrap();
            (bond.cohesion, bond.tensile_strength) = (strength, strength);
        } else {
            scene.stages.retain(|stage| !matches!(stage, Stage::Cement(_)));
        }
        let mut simulation = Simulation::new(&loaded.scene, loaded.specimen.as_ref());
        let records: Vec<_> = std::iter::from_fn(|| next(&mut simulation)).collect();
        assert_eq!(simulation.run(), Outcome::Completed, "R = {strength}");
        for record in &records {
            assert_eq!(record.status, IncrementStatus::Solved, "R = {strength}");
        }
        let last = simulation.world().resource::<Script>().ends.last().unwrap().clone();
        assert_eq!(
            (last.ended_by, last.stop),
            (Some(EndedBy::Stop), Some(Stop::Above("axial_strain".to_owned(), end)))
        );
        let (confined, sheared) = records.into_iter().partition(|record| record.stage == "confine");
        Self { strength, confined, sheared }
    }

    /// Axial strain and deviatoric stress, Pa.
    fn deviator(&self) -> impl Iterator<Item = (f64, f64)> {
        self.sheared.iter().map(|record| {
            let stress = record.axial_stress.unwrap() - record.lateral_stress.unwrap();
            (record.axial_strain.unwrap(), stress)
        })
    }

    /// Peak of the deviatoric stress, Pa.
    fn peak(&self) -> f64 {
        self.deviator().map(|(_, stress)| stress).fold(0.0, f64::max)
    }

    /// Mean deviatoric stress of the last 2 % of strain, Pa.
    fn residual(&self) -> f64 {
        let last: Vec<_> =
            self.deviator().filter(|(e, _)| *e >= END - 0.02).map(|(_, stress)| stress).collect();
        last.iter().sum::<f64>() / last.len() as f64
    }

    fn volumetric(&self) -> impl Iterator<Item = f64> {
        self.sheared.iter().map(|record| record.volumetric_strain.unwrap())
    }

    /// Maximum contraction, with its place among the increments.
    fn contraction(&self) -> (usize, f64) {
        self.volumetric().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
    }
}

/// Without bonds, with 10, 50 and 100 kPa.
static TESTS: LazyLock<Vec<Test>> = LazyLock::new(|| {
    let tests: Vec<_> =
        [0.0, 10e3, 50e3, 100e3].map(|r| Test::run(r, RollingLimit::Yields, END)).into();
    for test in &tests {
        eprintln!(
            "R = {:.0} kPa: peak {:.1} kPa, residual {:.1} kPa, contraction {:.3} %, at the end {:.3} %",
            1e-3 * test.strength,
            1e-3 * test.peak(),
            1e-3 * test.residual(),
            100.0 * test.contraction().1,
            100.0 * test.volumetric().last().unwrap(),
        );
    }
    tests
});

#[test]
fn the_side_walls_keep_their_stress() {
    for record in TESTS.iter().flat_map(|test| &test.sheared) {
        assert_relative(record.lateral_stress.unwrap(), CONFINEMENT, 1e-6);
    }
}

#[test]
fn the_peak_rises_with_the_strength_of_the_bonds() {
    for pair in TESTS.windows(2) {
        let (weaker, stronger) = (pair[0].peak(), pair[1].peak());
        assert!(stronger > 1.03 * weaker, "{weaker} and {stronger} Pa");
    }
}

#[test]
fn cemented_specimens_soften_after_the_peak() {
    for test in TESTS.iter().filter(|test| test.strength >= 50e3) {
        let (peak, residual) = (test.peak(), test.residual());
        assert!(residual < 0.8 * peak, "R = {}: {peak} and {residual} Pa", test.strength);
        assert!(residual > 0.0, "R = {}: {residual} Pa", test.strength);
    }
}

#[test]
fn specimens_contract_then_dilate() {
    for test in TESTS.iter() {
        let r = test.strength;
        let (at, contraction) = test.contraction();
        // From the start up to its maximum it is contraction.
        assert!(contraction > 4e-3, "R = {r}: {contraction}");
        assert!(test.volumetric().take(at).all(|e| e > 0.0), "R = {r}");
        assert!(test.sheared[at].axial_strain.unwrap() < 0.02, "R = {r}");
        // Bonded specimens lose more than they gained: the volume is greater than at the start.
        let end = test.volumetric().last().unwrap();
        assert!(end < contraction - 5e-3, "R = {r}: {contraction} and {end}");
        assert!(r == 0.0 || end < 0.0, "R = {r}: {end}");
    }
    // The stronger the bonds, the more a specimen contracts before they give way.
    for pair in TESTS.windows(2) {
        assert!(pair[1].contraction().1 > pair[0].contraction().1, "R = {}", pair[1].strength);
    }
}

#[test]
fn bonds_that_break_in_rolling_do_not_outlive_the_confinement() {
    let test = Test::run(10e3, RollingLimit::Breaks, 0.03);
    let confined = test.confined.last().unwrap();
    let [tension, shear, rolling] = confined.broken;
    let bonds = confined.bonds + tension + shear + rolling;
    assert!(10 * rolling > 9 * bonds, "{rolling} of {bonds} bonds in rolling");
    // Where they yield instead the confinement breaks hardly any.
    let yielding = TESTS.iter().find(|test| test.strength == 10e3).unwrap();
    let broken: usize = yielding.confined.last().unwrap().broken.iter().sum();
    assert!(100 * broken < bonds, "{broken} of {bonds} bonds");
    // The residual strength is that of the sand without bonds.
    let (letter, sand) = (test.peak(), TESTS[0].peak());
    assert!((letter - sand).abs() < 0.1 * sand, "{letter} and {sand} Pa");
}
