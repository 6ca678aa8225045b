//! Expressions in place of the points of tables.

use super::read;
use super::samples::SMALL;
use crate::scene::format::{Load, Stage, Table, WallControl};

const FORCE: &str = r#"walls: {"top": Force(1.0)}"#;

/// Stages of the small scene with these fields in place of its controls of walls.
#[track_caller]
fn stages(fields: &str, sets: &[&str]) -> Vec<Load> {
    assert_eq!(SMALL.matches(FORCE).count(), 1);
    let loaded = read(&SMALL.replace(FORCE, fields), sets);
    let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    assert!(loaded.text.contains("* s") || loaded.text.contains("* t"), "{}", loaded.text);
    let load = |stage| match stage {
        Stage::Load(load) => load,
        other => panic!("{other:?}"),
    };
    loaded.scene.stages.into_iter().map(load).collect()
}

fn table(stage: &Load) -> &Table {
    match &stage.walls["top"] {
        WallControl::Follow(table) => table,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_points_are_the_values_at_the_ends_of_the_increments() {
    let stages =
        stages("scale: (strength: 1 / (1 + 3 * s)), walls: {\"top\": Follow(Force(8 * s^2))}", &[]);
    let points = vec![(0.0, 0.0), (0.25, 0.5), (0.5, 2.0), (0.75, 4.5), (1.0, 8.0)];
    assert_eq!(*table(&stages[0]), Table::Force(points));
    let factors: Vec<f64> = (0..5).map(|k| 1.0 / (1.0 + 3.0 * (f64::from(k) / 4.0))).collect();
    let strength = stages[0].scale.strength.as_ref().unwrap();
    assert_eq!(strength.iter().map(|point| point.1).collect::<Vec<_>>(), factors);
}

#[test]
fn a_displacement_has_two_expressions_and_a_dynamic_stage_has_a_time() {
    let fields = "analysis: Dynamic(dt: 0.5), walls: {\"top\": Follow(Displacement(
        0.0, // along x
        0.1 * s * sin(pi * s),
    ))}";
    let Table::Displacement(points) =
        table(&stages(fields, &["stages[0].increments=2"])[0]).clone()
    else {
        panic!("no displacement");
    };
    assert_eq!(points, [(0.0, 0.0, 0.0), (0.5, 0.0, 0.05), (1.0, 0.0, points[2].2)]);
    let fields = "analysis: Dynamic(dt: 0.5), walls: {\"top\": Follow(Force(rate * t))}";
    let sets = ["let={\"rate\": 4.0}", "stages[0].increments=2"];
    let points = vec![(0.0, 0.0), (0.5, 2.0), (1.0, 4.0)];
    assert_eq!(*table(&stages(fields, &sets)[0]), Table::Force(points));
}

#[test]
fn a_setting_can_give_an_expression() {
    let sets = ["stages[0].walls.top=Follow(Stress(stress: 4 * s))", "stages[0].increments=1"];
    let stress = vec![(0.0, 0.0), (1.0, 4.0)];
    assert_eq!(*table(&stages(FORCE, &sets)[0]), Table::Stress { stress, between: None });
    let error = read(SMALL, &["stages[0].walls.top=Follow(Force(1 / s))"]).unwrap_err();
    let message = "--set stages[0].walls.top=Follow(Force(1 / s)): stages[0].walls.top: `1 / s` has no \
                   finite value at s = 0 (inf); it needs one from s = 0, the start of the stage, to \
                   s = 1, its end";
    assert_eq!(error.to_string(), message);
}

/// A number of repetitions by a name of `let` was taken for 1.
#[test]
fn points_of_repeated_stages_count_as_often_as_they_are_repeated() {
    let stage = |force: u32| {
        format!(
            "stages[0]=Repeat(times: n, stages: [Load(name: \"load\", increments: 999, walls: \
             {{\"top\": Follow(Force({force} * s))}})])"
        )
    };
    let read = |n: u32| read(SMALL, &[&format!("let={{\"n\": {n}}}"), &stage(n)]);
    assert!(read(10).is_ok());
    let error = read(1001).unwrap_err().to_string();
    assert!(error.contains("expressions stand for more than 1000000 points"), "{error}");
}
