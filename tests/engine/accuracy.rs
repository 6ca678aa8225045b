//! Static stages that choose their increments by an accuracy: the error against small increments,
//! loads and `Until` that land on their targets, and stages to which an accuracy does not apply.

use std::path::Path;

use clastic::components::observation::Observation;
use clastic::components::step_control::StepControl;
use clastic::prelude::*;
use clastic::run::stages::Script;
use clastic::scene;

use crate::common::{self, parse, stage};
use crate::followed_motion::confinement;

/// `biaxial_small` without its bonds: `increments` close it by 1.2 % of its height. `accuracies` are those of the
/// two stages.
fn biaxial(increments: u32, accuracies: [Option<f64>; 2]) -> Vec<Observation> {
    let mut simulation = of_biaxial(increments, accuracies, "");
    let records = std::iter::from_fn(|| common::next(&mut simulation)).collect();
    assert_eq!(simulation.run(), Outcome::Completed);
    records
}

/// The same to an axial stress: the records, and the stress if it has passed the value.
fn until(increments: u32, accuracy: Option<f64>, value: f64) -> (Vec<Observation>, Option<f64>) {
    let stop = format!("Until(\"axial_stress\", {value:?})");
    let mut simulation = of_biaxial(increments, [None, accuracy], &stop);
    let records = std::iter::from_fn(|| common::next(&mut simulation)).collect();
    assert_eq!(simulation.run(), Outcome::Completed);
    let end = simulation.world().resource::<Script>().ends.last().unwrap();
    assert!(end.stop.is_some(), "{end:?}");
    (records, end.passed)
}

/// Measures of `biaxial_small` that an `Until` can name.
const NAMED: &str = r#"measures=[
    (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
    (name: "axial_stress", of: Stress(Walls(walls: ["bottom", "top"], length: Between("left", "right")))),
]"#;

fn of_biaxial(increments: u32, accuracies: [Option<f64>; 2], stop: &str) -> Simulation {
    let closing = 0.006 * 0.2147896 / f64::from(increments);
    let mut sets = vec![
        format!("stages.load.increments={increments}"),
        format!("stages.load.walls.bottom=Displacement(0.0, {closing:?})"),
        format!("stages.load.walls.top=Displacement(0.0, {:?})", -closing),
        format!("stages.load.stop=[{stop}]"),
    ];
    if !stop.is_empty() {
        sets.push(NAMED.to_owned());
    }
    let path = format!("{}/scenes/biaxial_small.ron", env!("CARGO_MANIFEST_DIR"));
    let mut loaded = scene::load(Path::new(&path), &sets).unwrap();
    loaded.scene.stages.retain(|stage| stage.name() != "cement");
    for (name, accuracy) in ["confine", "load"].into_iter().zip(accuracies) {
        stage(&mut loaded.scene, name).accuracy = accuracy;
    }
    Simulation::new(&loaded.scene, loaded.specimen.as_ref())
}

/// Axial strain and axial stress in the stage.
fn curve(records: &[Observation]) -> Vec<(f64, f64)> {
    let shear = records.iter().filter(|o| o.stage == "load");
    shear.map(|o| (o.axial_strain.unwrap(), o.axial_stress.unwrap())).collect()
}

/// Lateral stress in `biaxial_small`, Pa.
const LATERAL: f64 = 200e3;

/// Mean error of the axial stress at the ends of increments against small increments, over the norm
/// of the stress.
fn error(curve: &[(f64, f64)], exact: &[(f64, f64)]) -> f64 {
    let at = |strain: f64| {
        let k = exact.partition_point(|(e, _)| *e < strain - 1e-12).min(exact.len() - 1).max(1);
        let ((a, x), (b, y)) = (exact[k - 1], exact[k]);
        x + (y - x) * (strain - a) / (b - a)
    };
    // Weights are the lengths of the increments.
    let mut last = 0.0;
    let mut sum = 0.0;
    for (strain, stress) in curve {
        sum += (strain - last) * (stress - at(*strain)).abs() / stress.hypot(LATERAL);
        last = *strain;
    }
    sum / last
}

