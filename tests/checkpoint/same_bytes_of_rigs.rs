//! The same bytes from interrupted runs of rigs: cells, rigid groups, thin walls and lids, walls that
//! turn, bodies that come and go.

use std::collections::BTreeSet;

use clastic::components::attempt::IncrementStatus;

use crate::resumed::{load_small_cell, parse, same_from_anywhere};
use crate::same_bytes::EACH_LAW;

/// A periodic cell is state: its size, its shear, its stresses and what a stage does with it.
#[test]
fn a_periodic_cell_under_both_laws() {
    for law in ["Associated", "Coulomb()"] {
        let law = format!("friction_law={law}");
        let sets = [law.as_str(), "stages.shear.increments=5"];
        let with_ledger: Vec<&str> = sets.into_iter().chain(["output=(energy: true)"]).collect();
        let loaded = load_small_cell(&with_ledger);
        let records = same_from_anywhere(&loaded, |k| k % 2 == 1);
        assert!(records.iter().any(|o| o.stage == "shear" && o.fraction == 1.0));
        // With the mean stress held, in time steps.
        let mean = "stages.shear.cell=(mean: Stress(50.0e3), shear: Strain(0.02))";
        let dynamic = "stages.shear.analysis=Dynamic(dt: 1.0e-4)";
        let sets: Vec<&str> = sets.into_iter().chain([mean, dynamic]).collect();
        let records = same_from_anywhere(&load_small_cell(&sets), |k| k % 2 == 1);
        assert!(records.iter().any(|o| o.stage == "shear" && o.time > 0.0));
    }
}

/// Rigid groups are state: who belongs to them, where they are, and what is done to them. A
/// specimen of bonded and loose disks between two groups of them, pressed, turned, released and
/// made again.
#[test]
fn rigid_groups_in_both_analyses_and_under_both_laws() {
    for (law, analysis) in [
        ("Associated", "Static"),
        ("Coulomb()", "Static"),
        ("Associated", "Dynamic(dt: 1.0e-3, theta: 0.6)"),
        ("Coulomb()", "Dynamic(dt: 1.0e-3, theta: 1.0)"),
    ] {
        let contact = "normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4";
        let loaded = parse(&format!(
            "(version: 1, title: \"groups\", friction_law: {law}, analysis: {analysis},
              gravity: (0.0, -9.81),
              materials: {{ \"m\": (density: 2000.0, contact: ({contact}),
                bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, cohesion: 1.0e7,
                    tensile_strength: 1.0e7)) }},
              specimen: Lattice(columns: 5, rows: 6, radius: 0.01),
              walls: [(name: \"floor\", start: (-1.0, -0.01), end: (1.0, -0.01), contact: ({contact}),
                probe: \"floor\")],
              stages: [
                Cement(name: \"cement\", length: 1.0e-4),
                Load(name: \"press\", increments: 4, rigid: {{
                    \"lower\": (select: Box(min: (-1.0, -1.0), max: (1.0, 0.02)), x: Held, rotation: Held),
                    \"upper\": (select: Box(min: (-1.0, 0.07), max: (1.0, 1.0)),
                        stress: (value: (0.0, -2.0e3), length: 0.1)),
                }}),
                Load(name: \"turn\", increments: 5, rigid: {{
                    \"upper\": (x: Displacement(1.0e-6), rotation: Displacement(2.0e-5)) }}),
                Load(name: \"apart\", increments: 3, release: [\"upper\"]),
                Load(name: \"again\", increments: 3, rigid: {{
                    \"upper\": (select: Box(min: (-1.0, 0.07), max: (1.0, 1.0)),
                        about: (0.0, 0.07), x: Held, y: Held, moment: 1.0) }}),
              ],
              output: (energy: true))"
        ));
        let records = same_from_anywhere(&loaded, |_| true);
        assert!(records.len() >= 15, "{law} {analysis}: {}", records.len());
        assert!(records.iter().all(|o| o.status == IncrementStatus::Solved));
        // The bonds within a group do not count while it lasts.
        let bonds = |stage: &str| records.iter().find(|o| o.stage == stage).unwrap().bonds;
        assert!(bonds("apart") > bonds("turn") && bonds("again") < bonds("apart"));
    }
}

