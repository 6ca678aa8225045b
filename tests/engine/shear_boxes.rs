//! Shear boxes with rigid halves against a calculation by hand.

use clastic::components::observation::Observation;
use clastic::run::{Outcome, Simulation, Step};

use crate::common::*;

fn of_stage<'a>(records: &'a [Observation], stage: &str) -> Vec<&'a Observation> {
    records.iter().filter(|record| record.stage == stage).collect()
}

/// The recipe of docs/scenes.md: grains in an upper half of three plates slide over a plane. The
/// plane carries the stress, and in the end mu times it.
#[test]
fn grains_in_a_floating_half_slide_over_a_plane_at_mu() {
    let docs = include_str!("../../docs/scenes.md");
    let recipe = docs.split("*Shear box with rigid halves.*").nth(1).unwrap();
    let recipe = recipe.split("```").nth(1).unwrap().trim_start_matches("ron\\n");
    let recipe = recipe.trim_start_matches("ron");
    for law in ["Coulomb()", "Associated"] {
        let scene = parse(&format!(
            r#"(version: 1, title: "box", friction_law: {law},
            materials: {{ "sand": (contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8,
                friction: 0.5)) }},
            specimen: Lattice(columns: 10, rows: 4, radius: 5.0e-3, origin: (5.0e-3, 5.0e-3)),
            {recipe})"#
        ));
        let mut simulation = Simulation::new(&scene, None);
        let mut ratios = Vec::new();
        let mut last = None;
        while simulation.step() == Step::Increment {
            let record = simulation.world().resource::<Observation>().clone();
            let value = |name| clastic::run::measures::reading(simulation.world(), name).unwrap();
            if record.stage == "shear" {
                assert_relative(value("normal_n"), 100.0e3 * 0.1, 1e-7);
                ratios.push(-value("shear_n") / value("normal_n"));
            }
            last = Some(record);
        }
        // The force that drives the half is the one that the plane holds.
        let last = last.unwrap();
        let half = probe(&last, "half");
        assert_relative(-half.force[0] / half.force[1], ratios[49], 1e-7);
        assert!(ratios[0] < 0.3 && ratios.iter().all(|ratio| *ratio <= 0.5 + 1e-7), "{ratios:?}");
        assert_within(ratios[49], 0.5, if law == "Associated" { 0.01 } else { 1e-7 });
    }
}

/// Two rigid halves of a lattice, rigid contacts, Coulomb's law. The upper row rides over the lower
/// one: at a displacement s its contacts lean by beta with sin(beta) = (r - s)/(2 r), and tau/sigma
/// = tan(phi + beta) (Patton 1966). Contacts have the direction of the start of an increment.
#[test]
fn rows_of_two_rigid_halves_ride_over_each_other_as_by_patton() {
    let (mu, r, step) = (0.2_f64, 5.0e-3, 2.0e-5);
    let scene = parse(&format!(
        r#"(version: 1, title: "halves", friction_law: Coulomb(),
        materials: {{ "rock": (contact: (friction: {mu:?})) }},
        specimen: Lattice(columns: 12, rows: 4, radius: {r:?}, origin: (0.0, 0.0)),
        groups: {{
            "lower": Layer(normal: (0.0, 1.0), from: -1.0, to: 0.012),
            "upper": Except(All, Group("lower")),
        }},
        stages: [
            Load(name: "press", increments: 2, rigid: {{
                "low": (select: Group("lower"), x: Held, y: Held, rotation: Held),
                "high": (select: Group("upper"), x: Held, rotation: Held,
                    stress: (value: (0.0, -100.0e3), length: 0.12)),
            }}),
            Load(name: "shear", increments: 50, rigid: {{
                "high": (x: Displacement({step:?}), rotation: Held) }}),
        ])"#
    ));
    let (records, outcome) = run(&scene);
    assert_eq!(outcome, Outcome::Completed);
    let rows = of_stage(&records, "shear");
    assert_eq!(rows.len(), 50);
    for (k, row) in rows.iter().enumerate() {
        let high = probe(row, "high");
        let beta = ((r - step * k as f64) / (2.0 * r)).asin();
        assert_relative(-high.force[0] / high.force[1], (mu.atan() + beta).tan(), 2e-4);
        assert_relative(high.force[1], 100.0e3 * 0.12, 1e-7);
        // It rises along the circle about the lower disk.
        let s = step * (k + 1) as f64;
        let rise = (4.0 * r * r - (r - s) * (r - s)).sqrt() - 3.0_f64.sqrt() * r;
        assert_within(high.motion[1], rise, 0.02 * rise);
    }
}
