//! Average stress: Love and Weber's sum over contacts against the forces on the walls.

use crate::common::*;
use clastic::components::contact::{BodyTable, ContactTable};
use clastic::components::observation::Observation;
use clastic::cone::program::ConeSolution;
use clastic::run::Simulation;
use clastic::scene::format::Scene;
use clastic::systems::measures::stress::average_stress;
use clastic::systems::solved::Solved;
use glam::DVec2;

/// Calls `check` with every solved increment under load: the record, the simulation, and width and
/// height of the cell at the start of the increment.
fn every_increment(scene: &Scene, mut check: impl FnMut(&Observation, &Simulation, f64, f64)) {
    let mut simulation = Simulation::new(scene, None);
    let (mut size, mut checked) = ([0.062, 0.1], 0);
    while let Some(record) = next(&mut simulation) {
        if record.stage == "confine" || record.stage == "load" {
            check(&record, &simulation, size[0], size[1]);
            checked += 1;
        }
        let at = |name, k: usize| probe(&record, name).motion[k];
        size = [0.062 + at("right", 0) - at("left", 0), 0.1 + at("top", 1) - at("bottom", 1)];
    }
    assert!(checked >= 35, "{checked}");
}

/// What the two stresses may differ by: ten times the residual of the balance.
fn accepted(record: &Observation) -> f64 {
    10.0 * record.residuals.balance.max(1e-14)
}

#[test]
fn walls_and_contacts_give_one_stress_in_a_frictionless_cell() {
    every_increment(&small_cell(SMOOTH, ROUGH), |record, _, width, height| {
        // Stress-controlled or driven, elastic overlap at the walls or not.
        let axial =
            [-probe(record, "top").force[1] / width, probe(record, "bottom").force[1] / width];
        let lateral =
            [-probe(record, "right").force[0] / height, probe(record, "left").force[0] / height];
        let scale = record.axial_stress.unwrap().abs().max(record.lateral_stress.unwrap().abs());
        for wall in axial {
            assert_within(record.axial_stress.unwrap(), wall, accepted(record) * scale);
        }
        for wall in lateral {
            assert_within(record.lateral_stress.unwrap(), wall, accepted(record) * scale);
        }
    });
}

#[test]
fn walls_and_contacts_give_one_stress_tensor_in_a_frictional_cell() {
    every_increment(&small_cell(ROUGH, ROUGH), |record, simulation, width, height| {
        let world = simulation.world();
        let (bodies, contacts, solution) = (
            world.resource::<BodyTable>(),
            world.resource::<ContactTable>(),
            world.resource::<ConeSolution>(),
        );
        let average = average_stress(Solved::of(world), width * height, 1.0);
        // Forces on the walls times the places on the walls where they act, at the start of the
        // increment: forces on the grains have the opposite sign, as has stress.
        let mut outside = [[0.0; 2]; 2];
        for (contact, f) in contacts.0.iter().zip(&solution.forces) {
            let (a, b) = (contact.a as usize, contact.b as usize);
            if b < bodies.particles {
                continue;
            }
            let last = bodies.last_motion[a];
            let start = bodies.positions[a] - DVec2::new(last[0], last[1]);
            let place = start + contact.normal * (bodies.radii[a] + contact.gap);
            let force = contact.normal * f[0] + contact.normal.perp() * f[1];
            for i in 0..2 {
                for j in 0..2 {
                    outside[i][j] += force[i] * place[j] / (width * height);
                }
            }
        }
        let scale = average.iter().flatten().fold(0.0_f64, |m, s| m.max(s.abs()));
        for i in 0..2 {
            for j in 0..2 {
                assert_within(average[i][j], outside[i][j], accepted(record) * scale);
            }
        }
        assert_within(record.axial_stress.unwrap(), average[1][1], 1e-12 * scale);
    });
}