/// A hopper of polylines over an arc, in which a lid shears what has come to rest.
pub const THIN: &str = r#"(
    version: 1,
    title: "Thin walls of every shape",
    gravity: (0.0, -9.81),
    analysis: Dynamic(dt: 2.0e-3),
    friction_law: ByAnalysis,
    materials: { "sand": (density: 2650.0, contact: (friction: 0.3, normal_stiffness: 1.0e6,
        tangential_stiffness: 5.0e5)) },
    specimen: Packing(count: 20, columns: 5, spacing: 0.021, origin: (-0.0525, 0.06),
        sizes: Uniform(radius: (8.0e-3, 10.0e-3)), seed: 4),
    walls: [
        (name: "l", shape: Polyline([(-0.055, 0.05)]), start: (-0.055, 0.2), end: (-0.02, 0.0),
            contact: (friction: 0.2, normal_stiffness: 1.0e6, tangential_stiffness: 5.0e5), probe: "l"),
        (name: "r", shape: Polyline([(0.055, 0.05)]), start: (0.02, 0.0), end: (0.055, 0.2),
            contact: (friction: 0.2, normal_stiffness: 1.0e6, tangential_stiffness: 5.0e5), probe: "r"),
        (name: "bowl", shape: Arc(through: (0.0, -0.1)), start: (-0.08, -0.06), end: (0.08, -0.06),
            contact: (friction: 0.2, normal_stiffness: 1.0e6, tangential_stiffness: 5.0e5), probe: "bowl"),
        (name: "gate", shape: Segment, start: (-0.04, -0.002), end: (0.04, -0.002)),
        (name: "lid", shape: Segment, start: (0.05, 0.16), end: (-0.05, 0.16), present: false,
            contact: (friction: 0.3, normal_stiffness: 1.0e6, tangential_stiffness: 5.0e5), probe: "lid"),
    ],
    stages: [
        Load(name: "settle", increments: 60, walls: { "bowl": Follow(Displacement([
            (0.0, 0.0, 0.0), (0.02, 0.0, 2.0e-3), (0.06, 0.0, -1.0e-3)])) }),
        Load(name: "press", increments: 6, analysis: Static, add_walls: ["lid"],
            walls: { "lid": Follow(Stress(stress: [(0.0, 0.0), (0.5, 300.0), (1.0, 200.0)])) }),
        Load(name: "shear", increments: 10, analysis: Static,
            walls: { "lid": Lid(load: Stress(stress: 200.0), slide: Displacement(1.0e-5)) }),
        Load(name: "cycle", increments: 4, walls: { "lid": Stress(stress: 300.0) },
            scale: (loads: [(0.0, 0.0), (2.5e-3, 1.0), (6.0e-3, -0.5), (8.0e-3, 0.5)])),
        Load(name: "flow", increments: 40, remove_walls: ["gate", "lid"]),
    ],
    output: (frames_every: 20, energy: true),
)"#;

#[test]
fn thin_walls_lids_and_tables() {
    for law in EACH_LAW {
        let text = THIN.replace("ByAnalysis", law);
        let records = same_from_anywhere(&parse(&text), |k| k % 9 == 4);
        let stages: BTreeSet<_> = records.iter().map(|o| o.stage.as_str()).collect();
        assert_eq!(stages.len(), 5, "{law}");
        let flow = records.last().unwrap();
        assert!(flow.contacts > 10, "{law}: {} contacts", flow.contacts);
    }
}

/// A heap in a box from which particles are taken away twice, with bonds and without.
pub const EXCAVATION: &str = r#"(
    version: 1,
    title: "Excavation of a bonded and of a loose heap",
    gravity: (0.0, -9.81),
    friction_law: ByAnalysis,
    materials: { "stone": (density: 2000.0,
        contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4),
        bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, cohesion: 300.0, tensile_strength: 300.0)) },
    specimen: Lattice(columns: 6, rows: 5, radius: 0.01),
    probes: { "low": 2, "gone": 20 },
    walls: [
        (name: "floor", start: (-1.0, -0.01), end: (1.0, -0.01), probe: "floor",
            contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4)),
    ],
    stages: [
        Cement(name: "cement", length: 1.0e-4),
        Load(name: "stand", increments: 3),
        Remove(name: "dig", select: Box(min: (0.03, 0.03), max: (1.0, 1.0))),
        Load(name: "stand again", increments: 3),
        Remove(name: "more", select: Union([Index([3, 6]), Box(min: (-1.0, 0.06), max: (1.0, 1.0))])),
        Load(name: "fall", increments: 12, analysis: Dynamic(dt: 2.0e-3)),
    ],
    output: (frames_every: 3),
)"#;

