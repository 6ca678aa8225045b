//! A specimen that is cut out of a periodic cell, which then ends, and walls that come at its
//! outermost particles.

use std::collections::BTreeMap;

use glam::DVec2;

use clastic::components::body::{BodyId, BodyOrigin, BodyPosition};
use clastic::components::bond::Bond;
use clastic::components::cell::PeriodicCell;
use clastic::components::energy::EnergyLedger;
use clastic::components::particle::Particle;
use clastic::components::wall::WallName;
use clastic::run::measures::reading;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::{Measure, Quantity, Scene, Select, Stage, Strain, StrainComponent};

use crate::common::{next, parse, stage};

/// Corners of the box that is cut out, m.
const LOW: DVec2 = DVec2::new(0.011, 0.009);
const HIGH: DVec2 = DVec2::new(0.069, 0.083);

/// 150 cemented disks in a cell, of which a box is cut out and meets two platens and two bars.
fn scene(confine: &str) -> Scene {
    parse(&format!(
        r#"(
    version: 1, title: "cut",
    materials: {{ "rock": (contact: (normal_stiffness: 3.0e7, tangential_stiffness: 2.0e7, friction: 0.4),
        bond: (normal_stiffness: 6.0e7, tangential_stiffness: 4.0e7, friction: 0.5,
            cohesion: 5.0e6, tensile_strength: 5.0e6)) }},
    specimen: Packing(count: 150, columns: 10, spacing: 0.0121, sizes: Uniform(radius: (3.0e-3, 6.0e-3)), seed: 7),
    cell: (size: (0.121, 0.1815)),
    walls: [
        (name: "bottom", start: (0.0, 0.3), end: (0.1, 0.3), present: false, touching: true,
            contact: (normal_stiffness: 3.0e7)),
        (name: "top", start: (0.1, -0.2), end: (0.0, -0.2), present: false, touching: true,
            contact: (normal_stiffness: 3.0e7)),
        (name: "bar", shape: Segment, start: (-0.05, 0.06), end: (-0.05, 0.03), present: false, touching: true,
            contact: (normal_stiffness: 3.0e7)),
        (name: "jaw", shape: Arc(through: (0.2, 0.045)), start: (0.19, 0.02), end: (0.19, 0.07), present: false,
            touching: true, contact: (normal_stiffness: 3.0e7)),
    ],
    stages: [
        Compact(name: "compact", target: Jammed, step: 3.0e-3, agitation: 0.1, seed: 7),
        {confine}
        Cement(name: "cement", length: 0.6e-3),
        Load(name: "hold", increments: 1),
        Remove(name: "cut", select: Except(All, Box(min: ({:?}, {:?}), max: ({:?}, {:?}))), open_cell: true),
        Load(name: "rest", increments: 1, add_walls: ["bottom", "top", "bar", "jaw"]),
    ],
    output: (energy: true),
)"#,
        LOW.x, LOW.y, HIGH.x, HIGH.y
    ))
}

type Places = BTreeMap<BodyId, [DVec2; 2]>;

/// Place and origin of every particle.
fn places(simulation: &mut Simulation) -> Places {
    let world = simulation.world_mut();
    let mut all = world.query::<(&BodyId, &BodyPosition, &BodyOrigin, &Particle)>();
    all.iter(world).map(|(id, x, origin, _)| (*id, [x.0, origin.0])).collect()
}

fn bonds(simulation: &mut Simulation) -> Vec<(BodyId, BodyId)> {
    let world = simulation.world_mut();
    let mut found: Vec<_> = world.query::<&Bond>().iter(world).map(|b| (b.a, b.b)).collect();
    found.sort_unstable();
    found
}

/// The run up to its last increment in the cell.
fn in_cell(scene: &Scene) -> Simulation {
    let mut simulation = Simulation::new(scene, None);
    while next(&mut simulation).unwrap().stage != "hold" {}
    simulation
}

