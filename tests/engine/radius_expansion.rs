//! Compaction by growing radii: radii, porosity, masses and gaps by hand.

use std::f64::consts::PI;

use clastic::components::body::{BodyId, BodyPosition};
use clastic::components::cell::PeriodicCell;
use clastic::components::increment::ClasticProgress;
use clastic::components::particle::Particle;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::{Compact, CompactTarget, Scene, Specimen, Stage};
use glam::DVec2;

use crate::common::{assert_relative, assert_within, load, next, parse};

/// Place and disk of every particle, by identity.
fn disks(simulation: &mut Simulation) -> Vec<(DVec2, Particle)> {
    let world = simulation.world_mut();
    let mut query = world.query::<(&BodyId, &BodyPosition, &Particle)>();
    let mut found: Vec<_> = query.iter(world).map(|(id, x, disk)| (*id, (x.0, *disk))).collect();
    found.sort_by_key(|(id, _)| *id);
    found.into_iter().map(|(_, disk)| disk).collect()
}

fn expansion(scene: &mut Scene) -> &mut Compact {
    let Stage::Compact(stage) = &mut scene.stages[0] else { panic!("no compaction") };
    stage
}

/// Runs to the end of the first stage.
fn expand(simulation: &mut Simulation) {
    while simulation.world().resource::<ClasticProgress>().stage == 0 {
        let progress = simulation.world().resource::<ClasticProgress>();
        if progress.total > 0.0 && progress.is_over() {
            break;
        }
        assert!(next(simulation).is_some(), "the run ended");
    }
}

/// All radii are those drawn times sqrt((1 - n) A / sum of pi r^2), at the density of before.
fn assert_grown(before: &[(DVec2, Particle)], after: &[(DVec2, Particle)], area: f64, n: f64) {
    let drawn: f64 = before.iter().map(|(_, disk)| PI * disk.radius.powi(2)).sum();
    let factor = ((1.0 - n) * area / drawn).sqrt();
    assert!(factor > 1.3, "{factor}");
    for ((_, before), (_, after)) in before.iter().zip(after) {
        assert_relative(after.radius, factor * before.radius, 1e-12);
        assert_relative(after.mass, factor.powi(2) * before.mass, 1e-12);
        assert_relative(after.inertia, 0.5 * after.mass * after.radius.powi(2), 1e-12);
    }
    let solid: f64 = after.iter().map(|(_, disk)| PI * disk.radius.powi(2)).sum();
    assert_relative(1.0 - solid / area, n, 1e-12);
}

#[test]
fn radii_grow_by_one_factor_to_the_porosity_and_no_disks_overlap() {
    for (seed, law) in [(7, "Associated"), (45, "Coulomb"), (713, "Associated")] {
        let mut scene = load("radius_expansion");
        let Specimen::Packing { seed: of, .. } = &mut scene.specimen else { panic!() };
        *of = seed;
        if law == "Coulomb" {
            scene.friction_law = parse(
                r#"(version: 1, title: "law", materials: {"m": ()}, friction_law: Coulomb(),
                specimen: Particles([(position: (0.0, 0.0), radius: 1.0)]),
                stages: [Load(name: "l", increments: 1)])"#,
            )
            .friction_law;
        }
        let mut simulation = Simulation::new(&scene, None);
        let before = disks(&mut simulation);
        expand(&mut simulation);
        let after = disks(&mut simulation);
        assert_grown(&before, &after, 0.04 * 0.08, 0.2);
        let radius = after.iter().map(|(_, disk)| disk.radius).sum::<f64>() / 200.0;
        let mut overlap = 0.0_f64;
        for (k, (a, one)) in after.iter().enumerate() {
            for (b, other) in &after[k + 1..] {
                overlap = overlap.max(one.radius + other.radius - a.distance(*b));
            }
            let to_walls = a.min(DVec2::new(0.04, 0.08) - *a).min_element();
            overlap = overlap.max(one.radius - to_walls);
        }
        assert!(overlap < 1e-6 * radius, "seed {seed}: overlap {overlap:e} m");
        let mut last = None;
        while let Some(record) = next(&mut simulation) {
            last = Some(record);
        }
        let last = last.unwrap();
        assert_relative(last.axial_stress.unwrap(), 100.0e3, 1e-4);
        assert_relative(last.lateral_stress.unwrap(), 100.0e3, 1e-4);
        assert_eq!(simulation.run(), Outcome::Completed, "seed {seed}");
        // The loading changes no radius.
        for ((_, before), (_, after)) in after.iter().zip(disks(&mut simulation)) {
            assert_eq!(*before, after);
        }
    }
}

#[test]
fn disks_of_a_periodic_cell_grow_while_the_cell_stands_still() {
    let scene = parse(
        r#"(version: 1, title: "cell", materials: {"m": ()}, cell: (size: (20.0, 20.0)),
        specimen: Packing(count: 100, columns: 10, spacing: 2.0,
            sizes: Uniform(radius: (0.4, 0.8)), seed: 5),
        stages: [Compact(name: "expand", target: Porosity(0.22), by: Radii, step: 0.01,
            agitation: 0.1)])"#,
    );
    let mut simulation = Simulation::new(&scene, None);
    let before = disks(&mut simulation);
    assert_eq!(simulation.run(), Outcome::Completed);
    let after = disks(&mut simulation);
    assert_grown(&before, &after, 400.0, 0.22);
    let cell = simulation.world().resource::<PeriodicCell>();
    assert_eq!([cell.width, cell.height, cell.tilt], [20.0, 20.0, 0.0]);
    for (k, (a, one)) in after.iter().enumerate() {
        for (b, other) in &after[k + 1..] {
            let d = *b - *a;
            let d = d - 20.0 * (d / 20.0).round();
            assert_within((one.radius + other.radius - d.length()).max(0.0), 0.0, 1e-6);
        }
    }
}

#[test]
fn a_packing_that_jams_while_it_grows_says_at_what_porosity() {
    let mut scene = load("radius_expansion");
    expansion(&mut scene).target = CompactTarget::Porosity(0.1);
    let mut simulation = Simulation::new(&scene, None);
    let before = disks(&mut simulation);
    let Outcome::Undecided { message, .. } = simulation.run() else { panic!("it did not jam") };
    assert!(message.contains("jammed") && message.contains("a porosity of 0.1"), "{message}");
    // The radii are those of the last committed increment: still in proportion.
    let after = disks(&mut simulation);
    let factor = after[0].1.radius / before[0].1.radius;
    for ((_, before), (_, after)) in before.iter().zip(after) {
        assert_relative(after.radius, factor * before.radius, 1e-12);
    }
}

#[test]
fn bonded_grains_do_not_grow() {
    let scene = parse(
        r#"(version: 1, title: "bonded", materials: {"m": (bond: (cohesion: 1.0, tensile_strength: 1.0))},
        specimen: Lattice(columns: 3, rows: 3, radius: 0.5, origin: (0.5, 0.5)),
        walls: [(name: "bottom", start: (0.0, 0.0), end: (4.0, 0.0)),
            (name: "top", start: (4.0, 4.0), end: (0.0, 4.0))],
        stages: [Cement(name: "cement", length: 0.01),
            Compact(name: "expand", wall: "top", base: "bottom", target: Porosity(0.2),
                by: Radii, step: 0.01)])"#,
    );
    let Outcome::Refused { stage, message } = Simulation::new(&scene, None).run() else {
        panic!("not refused")
    };
    assert_eq!(stage, "expand");
    assert!(message.contains("compact before `Cement`"), "{message}");
}