/// 4 increments of 0.3 % strain are wrong by several per cent. With an accuracy the error is that
/// accuracy or less, and no smaller increments are made than it needs.
#[test]
fn the_error_follows_the_accuracy() {
    let run = |increments, accuracy| curve(&biaxial(increments, [None, accuracy]));
    let exact = run(128, None);
    let coarse = error(&run(4, None), &exact);
    assert!(coarse > 0.03, "{coarse}: nothing to improve");
    let mut rows = 4;
    for accuracy in [0.02, 0.005] {
        let chosen = run(4, Some(accuracy));
        let found = error(&chosen, &exact);
        assert!(found <= accuracy, "{accuracy}: {found} in {} increments", chosen.len());
        assert!(chosen.len() > rows && chosen.len() < 160, "{}", chosen.len());
        rows = chosen.len();
        // The ends of the increments that the stage asks for are ends of increments.
        let last = chosen.last().unwrap().0;
        assert!((last - exact.last().unwrap().0).abs() < 1e-12);
        for k in 1..4 {
            let wanted = last * f64::from(k) / 4.0;
            let near = chosen.iter().any(|(strain, _)| (strain - wanted).abs() < 1e-9);
            assert!(near, "no increment ends at {wanted}");
        }
    }
}

/// An `Until` shortens the fractions that the accuracy has chosen, and the stage ends on the value,
/// at the strain of small increments.
#[test]
fn a_stage_with_an_accuracy_lands_on_the_value_of_an_until() {
    const VALUE: f64 = 350e3;
    let strain = |increments, accuracy| {
        let (records, passed) = until(increments, accuracy, VALUE);
        assert_eq!(passed, None, "{increments} increments, {accuracy:?}");
        let last = records.last().unwrap();
        assert!((last.axial_stress.unwrap() / VALUE - 1.0).abs() < 2e-6, "{:?}", last.axial_stress);
        let rows: Vec<_> = records.iter().filter(|o| o.stage == "load").collect();
        (last.axial_strain.unwrap(), rows.iter().map(|o| o.fraction).sum::<f64>(), rows.len())
    };
    let (exact, ..) = strain(128, None);
    let (found, sum, rows) = strain(4, Some(0.01));
    assert!((found / exact - 1.0).abs() < 0.05, "{found} and not {exact}");
    // The fractions are those of increments of 0.3 % strain, and the last one is cut.
    assert!((sum * 0.003 / found - 1.0).abs() < 0.01, "{sum} increments to {found}");
    assert!(sum.fract() > 1e-6 && rows > 4, "{rows} rows to {sum}");
}

/// Solves that only estimate an error are counted in the rows and do not change the loads.
#[test]
fn stresses_land_on_their_targets() {
    let mut scene = parse(&confinement(0.21, 0.4, 7));
    stage(&mut scene, "confine").accuracy = Some(0.02);
    stage(&mut scene, "confine").increments = 3;
    let (records, outcome) = common::run(&scene);
    assert_eq!(outcome, Outcome::Completed);
    let last = records.last().unwrap();
    for stress in [last.axial_stress, last.lateral_stress] {
        assert!((stress.unwrap() / 100e3 - 1.0).abs() < 1e-7, "{stress:?}");
    }
    let confine: Vec<_> = records.iter().filter(|o| o.stage == "confine").collect();
    let sum: f64 = confine.iter().map(|o| o.fraction).sum();
    assert!((sum - 3.0).abs() < 1e-9, "{sum}");
    // A pair takes three solves.
    let solves: u32 = confine.iter().map(|o| o.solves).sum();
    assert!(solves as usize >= confine.len() * 3 / 2, "{solves} in {}", confine.len());
}

/// A stage without an accuracy after one that has it makes the increments that it asks for.
#[test]
fn an_accuracy_is_that_of_its_stage() {
    let records = biaxial(4, [Some(0.02), None]);
    assert!(records.iter().filter(|o| o.stage == "load").all(|o| o.fraction == 1.0));
    assert!(records.iter().any(|o| o.stage == "confine" && o.fraction < 1.0));
}

/// Bonds of a saved state are only known when the stage begins.
#[test]
fn a_stage_with_bonds_is_refused() {
    let mut scene = common::load("tension");
    let load = scene.stages.iter().find_map(|s| s.load()).unwrap().name.clone();
    stage(&mut scene, &load).accuracy = Some(0.01);
    let mut simulation = Simulation::new(&scene, None);
    let Outcome::Refused { message, .. } = simulation.run() else {
        panic!("the stage was not refused")
    };
    assert!(message.contains("`accuracy` is for stages without bonds"), "{message}");
    assert!(!simulation.world().contains_resource::<StepControl>());
}