/// A packing without stress stays as it is: what lies in the box, put back into the cell, is left,
/// with the bonds that do not cross a side.
#[test]
fn what_lies_in_the_box_is_left_with_its_bonds() {
    let mut simulation = in_cell(&scene(""));
    let cell = *simulation.world().resource::<PeriodicCell>();
    let (before, bonds_before) = (places(&mut simulation), bonds(&mut simulation));
    // Compaction has moved disks across the sides, or the test shows less than it says.
    let strayed = before.values().filter(|[x, _]| cell.wrapped(*x) != *x).count();
    assert!(strayed > 3, "{strayed}");
    next(&mut simulation).unwrap();
    assert!(!simulation.world().contains_resource::<PeriodicCell>());
    let left = places(&mut simulation);
    let inside = |x: DVec2| x.cmpge(LOW).all() && x.cmple(HIGH).all();
    let expected: Places = before
        .iter()
        .map(|(id, [x, origin])| (*id, [cell.wrapped(*x), cell.wrapped(*x) + *origin - *x]))
        .filter(|(_, [x, _])| inside(*x))
        .collect();
    assert!(left.len() > 40 && left.keys().eq(expected.keys()));
    for (id, [x, origin]) in &left {
        let [x0, origin0] = expected[id];
        assert!(x.distance(x0) < 1e-12 && origin.distance(origin0) < 1e-12, "{id:?} {x} {x0}");
    }
    // A bond that stays is as long as it was, by the nearest images.
    let length = |of: &Places, (a, b): &(BodyId, BodyId)| Some(of.get(b)?[0] - of.get(a)?[0]);
    let stays = |pair: &&(BodyId, BodyId)| {
        let apart = length(&before, pair).unwrap();
        length(&left, pair).is_some_and(|now| (now - apart - cell.shift(apart)).length() < 1e-9)
    };
    let kept: Vec<_> = bonds_before.iter().filter(stays).copied().collect();
    assert!(kept.len() > 80 && kept.len() < bonds_before.len());
    assert_eq!(bonds(&mut simulation), kept);
}

/// Particles that are put back into the cell have not moved: the strain of a region, which counts from
/// their places in a stage before, is none.
#[test]
fn a_cut_strains_no_region() {
    let mut scene = scene("");
    scene.reference_stage = Some("hold".to_owned());
    let [min, max] = [LOW, HIGH].map(|x| (x.x, x.y));
    let of = Quantity::Strain(Strain::Region { component: StrainComponent::Xx, min, max });
    scene.measures.push(Measure { name: "strain".to_owned(), of });
    let mut simulation = in_cell(&scene);
    next(&mut simulation).unwrap();
    let strain = reading(simulation.world(), "strain").unwrap();
    assert!(strain.abs() < 1e-9, "{strain}");
}

/// Each wall touches the specimen, whether it was drawn outside of it or beyond its other side, and
/// cuts into no disk.
#[test]
fn walls_come_at_the_outermost_particles() {
    let mut simulation = in_cell(&scene(""));
    next(&mut simulation).unwrap();
    assert_eq!(simulation.run(), Outcome::Completed);
    let world = simulation.world_mut();
    let mut disks = world.query::<(&Particle, &BodyPosition)>();
    let disks: Vec<_> = disks.iter(world).map(|(p, x)| (x.0, p.radius)).collect();
    let mut walls = world.query::<(&WallName, &BodyPosition)>();
    let walls: BTreeMap<_, _> = walls.iter(world).map(|(name, x)| (name.0.clone(), x.0)).collect();
    let least = |of: &dyn Fn(DVec2) -> f64| {
        disks.iter().map(|(x, r)| of(*x) - r).min_by(f64::total_cmp).unwrap()
    };
    let [bottom, top, bar, jaw] = ["bottom", "top", "bar", "jaw"].map(|name| walls[name]);
    // The bar is 30 mm long about y = 45 mm. Three points give the circle of the jaw: its radius is
    // (25^2 + 10^2)/(2 * 10) = 36.25 mm, and its middle is drawn at x = 0.2.
    let to_bar = |x: DVec2| {
        let y = (x.y - 0.045).clamp(-0.015, 0.015);
        x.distance(DVec2::new(bar.x, 0.045 + y))
    };
    let centre = jaw - DVec2::new(0.03625, 0.0);
    let half = (25.0_f64 / 26.25).atan();
    let ends = [half, -half].map(|a| centre + 0.03625 * DVec2::from_angle(a));
    let to_jaw = |x: DVec2| {
        let from = x - centre;
        if from.to_angle().abs() <= half {
            (0.03625 - from.length()).abs()
        } else {
            ends.iter().map(|end| x.distance(*end)).fold(f64::INFINITY, f64::min)
        }
    };
    let gaps =
        [least(&|x| x.y - bottom.y), least(&|x| top.y - x.y), least(&to_bar), least(&to_jaw)];
    assert!(gaps.iter().all(|gap| (0.0..1e-8 * 6.0e-3).contains(&gap.abs())), "{gaps:?}");
    assert!(bar.y == 0.045 && (jaw.y - 0.045).abs() < 1e-15);
}

