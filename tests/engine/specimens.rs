//! Specimens: cuts, layers, minerals, and bonds that scatter.

use std::collections::BTreeMap;

use clastic::components::body::{BodyId, BodyPosition};
use clastic::components::bond::Bond;
use clastic::components::material::{BondLaw, Materials};
use clastic::components::particle::{MaterialIndex, Particle};
use clastic::run::minerals::specimen;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::Particle as Seed;
use glam::DVec2;

use crate::common::{assert_relative, assert_within, load, parse};

/// Place, radius and material of every particle.
fn particles(simulation: &mut Simulation) -> Vec<(DVec2, f64, String)> {
    let world = simulation.world_mut();
    let names: Vec<String> =
        world.resource::<Materials>().0.iter().map(|material| material.name.clone()).collect();
    let mut query = world.query::<(&BodyId, &BodyPosition, &Particle, &MaterialIndex)>();
    let mut found: Vec<_> = query
        .iter(world)
        .map(|(id, x, disk, material)| {
            (*id, (x.0, disk.radius, names[material.0 as usize].clone()))
        })
        .collect();
    found.sort_by_key(|(id, _)| *id);
    found.into_iter().map(|(_, particle)| particle).collect()
}

const MATERIALS: &str = r#"materials: { "rock": (), "clay": (), "mica": () },
    stages: [Load(name: "hold", increments: 1)]"#;

#[test]
fn a_specimen_is_cut_to_a_disk_with_a_hole_and_a_notch() {
    let scene = parse(&format!(
        r#"(version: 1, title: "disk", {MATERIALS},
        specimen: Lattice(columns: 41, rows: 47, radius: 0.5, origin: (-20.0, -20.0), material: "rock"),
        keep: Except(Circle(centre: (0.0, 0.0), radius: 15.0), Union([
            Circle(centre: (0.0, 0.0), radius: 4.0),
            Polygon([(-1.0, -16.0), (1.0, -16.0), (0.0, -9.0)]),
        ])), probes: {{ "first": 0 }})"#
    ));
    let mut simulation = Simulation::new(&scene, None);
    let disks = particles(&mut simulation);
    let inside = |x: DVec2| {
        let notch = (-16.0..-9.0).contains(&x.y) && x.x.abs() < (-9.0 - x.y) / 7.0;
        x.length() <= 15.0 && x.length() > 4.0 && !notch
    };
    assert!(disks.iter().all(|(x, ..)| inside(*x)));
    // All that are inside are there: as many as of the whole lattice.
    let whole = clastic::scene::format::Scene { keep: None, ..scene };
    let count = specimen(&whole, None).iter().filter(|seed| inside(seed.position.into())).count();
    assert_eq!(disks.len(), count);
    // One disk per 0.866 of the area of pi (15^2 - 4^2) less a triangle of 7.
    let expected = (std::f64::consts::PI * (225.0 - 16.0) - 6.0) / 0.75_f64.sqrt();
    assert_within(count as f64, expected, 0.03 * expected);
    // Identities have no gaps.
    let world = simulation.world_mut();
    let mut ids: Vec<u32> = world.query::<&BodyId>().iter(world).map(|id| id.0).collect();
    ids.sort_unstable();
    assert!(ids.iter().copied().eq(0..count as u32));
}

#[test]
fn layers_and_minerals_follow_places() {
    for seed in [2, 19, 333] {
        let scene = parse(&format!(
            r#"(version: 1, title: "minerals", {MATERIALS},
            specimen: Packing(count: 4000, columns: 50, spacing: 1.0,
                sizes: Uniform(radius: (0.2, 0.5)), seed: {seed}, material: "rock"),
            minerals: [
                (material: "mica", select: Circle(centre: (25.0, 30.0), radius: 15.0)),
                (material: "clay", select: Layer(normal: (0.0, 1.0), from: 30.0, to: 40.0)),
            ])"#
        ));
        for Seed { position: (x, y), material, .. } in specimen(&scene, None) {
            // The layer has the last word.
            let expected = match (x, y) {
                _ if (30.0..=40.0).contains(&y) => "clay",
                _ if (x - 25.0).hypot(y - 30.0) <= 15.0 => "mica",
                _ => "rock",
            };
            assert_eq!(material.as_deref(), Some(expected), "seed {seed}: ({x}, {y})");
        }
    }
}