#[test]
fn particles_that_are_taken_away() {
    for law in EACH_LAW {
        let text = EXCAVATION.replace("ByAnalysis", law);
        let records = same_from_anywhere(&parse(&text), |_| true);
        let bonds = |stage: &str| records.iter().find(|o| o.stage == stage).unwrap().bonds;
        assert!(bonds("stand") > bonds("stand again") && bonds("stand again") > bonds("fall"));
        assert!(records.iter().all(|o| o.status == IncrementStatus::Solved), "{law}");
    }
}

/// A packing that jams in a cell, is cemented by its coordination, and loses a grain and its strength.
pub const CAVITY: &str = r#"(
    version: 1,
    title: "Cavity",
    friction_law: ByAnalysis,
    materials: { "rock": (density: 2700.0,
        contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, friction: 0.5),
        bond: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, cohesion: 1.0e6, tensile_strength: 1.0e6)) },
    specimen: Packing(count: 36, columns: 6, spacing: 2.5e-3, sizes: Uniform(radius: (0.8e-3, 1.2e-3)), seed: 3),
    cell: (size: (15.0e-3, 15.0e-3)),
    stages: [
        Compact(name: "compact", target: Jammed, step: 0.4e-3, agitation: 0.1, seed: 1),
        Load(name: "press", increments: 4, cell: (xx: Stress(50.0e3), yy: Stress(50.0e3)),
            scale: (loads: [(0.0, 0.0), (0.4, 1.2), (1.0, 0.9)])),
        Cement(name: "glue", coordination: 4.0),
        Remove(name: "cavity", select: Index([7])),
        Load(name: "weaken", increments: 8, scale: (strength: [(0.0, 1.0), (1.0, 0.5)]), stop: [Above("moved", 0.5)]),
        Load(name: "move", increments: 4, analysis: Dynamic(dt: 1.0e-5), cell: (shear: Strain(1.0e-4)),
            scale: (strength: [(0.0, 0.5), (4.0e-5, 0.3)])),
    ],
    measures: [(name: "moved", of: Grains(amount: Share, moved: 1.0e-4)), (name: "n", of: Porosity(Cell))],
    reference_stage: "weaken",
)"#;

#[test]
fn a_cavity_in_a_jammed_cell_under_factors_on_strength() {
    for law in EACH_LAW {
        let records = same_from_anywhere(&parse(&CAVITY.replace("ByAnalysis", law)), |_| true);
        assert!(records.iter().any(|o| o.stage == "move"), "{law}");
    }
}

/// 64 disks in a cell, cemented under pressure, of which a box is cut out and pulled apart.
pub const CUT: &str = r#"(
    version: 1,
    title: "A specimen that is cut out of a cell",
    friction_law: ByAnalysis,
    materials: { "rock": (density: 2000.0,
        contact: (normal_stiffness: 3.0e8, tangential_stiffness: 2.0e8, friction: 0.5),
        bond: (normal_stiffness: 3.0e8, tangential_stiffness: 2.0e8, cohesion: 2.0e7, tensile_strength: 1.0e7)) },
    specimen: Packing(count: 64, columns: 8, spacing: 2.5e-3, sizes: Uniform(radius: (0.8e-3, 1.2e-3)), seed: 3),
    cell: (size: (20.0e-3, 20.0e-3)),
    walls: [
        (name: "bottom", start: (1.0e-3, 1.0e-3), end: (13.0e-3, 1.0e-3), present: false, touching: true),
        (name: "top", start: (13.0e-3, 1.0e-3), end: (1.0e-3, 1.0e-3), present: false, touching: true),
    ],
    stages: [
        Compact(name: "compact", target: Jammed, step: 1.0e-3, agitation: 0.1, seed: 1),
        Load(name: "press", increments: 3, cell: (xx: Stress(1.0e5), yy: Stress(1.0e5))),
        Cement(name: "cement", length: 0.1e-3),
        Remove(name: "cut", open_cell: true,
            select: Except(All, Box(min: (1.0e-3, 1.0e-3), max: (13.0e-3, 13.0e-3)))),
        Load(name: "platens", increments: 1, add_walls: ["bottom", "top"]),
        Cement(name: "glue", length: 1.5e-3, walls: true, particles: false),
        Load(name: "pull", increments: 6, walls: { "top": Displacement(0.0, 4.0e-6) }),
    ],
    measures: [
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "axial_stress", of: Stress(Walls(walls: ["bottom", "top"], length: Fixed(12.0e-3)))),
    ],
    output: (energy: true),
)"#;