/// Out of a cell under pressure: particles take the energy of their contacts with them, and so do
/// the contacts across the sides. The books balance, and the specimen ends at rest.
#[test]
fn the_books_balance_when_a_cell_under_pressure_ends() {
    let press = r#"Load(name: "press", increments: 4, cell: (xx: Stress(2.0e4), yy: Stress(2.0e4), shear: Fixed)),"#;
    let mut simulation = in_cell(&scene(press));
    let before = simulation.world().resource::<EnergyLedger>().stored.unwrap();
    let record = next(&mut simulation).unwrap();
    assert!(record.status.is_committed(), "{record:?}");
    let ledger = simulation.world().resource::<EnergyLedger>();
    let e = ledger.increment;
    assert!(before > 0.0 && e.exchange < -0.2 * before, "{before} {e:?}");
    assert!(e.error().abs() < 1e-7 * ledger.total.throughput(), "{e:?}");
    // What stays is locked in by the bonds, or set free.
    assert!(ledger.stored.unwrap() < 0.8 * before);
}

/// A wall that nothing is in the way of is refused by name, before the stage changes anything.
#[test]
fn a_wall_that_meets_nothing_is_refused() {
    let mut scene = scene("");
    scene.walls[2].start.1 += 1.0;
    scene.walls[2].end.1 += 1.0;
    let mut simulation = in_cell(&scene);
    let Outcome::Refused { stage, message } = simulation.run() else { panic!("not refused") };
    assert_eq!(stage, "rest");
    assert!(
        message.contains("wall `bar` of add_walls is to touch the outermost particle"),
        "{message}"
    );
}

/// A cut that leaves nothing is refused before it changes anything: the cell is still there.
#[test]
fn a_cut_that_leaves_nothing_leaves_the_cell() {
    let mut scene = scene("");
    for stage in &mut scene.stages {
        if let Stage::Remove(cut) = stage {
            cut.select = Select::All;
        }
    }
    stage(&mut scene, "rest").add_walls.clear();
    let mut simulation = in_cell(&scene);
    let Outcome::Refused { stage, message } = simulation.run() else { panic!("not refused") };
    assert_eq!(stage, "cut");
    assert!(message.contains("nothing is left"), "{message}");
    assert!(simulation.world().contains_resource::<PeriodicCell>());
}

/// A box that reaches beyond the cell would leave a specimen with a ragged side.
#[test]
fn a_box_beyond_the_cell_is_refused() {
    let mut scene = scene("");
    for stage in &mut scene.stages {
        if let Stage::Remove(cut) = stage {
            let high = Select::Box { min: (0.01, 0.01), max: (0.12, 0.1) };
            cut.select = Select::Except(Box::new(Select::All), Box::new(high));
        }
    }
    let Outcome::Refused { stage, message } = in_cell(&scene).run() else { panic!("not refused") };
    assert_eq!(stage, "cut");
    assert!(message.contains("and the cell from (0, 0) to ("), "{message}");
}

/// A glue before the platens are there, and a cement of no length, would leave another rock than the
/// scene says.
#[test]
fn a_cement_that_bonds_nothing_is_refused() {
    let glue = r#"Cement(name: "glue", length: 1.0e-3, walls: true, particles: false),"#;
    let none = r#"Cement(name: "thin", length: 0.0),"#;
    for (stage, words) in [(glue, "no wall is there"), (none, "no gap of a pair")] {
        let mut simulation = Simulation::new(&scene(stage), None);
        let Outcome::Refused { message, .. } = simulation.run() else { panic!("not refused") };
        assert!(message.contains("it would bond nothing") && message.contains(words), "{message}");
    }
}

/// A line that comes through grains, whose centres are on its inner side, would press them with half of
/// their radius.
#[test]
fn a_line_that_cuts_through_grains_is_refused() {
    let mut scene = scene("");
    scene.walls[0].touching = false;
    (scene.walls[0].start, scene.walls[0].end) = ((0.0, LOW.y), (0.1, LOW.y));
    let mut simulation = in_cell(&scene);
    let Outcome::Refused { stage, message } = simulation.run() else { panic!("not refused") };
    assert_eq!(stage, "rest");
    assert!(message.contains("would cut through particle"), "{message}");
}