/// A bonded lattice of 6 x 9 disks with Weibull strengths that is pulled apart, its disks in some
/// order.
fn pulled(order: impl Fn(usize) -> usize, seed: u32) -> (BTreeMap<[u64; 4], BondLaw>, Vec<f64>) {
    let mut places = Vec::new();
    for row in 0..9 {
        for column in 0..6 - row % 2 {
            places.push((
                f64::from(2 * column + row % 2) * 1.0e-3,
                f64::from(row) * 3.0_f64.sqrt() * 1.0e-3,
            ));
        }
    }
    let list: Vec<_> = (0..places.len())
        .map(|k| format!("(position: {:?}, radius: 1.0e-3)", places[order(k)]))
        .collect();
    let scene = parse(&format!(
        r#"(version: 1, title: "pulled", rupture: (rolling: Yields),
        materials: {{ "rock": (
            contact: (normal_stiffness: 1.0e7, tangential_stiffness: 5.0e6, friction: 0.5),
            bond: (normal_stiffness: 1.0e7, tangential_stiffness: 5.0e6, friction: 0.5,
                cohesion: 1.0e6, tensile_strength: 1.0e6, scatter: (seed: {seed},
                strength: Weibull(modulus: 3.0), normal_stiffness: LogNormal(deviation: 0.2))),
        ) }},
        specimen: Particles([{}]),
        stages: [
            Cement(name: "cement", length: 1.0e-5),
            Load(name: "pull", increments: 8, particles: [
                (select: Layer(normal: (0.0, 1.0), from: -1.0, to: 1.0e-3), x: Held, y: Held),
                (select: Layer(normal: (0.0, 1.0), from: 13.0e-3, to: 1.0), x: Held, y: Displacement(1.0e-5)),
            ]),
        ],
        measures: [(name: "axial_strain", of: Strain(Region(component: Yy, min: (-1.0, -1.0), max: (1.0, 1.0)))),
            (name: "axial_stress", of: Stress(Average(component: Yy, area: Fixed(1.4e-4))))])"#,
        list.join(", ")
    ));
    let mut simulation = Simulation::new(&scene, None);
    let mut curve = Vec::new();
    while let Some(record) = crate::common::next(&mut simulation) {
        curve.push(record.axial_stress.unwrap_or(f64::NAN));
    }
    assert!(matches!(simulation.run(), Outcome::Completed | Outcome::Collapsed(_)));
    let world = simulation.world_mut();
    let origins: BTreeMap<BodyId, [u64; 2]> = world
        .query::<(&BodyId, &clastic::components::body::BodyOrigin)>()
        .iter(world)
        .map(|(id, x)| (*id, x.0.to_array().map(f64::to_bits)))
        .collect();
    let mut bonds = world.query::<&Bond>();
    let laws = bonds.iter(world).map(|bond| {
        let mut ends = [origins[&bond.a], origins[&bond.b]];
        ends.sort_unstable();
        ([ends[0][0], ends[0][1], ends[1][0], ends[1][1]], bond.law)
    });
    (laws.collect(), curve)
}

#[test]
fn another_order_of_the_particles_changes_nothing() {
    for seed in [4, 77, 1234] {
        let (laws, curve) = pulled(|k| k, seed);
        assert!(laws.len() > 100);
        let strengths: Vec<f64> = laws.values().map(|law| law.tensile_strength).collect();
        let mean = strengths.iter().sum::<f64>() / strengths.len() as f64;
        // Four standard errors: the coefficient of variation of the modulus 3 is 0.363.
        assert_within(mean, 1.0e6, 4.0 * 0.363e6 / (strengths.len() as f64).sqrt());
        let (turned, turned_curve) = pulled(|k| (k * 17 + 5) % 50, seed);
        assert_eq!(turned, laws);
        assert_eq!(turned_curve.len(), curve.len());
        for (a, b) in curve.iter().zip(&turned_curve) {
            assert_relative(*a, *b, 1e-6);
        }
        assert_ne!(pulled(|k| k, seed + 1).0, laws);
    }
}