#[test]
fn a_specimen_that_is_cut_out_of_a_cell() {
    for law in EACH_LAW {
        let records = same_from_anywhere(&parse(&CUT.replace("ByAnalysis", law)), |_| true);
        let of = |stage: &str| records.iter().filter(|o| o.stage == stage).count();
        assert!(of("press") > 0 && of("platens") > 0 && of("pull") > 5, "{law}");
    }
}

/// A bonded heap on a plate that turns, beside a polyline that spins, and a drum below; groups whose
/// force is measured.
pub const TURNING: &str = r#"(
    version: 1,
    title: "Walls that turn",
    gravity: (0.0, -9.81),
    friction_law: ByAnalysis,
    materials: { "stone": (density: 2000.0,
        contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4),
        bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, cohesion: 1.0e4, tensile_strength: 1.0e4)) },
    specimen: Lattice(columns: 6, rows: 4, radius: 0.01),
    walls: [
        (name: "plate", shape: Segment, start: (-0.05, -0.01), end: (0.15, -0.01), probe: "plate",
            contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4)),
        (name: "flap", shape: Polyline([(0.125, 0.02)]), start: (0.115, -0.005), end: (0.125, 0.06), probe: "flap",
            contact: (normal_stiffness: 1.0e6)),
        (name: "drum", shape: Arc(through: (0.0, 0.5)), start: (0.0, -0.5), end: (0.0, -0.5), probe: "drum",
            contact: (normal_stiffness: 1.0e6, friction: 0.4)),
    ],
    stages: [
        Cement(name: "cement", length: 1.0e-4, select: Layer(normal: (0.0, 1.0), from: -1.0, to: 0.02), walls: true),
        Load(name: "tilt", increments: 4,
            walls: { "plate": Rotation(about: (-0.05, -0.01), angle: 2.0e-3) }),
        Load(name: "spin", increments: 20, analysis: Dynamic(dt: 2.0e-3), walls: {
            "plate": Spin(about: (0.05, 0.0), angular_velocity: -2.0),
            "flap": Spin(about: (0.125, 0.06), angular_velocity: 1.0),
            "drum": Spin(about: (0.0, 0.0), angular_velocity: 3.0) }),
        Load(name: "hold", increments: 5, analysis: Dynamic(dt: 2.0e-3)),
    ],
    measures: [
        (name: "fixed_n", of: GroupForce(select: Box(min: (0.0, 0.03), max: (0.06, 1.0)), along: Y)),
        (name: "live_n", of: GroupForce(select: Box(min: (0.0, 0.03), max: (0.06, 1.0)), along: Y, live: true)),
        (name: "moment_nm", of: GroupForce(select: Index([0, 1, 2, 3, 4, 5, 6, 7]), along: Moment)),
    ],
    output: (energy: true),
)"#;

#[test]
fn walls_that_turn_and_groups_whose_force_is_measured() {
    for law in EACH_LAW {
        let text = TURNING.replace("ByAnalysis", law);
        let records = same_from_anywhere(&parse(&text), |k| k % 3 == 1);
        let last = records.last().unwrap();
        let turned = |name: &str| {
            last.probes.iter().find(|p| p.name == name).map_or(f64::NAN, |p| p.motion[2])
        };
        for (name, angle) in [("plate", 8e-3 - 0.08), ("flap", 0.04), ("drum", 0.12)] {
            assert!((turned(name) - angle).abs() < 1e-14, "{law} {name}: {}", turned(name));
        }
    }
}

