//! Grains between rough walls over a floor that is lowered, under Coulomb's law.

use clastic::components::observation::Observation;
use clastic::run::measures::reading;
use clastic::run::{Outcome, Simulation, Step};

use crate::common::*;

/// The floor is lowered until the walls carry part of the weight. The grains slip within the
/// increments: equilibrium is lost before the floor has moved all the way. The motion that followed
/// took the motion of the floor back, so that nothing moved, and the increment was undecided.
#[test]
fn a_silo_whose_floor_is_lowered_completes_and_its_walls_carry_the_weight() {
    let rough = "contact: (normal_stiffness: k, tangential_stiffness: k, friction: mu)";
    let scene = parse(&format!(
        "(
            version: 1,
            title: \"Silo\",
            let: {{ \"k\": 1.0e7, \"mu\": 0.8 }},
            friction_law: Coulomb(),
            materials: {{ \"grain\": (density: 2500.0, {rough}) }},
            specimen: Packing(count: 36, columns: 6, spacing: 12.2e-3, origin: (1.2e-3, 0.0),
                sizes: Uniform(radius: (4.0e-3, 6.0e-3)), seed: 4),
            walls: [
                (name: \"floor\", start: (0.0, 0.0), end: (0.0756, 0.0), {rough}),
                (name: \"top\", start: (0.0756, 0.0742), end: (0.0, 0.0742),
                    contact: (normal_stiffness: k)),
                (name: \"left\", start: (0.0, 1.0), end: (0.0, 0.0), {rough}),
                (name: \"right\", start: (0.0756, 0.0), end: (0.0756, 1.0), {rough}),
            ],
            stages: [
                Compact(name: \"compact\", wall: \"top\", base: \"floor\", target: Porosity(0.26),
                    step: 1.0e-3, agitation: 0.1, seed: 1),
                Load(name: \"weight\", increments: 10, gravity: (0.0, -9.81), remove_walls: [\"top\"]),
                Load(name: \"lower\", increments: 60, gravity: (0.0, -9.81),
                    walls: {{ \"floor\": Displacement(0.0, -2.0e-5) }}),
            ],
            measures: [
                (name: \"floor\", of: WallForce(wall: \"floor\", along: Y)),
                (name: \"left\", of: WallForce(wall: \"left\", along: Y)),
                (name: \"right\", of: WallForce(wall: \"right\", along: Y)),
            ],
        )"
    ));
    let mut simulation = Simulation::new(&scene, None);
    let (mut moved, mut carried) = (0, Vec::new());
    let outcome = loop {
        if let Step::Finished(outcome) = simulation.step() {
            break outcome;
        }
        let record = simulation.world().resource::<Observation>();
        moved += record.motion_steps;
        if record.stage == "lower" {
            let of = |wall| reading(simulation.world(), wall).unwrap();
            carried.push([of("floor"), of("left") + of("right")]);
        }
    };
    assert_eq!(outcome, Outcome::Completed);
    assert!(moved > 0, "no motion was followed");
    let total = carried[0][0] + carried[0][1];
    for [floor, walls] in &carried {
        assert_relative(floor + walls, total, 1e-3);
    }
    let [floor, _] = carried.last().unwrap();
    assert!(floor.abs() < 0.9 * total.abs(), "{floor} of {total}");
}