#[test]
fn the_strengths_of_the_shipped_scatter_have_their_mean_and_modulus() {
    for seed in [1, 31, 207] {
        let mut scene = load("scatter");
        let bond = scene.materials.get_mut("rock").unwrap().bond.as_mut().unwrap();
        bond.scatter.as_mut().unwrap().seed = seed;
        let clastic::scene::format::Stage::Load(pull) = &mut scene.stages[1] else { panic!() };
        pull.increments = 1;
        let mut simulation = Simulation::new(&scene, None);
        simulation.run();
        let world = simulation.world_mut();
        let strengths: Vec<f64> =
            world.query::<&Bond>().iter(world).map(|bond| bond.law.tensile_strength).collect();
        let n = strengths.len() as f64;
        assert!(n > 600.0, "{n}");
        let mean = strengths.iter().sum::<f64>() / n;
        // The coefficient of variation of the modulus 4 is 0.2806.
        assert_within(mean, 1.0e6, 3.0 * 0.2806e6 / n.sqrt());
        // Modulus of maximum likelihood, by bisection; its standard error is 0.78 m / sqrt(n)
        // (Thoman, Bain and Antle 1969).
        let rest = |m: f64| {
            let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
            for s in &strengths {
                let (s, log) = (s / mean, (s / mean).ln());
                a += s.powf(m) * log;
                b += s.powf(m);
                c += log;
            }
            a / b - 1.0 / m - c / n
        };
        let (mut low, mut high) = (0.5_f64, 50.0_f64);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if rest(middle) < 0.0 { low = middle } else { high = middle }
        }
        assert_within(low, 4.0, 3.0 * 0.78 * 4.0 / n.sqrt());
    }
}

#[test]
fn a_notched_beam_cracks_at_the_tip_of_its_notch() {
    for seed in [5, 88, 901] {
        let mut scene = load("notched_beam");
        let bond = scene.materials.get_mut("rock").unwrap().bond.as_mut().unwrap();
        bond.scatter.as_mut().unwrap().seed = seed;
        let mut simulation = Simulation::new(&scene, None);
        let first = std::iter::from_fn(|| crate::common::next(&mut simulation))
            .find_map(|record| record.ruptures.first().copied())
            .unwrap();
        // Two rows above the notch, which ends at 20 mm, in the middle.
        assert_within(first.position.x, 0.2, 4.0e-3);
        assert_within(first.position.y, 0.025, 4.0e-3);
    }
}

#[test]
fn disks_of_the_shipped_sieve_curve_follow_it_under_the_pressure() {
    for seed in [6, 44, 712] {
        let mut scene = load("sieve_curve");
        let clastic::scene::format::Specimen::Packing { seed: of, .. } = &mut scene.specimen else {
            panic!()
        };
        *of = seed;
        let mut simulation = Simulation::new(&scene, None);
        let mut last = None;
        while let Some(record) = crate::common::next(&mut simulation) {
            last = Some(record);
        }
        let last = last.unwrap();
        assert_relative(last.axial_stress.unwrap(), 100.0e3, 1e-6);
        assert_relative(last.lateral_stress.unwrap(), 100.0e3, 1e-6);
        let disks = particles(&mut simulation);
        let mass = |below: f64| -> f64 {
            disks.iter().map(|(_, r, _)| if 2.0 * r < below { r * r } else { 0.0 }).sum()
        };
        // The largest disk has a share of 0.8 %.
        assert_within(mass(2.8e-3) / mass(1.0), 0.4, 0.008);
        assert!(disks.iter().all(|(_, r, _)| (1.0e-3..=2.0e-3).contains(r)));
    }
}

#[test]
fn strains_of_two_layers_are_as_their_stiffnesses() {
    use clastic::run::measures::reading;
    let mut simulation = Simulation::new(&load("two_layers"), None);
    assert_eq!(simulation.run(), Outcome::Completed);
    let value = |name| reading(simulation.world(), name).unwrap();
    let stress = value("axial_stress");
    assert_relative(value("stress_soft"), stress, 0.01);
    assert_relative(value("stress_stiff"), stress, 0.01);
    assert_relative(value("strain_soft") / value("strain_stiff"), 4.0, 0.05);
}