/// A heap behind a gate under a moment, a cap of grains and a polyline that is one body, and a lid that
/// follows a table of angles.
pub const HINGED: &str = r#"(
    version: 1,
    title: "Walls in rigid groups",
    gravity: (0.0, -9.81),
    friction_law: ByAnalysis,
    materials: { "stone": (density: 2000.0,
        contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4),
        bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, cohesion: 1.0e4, tensile_strength: 1.0e4)) },
    specimen: Lattice(columns: 6, rows: 4, radius: 0.01),
    walls: [
        (name: "floor", start: (-1.0, -0.01), end: (1.0, -0.01), probe: "floor",
            contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4)),
        (name: "back", start: (-0.01, 1.0), end: (-0.01, -1.0), contact: (normal_stiffness: 1.0e6)),
        (name: "gate", shape: Segment, start: (0.11, -0.01), end: (0.11, 0.08), probe: "plate",
            contact: (normal_stiffness: 1.0e6, friction: 0.2)),
        (name: "vane", shape: Polyline([(0.05, 0.09)]), start: (0.02, 0.08), end: (0.08, 0.085), probe: "vane",
            contact: (normal_stiffness: 1.0e6)),
        (name: "lid", shape: Segment, start: (0.09, 0.2), end: (-0.01, 0.2), probe: "lid", present: false),
    ],
    stages: [
        Cement(name: "cement", length: 1.0e-4, select: Layer(normal: (0.0, 1.0), from: -1.0, to: 0.02)),
        Load(name: "lean", increments: 5, rigid: {
            "gate": (walls: ["gate"], about: (0.11, -0.01), x: Held, y: Held, moment: 0.5),
            "cap": (walls: ["vane"], select: Index([20, 21]), about: (0.04, 0.052), moment: 0.01) }),
        Load(name: "swing", increments: 20, analysis: Dynamic(dt: 2.0e-3), release: ["cap"], rigid: {
            "gate": (x: Held, y: Held, moment: 0.2) }),
        Load(name: "turn", increments: 6, add_walls: ["lid"], walls: { "lid": Follow(Rotation(about: (0.0, 0.2),
            angle: [(0.0, 0.0), (0.5, 0.02), (1.0, -0.01)])) }, rigid: { "gate": (x: Held, y: Held, rotation: Displacement(-1.0e-4)) }),
        Load(name: "back", increments: 4, rigid: { "gate": (x: Held, y: Held, moment: 0.4) }),
    ],
    output: (energy: true),
)"#;

#[test]
fn walls_in_rigid_groups_and_a_table_of_angles() {
    for law in EACH_LAW {
        let text = HINGED.replace("ByAnalysis", law);
        let records = same_from_anywhere(&parse(&text), |k| k % 3 == 1);
        let last = records.last().unwrap();
        let probe = |name: &str| last.probes.iter().find(|p| p.name == name).unwrap();
        assert!((probe("lid").motion[2] + 0.01).abs() < 1e-15, "{law}");
        assert!((probe("gate").force[2] + 0.4).abs() < 1e-8, "{law}");
    }
}

/// A box into which grains of two minerals are poured on a bonded block that stands there; some of
/// them are taken away, and others come through a full opening.
pub const POURED: &str = r#"(
    version: 1,
    title: "Grains that are poured in",
    gravity: (0.0, -9.81),
    analysis: Dynamic(dt: 2.0e-3),
    friction_law: ByAnalysis,
    materials: {
        "a": (density: 2000.0,
            contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.4),
            bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, cohesion: 1.0e4, tensile_strength: 1.0e4)),
        "b": (density: 3000.0, contact: (friction: 0.4)),
    },
    specimen: Lattice(columns: 3, rows: 2, radius: 0.01, material: "a"),
    walls: [
        (name: "floor", start: (-1.0, -0.01), end: (1.0, -0.01), contact: (friction: 0.4), probe: "floor"),
        (name: "chute", shape: Segment, start: (-0.05, 0.12), end: (0.0, 0.09), contact: (friction: 0.2)),
    ],
    stages: [
        Cement(name: "cement", length: 1.0e-4, select: Material("a")),
        Pour(name: "pour", increments: 40, through: Segment(start: (-0.06, 0.15), end: (0.06, 0.15)),
            rate: Mass(60.0), sizes: LogNormal(radius: 0.007, deviation: 0.3, limits: (0.005, 0.01)), seed: 2,
            material: "a", minerals: { "b": 0.4 }, velocity: (0.2, -1.0), group: "new"),
        Remove(name: "out", select: Intersection([Group("new"), Material("b")])),
        Pour(name: "more", increments: 30, through: Box(min: (-0.03, 0.1), max: (0.03, 0.15)),
            rate: NumberOverStage(100), sizes: Sieve(passing: [(0.01, 0.0), (0.02, 100.0)]), seed: 2,
            material: "a", group: "late", stop: [Full(1.0)]),
        Load(name: "stand", increments: 4, analysis: Dynamic(dt: 1.0e-3)),
    ],
    measures: [
        (name: "kg", of: Poured(Mass)),
        (name: "on_new", of: GroupForce(select: Group("new"), along: Y, live: true)),
    ],
    output: (frames_every: 9, energy: true),
)"#;

#[test]
fn grains_that_are_poured_in_under_either_law_of_friction() {
    for law in EACH_LAW {
        let text = POURED.replace("ByAnalysis", law);
        let records = same_from_anywhere(&parse(&text), |n| n % 5 == 0 || n > 70 || n == 41);
        assert_eq!(records.len(), 74, "{law}");
        assert!(records.iter().all(|o| o.status == IncrementStatus::Solved), "{law}");
    }
}
