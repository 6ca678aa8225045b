//! Elastic constants of a bonded triangular lattice under an affine displacement of its boundary.

use crate::common::*;
use clastic::components::contact::ContactTable;
use clastic::run::Simulation;
use clastic::scene::format::{Scene, Specimen};
use clastic::systems::measures::stress::average_stress;
use clastic::systems::solved::Solved;
use glam::DVec2;

/// E and nu of the lattice (thickness 1 m).
fn elastic_constants(normal: f64, tangential: f64) -> (f64, f64) {
    let denominator = 3.0 * normal + tangential;
    (
        2.0 * 3.0_f64.sqrt() * normal * (normal + tangential) / denominator,
        (normal - tangential) / denominator,
    )
}

/// The lattice scene with other stiffnesses, size and displacement gradient, for one increment.
fn lattice(stiffness: (f64, f64), columns: u32, gradient: [[f64; 2]; 2]) -> Scene {
    let mut scene = load("lattice");
    let bond = scene.materials.get_mut("cemented").unwrap().bond.as_mut().unwrap();
    (bond.normal_stiffness, bond.tangential_stiffness) = (Some(stiffness.0), Some(stiffness.1));
    scene.specimen = Specimen::Lattice {
        columns,
        rows: 2 * columns - 1,
        radius: 5e-3,
        origin: (0.3, -0.2),
        material: None,
    };
    let load = stage(&mut scene, "load");
    load.increments = 1;
    let [[xx, xy], [yx, yy]] = gradient;
    load.particles[0].affine = Some(((xx, xy), (yx, yy)));
    scene
}

/// Average stress after one increment; checks that the field is affine inside too, rotations zero
/// (gradients are symmetric).
fn stress(scene: &Scene, columns: u32, gradient: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let mut simulation = Simulation::new(scene, None);
    let start = states(&mut simulation);
    next(&mut simulation).unwrap();
    let size = gradient.iter().flatten().fold(0.0_f64, |m, g| m.max(g.abs()));
    for (now, before) in states(&mut simulation).iter().zip(&start) {
        let [row_x, row_y] = gradient.map(DVec2::from);
        let affine = DVec2::new(row_x.dot(before.position), row_y.dot(before.position));
        assert_within((now.position - before.position).distance(affine), 0.0, 1e-8 * size * 0.4);
        assert_within(now.rotation, 0.0, 1e-8 * size);
    }
    let world = simulation.world();
    let per_direction = f64::from(2 * (columns - 1) * (columns - 1));
    let contacts = world.resource::<ContactTable>();
    assert_eq!(contacts.0.len(), 3 * per_direction as usize);
    let cell = 2.0 * 3.0_f64.sqrt() * 25e-6;
    average_stress(Solved::of(world), per_direction * cell, 1.0)
}

#[test]
fn lattice_is_isotropic_with_the_analytic_young_modulus_and_poisson_ratio() {
    let e = 1e-6;
    for stiffness in [(8e6, 4e6), (1e9, 1e8), (2e7, 2e7), (1e7, 2e7)] {
        let (young, poisson) = elastic_constants(stiffness.0, stiffness.1);
        for columns in [3, 8] {
            // Stress and strain positive in compression: displacement gradients are negative.
            let of = |gradient| stress(&lattice(stiffness, columns, gradient), columns, gradient);
            let x = of([[-e, 0.0], [0.0, 0.0]]);
            let y = of([[0.0, 0.0], [0.0, -e]]);
            let shear = of([[0.0, -0.5 * e], [-0.5 * e, 0.0]]);
            let c11 = young / (1.0 - poisson * poisson);
            let expected_x = [[c11 * e, 0.0], [0.0, poisson * c11 * e]];
            let expected_y = [[poisson * c11 * e, 0.0], [0.0, c11 * e]];
            let half_shear = 0.5 * e * young / (1.0 + poisson);
            let expected_shear = [[0.0, half_shear], [half_shear, 0.0]];
            for (actual, expected) in [(x, expected_x), (y, expected_y), (shear, expected_shear)] {
                for i in 0..2 {
                    for j in 0..2 {
                        assert_within(actual[i][j], expected[i][j], 1e-9 * young * e);
                    }
                }
            }
        }
    }
}

#[test]
fn lattice_scene_is_uniaxial_stress_with_the_analytic_constants() {
    let (young, poisson) = elastic_constants(8e6, 4e6);
    assert_relative(poisson, 1.0 / 7.0, 1e-15);
    let (records, _) = run(&load("lattice"));
    for (n, record) in records.iter().enumerate() {
        let strain = 1e-6 * (n + 1) as f64;
        // Branches and normals turn and stretch with the strain: a relative error of its order.
        let tolerance = 1e-9 + 2.0 * strain * n as f64 / (n + 1) as f64;
        assert_relative(record.axial_strain.unwrap(), strain, 1e-9);
        assert_relative(record.lateral_strain.unwrap(), -poisson * strain, 1e-8);
        assert_relative(record.axial_stress.unwrap(), young * strain, tolerance);
        assert_within(record.lateral_stress.unwrap(), 0.0, tolerance * young * strain);
    }
}
