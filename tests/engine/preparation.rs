//! Preparation: packings as dense as they get, cement by the number of bonds, cavities in a cell.

use std::f64::consts::PI;

use clastic::components::bond::Bond;
use clastic::components::cell::PeriodicCell;
use clastic::components::particle::Particle;
use clastic::run::measures::reading;
use clastic::run::stages::Script;
use clastic::run::{EndedBy, Outcome, Simulation};

use crate::common::parse;

/// 64 disks in a periodic cell, and stages.
fn cell(stages: &str) -> Simulation {
    let scene = parse(&format!(
        r#"(version: 1, title: "cell", materials: {{ "rock": (density: 2700.0,
            contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, friction: 0.5),
            bond: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, cohesion: 1.0e7, tensile_strength: 1.0e7))
        }},
        specimen: Packing(count: 64, columns: 8, spacing: 2.5e-3, sizes: Uniform(radius: (0.8e-3, 1.2e-3)), seed: 3),
        cell: (size: (20.0e-3, 20.0e-3)), stages: [{stages}],
        measures: [(name: "porosity", of: Porosity(Cell)), (name: "xx", of: Stress(Average(component: Xx, area: Cell))),
            (name: "yy", of: Stress(Average(component: Yy, area: Cell)))])"#
    ));
    Simulation::new(&scene, None)
}

fn compact(target: &str, stop: &str) -> String {
    format!(
        r#"Compact(name: "compact", target: {target}, step: 0.3e-3, agitation: 0.1, seed: 1, stop: [{stop}])"#
    )
}

/// A compaction strained bonds without forces, and the first load found 5 MPa where 50 kPa had been.
#[test]
fn a_compaction_of_bonded_grains_is_refused() {
    let stages =
        format!(r#"Cement(name: "glue", length: 1.0e-3), {}"#, compact("Porosity(0.3)", ""));
    let Outcome::Refused { message, .. } = cell(&stages).run() else { panic!() };
    assert!(message.contains("there are bonds"), "{message}");
}

#[test]
fn a_packing_is_compacted_until_it_is_jammed() {
    let mut simulation = cell(&compact("Jammed", ""));
    assert_eq!(simulation.run(), Outcome::Completed);
    let end = simulation.world().resource::<Script>().ends[0].clone();
    let porosity = end.jammed_at.unwrap();
    // Disks of two sizes jam at random at 0.16 (O'Hern et al. 2003), small cells at up to 0.2.
    assert!((0.15..0.2).contains(&porosity) && end.ended_by == Some(EndedBy::AllIncrements));
    let world = simulation.world_mut();
    let mut disks = world.query::<&Particle>();
    let area: f64 = disks.iter(world).map(|disk| PI * disk.radius * disk.radius).sum();
    let room = world.resource::<PeriodicCell>().area();
    assert!((porosity - (1.0 - area / room)).abs() < 1e-12, "{porosity}");

    // The same packing does not reach a porosity below, and the run says which one it has reached.
    let mut denser = cell(&compact(&format!("Porosity({:?})", porosity - 0.02), ""));
    let Outcome::Undecided { message, .. } = denser.run() else { panic!() };
    assert!(message.contains("a porosity of 0.1"), "{message}");

    let mut stopped = cell(&compact("Jammed", r#"Below("porosity", 0.3)"#));
    assert_eq!(stopped.run(), Outcome::Completed);
    let end = stopped.world().resource::<Script>().ends[0].clone();
    assert_eq!((end.ended_by, end.jammed_at), (Some(EndedBy::Stop), None));
    let found = reading(stopped.world(), "porosity").unwrap();
    assert!((0.27..=0.3).contains(&found), "{found}");
}

#[test]
fn cement_by_coordination_bonds_the_nearest_pairs() {
    let bonds = |cement: &str| {
        let stages = format!(r#"{}, Cement(name: "glue", {cement})"#, compact("Jammed", ""));
        let mut simulation = cell(&stages);
        assert_eq!(simulation.run(), Outcome::Completed);
        let world = simulation.world_mut();
        let mut bonds = world.query::<&Bond>();
        bonds.iter(world).map(|bond| bond.initial_gap).collect::<Vec<_>>()
    };
    let by_number = bonds("coordination: 4.2");
    assert_eq!(by_number.len(), (4.2 * 64.0 / 2.0_f64).round() as usize);
    let widest = by_number.iter().copied().fold(0.0, f64::max);
    let by_length = bonds(&format!("length: {:?}", widest * (1.0 + 1e-9)));
    assert_eq!(by_number.len(), by_length.len());
}

#[test]
fn a_cell_keeps_its_stresses_around_a_grain_that_is_taken_away() {
    let mut simulation = cell(&format!(
        r#"{}, Load(name: "press", increments: 5, cell: (xx: Stress(50.0e3), yy: Stress(50.0e3))),
        Remove(name: "cavity", select: Index([7])), Load(name: "hold", increments: 2)"#,
        compact("Jammed", "")
    ));
    assert_eq!(simulation.run(), Outcome::Completed);
    let world = simulation.world_mut();
    assert_eq!(world.query::<&Particle>().iter(world).count(), 63);
    for stress in ["xx", "yy"] {
        let stress = reading(simulation.world(), stress).unwrap();
        assert!((stress - 50.0e3).abs() < 1e-3 * 50.0e3, "{stress}");
    }
}
