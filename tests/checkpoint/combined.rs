//! Features beside each other: a run that goes on from any increment leaves the same bytes.

use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;

use crate::resumed::{load, parse, same_from_anywhere};

/// Grains are poured on a packing. Some grains of the packing and some of the poured ones form rigid
/// groups in between.
const POUR: &str = r#"(
    version: 1,
    title: "Pour beside rigid groups, a compaction and a landing",
    gravity: (0.0, -9.81),
    analysis: Dynamic(dt: 2.0e-3),
    friction_law: LAW,
    materials: { "m": (density: 2000.0,
        contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4)) },
    specimen: Packing(count: 24, columns: 6, spacing: 0.021, sizes: Uniform(radius: (0.007, 0.01)), seed: 5),
    walls: [
        (name: "floor", start: (0.0, 0.0), end: (0.126, 0.0), contact: (friction: 0.4), probe: "floor"),
        (name: "top", start: (0.126, 0.084), end: (0.0, 0.084)),
        (name: "left", start: (0.0, 0.3), end: (0.0, 0.0)),
        (name: "right", start: (0.126, 0.0), end: (0.126, 0.3)),
    ],
    stages: [
        Compact(name: "compact", wall: "top", base: "floor", target: Porosity(0.3), step: 2.0e-3,
            agitation: 0.1, seed: 5),
        Load(name: "open", increments: 4, remove_walls: ["top"]),
        Pour(name: "pour", increments: 30, through: Segment(start: (0.02, 0.2), end: (0.1, 0.2)),
            rate: Number(200.0), sizes: Uniform(radius: (0.006, 0.009)), seed: 2, velocity: (0.0, -1.0),
            group: "new", rigid: { "block": (select: Box(min: (-1.0, -1.0), max: (1.0, 0.03))) },
            stop: [Until("t_s", 0.0431)]),
        Pour(name: "more", increments: 12, through: Segment(start: (0.02, 0.2), end: (0.1, 0.2)),
            rate: Number(200.0), sizes: Uniform(radius: (0.006, 0.009)), seed: 2, velocity: (0.0, -1.0),
            rigid: { "lump": (select: Group("new")) }),
        Load(name: "apart", increments: 5, release: ["block", "lump"]),
    ],
    measures: [
        (name: "t_s", of: Time),
        (name: "poured", of: Poured(Number)),
    ],
    output: (frames_every: 6, energy: true),
)"#;

#[test]
fn a_pour_with_rigid_groups_a_compaction_and_a_landing_under_either_law() {
    for law in ["Associated", "Coulomb()"] {
        let records =
            same_from_anywhere(&parse(&POUR.replace("LAW", law)), |n| n % 4 == 0 || n > 40);
        let ended =
            |o: &Observation| matches!(o.status, IncrementStatus::Solved | IncrementStatus::Capped);
        assert!(records.iter().all(ended), "{law}");
        let landed = records.iter().rfind(|o| o.stage == "pour").unwrap();
        assert!((landed.time - 0.0431).abs() <= 1e-6 * 0.0431, "{law}: {}", landed.time);
        let of = |stage: &str| records.iter().filter(|o| o.stage == stage).count();
        assert!(
            of("compact") > 3 && of("pour") < 24 && of("more") == 12 && of("apart") == 5,
            "{law}"
        );
    }
}

/// A wall on a table, bonds that break one by one, and halved increments in one run. The wall ends
/// at the end of its table whatever the increments were.
#[test]
fn events_and_a_wall_on_a_table_and_followed_motions() {
    let table = r#"stages.load.walls={ "bottom": Fixed, "top": Follow(Displacement([
        (0.0, 0.0, 0.0), (0.4, 0.0, -0.9e-3), (1.0, 0.0, -1.3e-3)])) }"#;
    let probe = r#"walls.top.probe="top""#;
    for law in ["friction_law=Associated", "friction_law=Coulomb()"] {
        let sets = [
            law,
            table,
            probe,
            "rupture.order=Events",
            "rupture.density=30.0",
            "rupture.brittleness=0.0",
            "acceptance.turn=0.001",
            "stages.confine.increments=2",
            "stages.load.increments=4",
            "stages.load.stop=[]",
        ];
        let records =
            same_from_anywhere(&load("biaxial_small", &sets), |n| [10, 35, 50].contains(&n));
        let ended =
            |o: &Observation| matches!(o.status, IncrementStatus::Solved | IncrementStatus::Capped);
        assert!(records.iter().all(ended), "{law}");
        let place = |o: &Observation| o.probes.iter().find(|p| p.name == "top").unwrap().motion[1];
        let start = place(records.iter().rfind(|o| o.stage == "confine").unwrap());
        let end = place(records.last().unwrap());
        assert!((end - start + 1.3e-3).abs() < 1e-12, "{law}: {start} {end}");
        assert!(records.iter().any(|o| !o.ruptures.is_empty()), "{law}: no bond broke");
        // Shortened to the ruptures.
        let first = records.iter().position(|o| !o.ruptures.is_empty()).unwrap();
        let short = |o: &&Observation| o.fraction > 0.0 && o.fraction < 0.5;
        assert!(records[first..].iter().filter(short).count() >= 3, "{law}");
    }
}
