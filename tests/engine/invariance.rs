//! A curve does not depend on how the specimen lies, on how its particles are numbered, or on when
//! it is computed.

use crate::common::*;
use clastic::run::Simulation;
use clastic::scene::format::{ExplicitBond, Particle, Scene, Specimen, WallControl};
use glam::{DMat2, DVec2};

/// The small cell with its prepared specimen listed particle by particle and bond by bond, driven
/// by its lid while the right wall gives way. A grain that nothing holds would have no determined
/// place, so every grain is bonded.
fn prepared() -> Scene {
    let mut scene = small_cell(ROUGH, ROUGH);
    weaken(&mut scene);
    let compact = scene.stages.remove(0);
    let stages = std::mem::replace(&mut scene.stages, vec![compact]);
    let mut simulation = Simulation::new(&scene, None);
    while next(&mut simulation).is_some() {}
    let top = simulation.world().resource::<clastic::components::observation::Observation>();
    let lid = probe(top, "top").motion[1];
    scene.walls[1].start.1 += lid;
    scene.walls[1].end.1 += lid;
    let grains = states(&mut simulation);
    scene.specimen = Specimen::Particles(
        grains
            .iter()
            .enumerate()
            .map(|(i, s)| Particle {
                position: s.position.into(),
                radius: s.radius,
                material: None,
                velocity: (0.0, 0.0),
                angular_velocity: 0.0,
                group: None,
                probe: Some(format!("{i}")),
            })
            .collect(),
    );
    scene.stages = stages;
    scene.stages.retain(|s| s.name() == "load");
    // Three of four neighbours are bonded, which holds every grain; the others only touch.
    for b in 0..grains.len() {
        for a in 0..b {
            let gap = grains[a].position.distance(grains[b].position)
                - grains[a].radius
                - grains[b].radius;
            if gap < 0.4e-3 && (7 * a + b) % 4 != 0 {
                scene.bonds.push(ExplicitBond { a: a as u32, b: b as u32 });
            }
        }
    }
    let bonded =
        |i: usize| scene.bonds.iter().any(|bond| bond.a as usize == i || bond.b as usize == i);
    assert!((0..grains.len()).all(bonded));
    let load = stage(&mut scene, "load");
    load.walls.clear();
    load.walls.insert("top".into(), WallControl::Displacement(0.0, -2e-6));
    load.walls.insert("right".into(), WallControl::Displacement(1e-6, 0.0));
    load.increments = 60;
    scene
}

/// Bonds that break before long.
fn weaken(scene: &mut Scene) {
    let bond = scene.materials.get_mut("sand").unwrap().bond.as_mut().unwrap();
    (bond.cohesion, bond.tensile_strength) = (10e3, 5e3);
}

/// The scene seen through a linear map, a rotation or a reflection. A reflection swaps the ends of
/// walls, since material lies on their left.
fn mapped(scene: &Scene, map: DMat2) -> Scene {
    let of = |x: (f64, f64)| (map * DVec2::from(x)).into();
    let mut scene = scene.clone();
    let Specimen::Particles(list) = &mut scene.specimen else { unreachable!() };
    for particle in list {
        particle.position = of(particle.position);
    }
    for wall in &mut scene.walls {
        (wall.start, wall.end) = (of(wall.start), of(wall.end));
        if map.determinant() < 0.0 {
            std::mem::swap(&mut wall.start, &mut wall.end);
        }
    }
    for control in stage(&mut scene, "load").walls.values_mut() {
        if let WallControl::Displacement(x, y) = control {
            (*x, *y) = of((*x, *y));
        }
    }
    scene
}

/// What is compared of an increment: forces on the walls, mapped back, and the pairs of grains, by
/// probe, whose bond broke.
struct Row {
    forces: [DVec2; 4],
    broken: Vec<(String, String)>,
}

/// The curve up to and with the first rupture.
fn curve(scene: &Scene, map: DMat2) -> Vec<Row> {
    let Specimen::Particles(list) = &scene.specimen else { unreachable!() };
    let name = |i: u32| list[i as usize].probe.clone().unwrap();
    let back = map.transpose();
    let mut simulation = Simulation::new(scene, None);
    let mut rows = Vec::new();
    while let Some(record) = next(&mut simulation) {
        let vector = |v: [f64; 3]| back * DVec2::new(v[0], v[1]);
        let mut broken: Vec<_> = record
            .ruptures
            .iter()
            .map(|r| {
                let (a, b) = (name(r.a.0), name(r.b.0));
                if a < b { (a, b) } else { (b, a) }
            })
            .collect();
        broken.sort();
        let forces =
            ["bottom", "top", "left", "right"].map(|wall| vector(probe(&record, wall).force));
        let done = !broken.is_empty();
        rows.push(Row { forces, broken });
        if done {
            return rows;
        }
    }
    panic!("nothing broke: {:?} after {} increments", simulation.run(), rows.len());
}

fn assert_same_curve(scene: &Scene, map: DMat2, reference: &[Row]) {
    let rows = curve(scene, map);
    assert_eq!(rows.len(), reference.len());
    let maximum = reference.iter().map(|r| r.forces[1].length()).fold(0.0, f64::max);
    for (row, expected) in rows.iter().zip(reference) {
        assert_eq!(row.broken, expected.broken);
        for (force, expected) in row.forces.iter().zip(&expected.forces) {
            assert_within(force.distance(*expected), 0.0, 1e-9 * maximum);
        }
    }
}

#[test]
fn curve_is_the_same_turned_mirrored_and_renumbered() {
    let scene = prepared();
    let reference = curve(&scene, DMat2::IDENTITY);
    assert!(reference.len() > 5, "an elastic range of {} increments", reference.len());
    assert!(!reference.last().unwrap().broken.is_empty());

    for degrees in [30.0_f64, 137.0] {
        let turn = DMat2::from_angle(degrees.to_radians());
        assert_same_curve(&mapped(&scene, turn), turn, &reference);
    }
    let mirror = DMat2::from_diagonal(DVec2::new(-1.0, 1.0));
    assert_same_curve(&mapped(&scene, mirror), mirror, &reference);

    // Another order: every index times a number without a common factor.
    let mut renumbered = scene.clone();
    let Specimen::Particles(list) = &mut renumbered.specimen else { unreachable!() };
    let n = list.len();
    *list = (0..n).map(|i| list[i * 37 % n].clone()).collect();
    let new_index = |old: u32| (0..n).find(|i| i * 37 % n == old as usize).unwrap() as u32;
    for bond in &mut renumbered.bonds {
        (bond.a, bond.b) = (new_index(bond.a), new_index(bond.b));
    }
    assert_same_curve(&renumbered, DMat2::IDENTITY, &reference);
}

#[test]
fn two_runs_agree_to_the_last_bit() {
    let everything = |scene: &Scene| {
        let mut simulation = Simulation::new(scene, None);
        let mut out = Vec::new();
        while let Some(record) = next(&mut simulation) {
            out.push(format!("{record:?}"));
        }
        // Formatted numbers are the shortest that read back as the same bits.
        out.push(format!("{:?}", states(&mut simulation)));
        out
    };
    let mut statics = small_cell(ROUGH, ROUGH);
    weaken(&mut statics);
    let dynamics = swarm("Coulomb()", RIGID, 2e-4, 0.7, 40);
    for scene in [statics, dynamics] {
        let (first, second) = (everything(&scene), everything(&scene));
        assert!(first.len() > 30);
        assert!(first == second, "{}", scene.title);
    }
}
