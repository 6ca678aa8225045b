//! Tests of the ratios against values by hand.

use std::path::Path;

use super::*;
use crate::run::Simulation;
use crate::scene::format::{Bond, Cement, Scene, Stage};
use crate::scene::from_str;

/// Four columns of five disks of 10 mm, pressed with 10 kPa, then shortened by 0.02 mm an
/// increment.
fn scene(stiffness: &str, analysis: &str, motion: &str) -> Scene {
    let text = format!(
        r#"(version: 1, title: "t", thickness: 0.5,
        analysis: {analysis},
        materials: {{"m": (density: 2000.0, contact: (normal_stiffness: {stiffness}))}},
        specimen: Particles([{}]),
        walls: [
            (name: "bottom", start: (0.0, 0.0), end: (0.08, 0.0)),
            (name: "top", start: (0.08, 0.1), end: (0.0, 0.1)),
            (name: "left", start: (0.0, 0.1), end: (0.0, 0.0)),
            (name: "right", start: (0.08, 0.0), end: (0.08, 0.1)),
        ],
        stages: [
            Load(name: "press", increments: 1, walls: {{
                "top": Stress(stress: 10e3), "right": Stress(stress: 10e3) }}),
            Load(name: "load", increments: 2, walls: {{ "top": {motion} }}),
        ],
        measures: [
            (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
            (name: "axial_stress", of: Stress(Walls(walls: ["top"], length: Fixed(0.08)))),
            (name: "lateral_stress", of: Stress(Walls(walls: ["right"], length: Fixed(0.1)))),
        ])"#,
        (0..20)
            .map(|k| {
                let (x, y) = (0.01 + 0.02 * f64::from(k % 4), 0.01 + 0.02 * f64::from(k / 4));
                format!("(position: ({x}, {y}), radius: 0.01)")
            })
            .collect::<Vec<_>>()
            .join(",")
    );
    from_str(&text, Path::new("t.ron"), Path::new(""), &[]).unwrap_or_else(|e| panic!("{e}")).scene
}

fn near(found: Option<f64>, expected: f64, tolerance: f64) {
    let found = found.unwrap_or(f64::NAN);
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} for {expected}");
}

fn measured(scene: &Scene) -> Report {
    let mut simulation = Simulation::new(scene, None);
    simulation.run();
    simulation.world().resource::<Sanity>().report(scene)
}

#[test]
fn ratios_of_twenty_disks_are_those_by_hand_before_and_after() {
    let soft = scene("1e6", "Static", "Displacement(0.0, -2e-5)");
    let (first, after) = (before(&soft, None), measured(&soft));
    // 1e6 / (10e3 x 0.5); a strain of 2e-4 over p h/k = 5e-3.
    for report in [&first, &after] {
        near(report.stiffness_over_pressure, 200.0, 1e-6);
        near(report.increment_over_elastic_strain, 0.04, 0.02);
        near(report.disks_across, 4.0, 0.01);
        assert_eq!(report.inertial_number, None);
        assert!(report.warnings[0].contains("k/(p h) is 200"), "{:?}", report.warnings);
        assert!(report.warnings[1].contains("4.0 of the largest disks"), "{:?}", report.warnings);
        assert_eq!(report.warnings.len(), 2);
    }
    // A column carries 100 N under the pressure, an overlap of 1e-4 m, then four twelfths of 4e-5 m
    // more in each of its contacts: those at the rigid walls have the stiffness of the grains.
    let overlap = after.maximum_overlap_over_radius.unwrap();
    assert!(overlap > 0.01 && overlap < 0.012, "{overlap}");
}

#[test]
fn stiff_grains_and_small_steps_are_not_challenged_and_large_steps_are() {
    let stiff = before(&scene("1e8", "Static", "Displacement(0.0, -2e-5)"), None);
    near(stiff.increment_over_elastic_strain, 4.0, 1e-9);
    assert!(stiff.warnings[0].contains("4.0 elastic strains"), "{:?}", stiff.warnings);
    let fine = before(&scene("1e8", "Static", "Displacement(0.0, -2e-6)"), None);
    assert_eq!(fine.warnings.len(), 1, "{:?}", fine.warnings);
}

#[test]
fn the_inertial_number_of_a_fast_test_is_that_by_hand() {
    let fast = scene("1e7", "Dynamic(dt: 1e-5)", "Velocity(0.0, -1.0)");
    let (first, after) = (before(&fast, None), measured(&fast));
    // 10 1/s x sqrt(2000 pi 1e-4 0.5 / (1e4 x 0.5)).
    let mass: f64 = 2000.0 * std::f64::consts::PI * 1e-4 * 0.5;
    near(first.inertial_number, 10.0 * (mass / 5e3).sqrt(), 1e-9);
    assert!(first.warnings.iter().any(|w| w.contains("inertial number")), "{:?}", first.warnings);
    assert!(after.inertial_number.is_some_and(|number| number > QUASI_STATIC), "{after:?}");
    let slow = before(&scene("1e7", "Dynamic(dt: 1e-5)", "Velocity(0.0, -1e-4)"), None);
    assert!(!slow.warnings.iter().any(|w| w.contains("inertial number")), "{:?}", slow.warnings);
}

/// A cell that is sheared at constant height has no axial strain.
#[test]
fn the_inertial_number_of_a_shear_is_that_of_its_rate() {
    let text = r#"(version: 1, title: "t", analysis: Dynamic(dt: 1e-4),
        materials: {"m": (density: 2000.0, contact: (normal_stiffness: 1e7))},
        specimen: Packing(count: 36, columns: 6, spacing: 0.02, sizes: Uniform(radius: (0.006, 0.009)), seed: 5),
        cell: (size: (0.12, 0.12)),
        stages: [
            Compact(name: "compact", target: Porosity(0.2), step: 2e-3, agitation: 0.1, seed: 1),
            Load(name: "press", increments: 2, analysis: Static,
                cell: (xx: Stress(10e3), yy: Stress(10e3), shear: Fixed)),
            Load(name: "shear", increments: 100, cell: (xx: Fixed, yy: Stress(10e3), shear: Strain(0.05))),
        ],
        measures: [
            (name: "axial_strain", of: Strain(Cell(Height))),
            (name: "axial_stress", of: Stress(Average(component: Yy, area: Cell))),
        ])"#;
    let loaded =
        from_str(text, Path::new("t.ron"), Path::new(""), &[]).unwrap_or_else(|e| panic!("{e}"));
    let (first, after) = (before(&loaded.scene, None), measured(&loaded.scene));
    // 0.05 in 0.01 s.
    let mass = 2000.0 * std::f64::consts::PI * 0.0075 * 0.0075;
    near(first.inertial_number, 5.0 * (mass / 10e3_f64).sqrt(), 0.05);
    near(after.inertial_number, first.inertial_number.unwrap(), 0.3);
}

/// A disk that slides by `s` in each increment under a growing load.
fn scene_of_sliding(law: &str, s: f64) -> String {
    format!(
        r#"(version: 1, title: "t", friction_law: {law},
        materials: {{"m": (contact: (normal_stiffness: 1e6, tangential_stiffness: 1e6, friction: 0.5))}},
        specimen: Particles([(position: (0.0, 0.01), radius: 0.01), (position: (0.5, 0.01), radius: 0.01)]),
        walls: [(name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0),
            contact: (normal_stiffness: 1e6, tangential_stiffness: 1e6, friction: 0.5))],
        stages: [Load(name: "slide", increments: 50, particles: [
            (select: Index([0]), x: Displacement({s:e}), rotation: Held, force: (0.0, -100.0)),
            (select: Index([1]), x: Held, y: Held, rotation: Held)])],
        measures: [
            (name: "axial_strain", of: Strain(Particles(0, 1))),
            (name: "axial_stress", of: Stress(Average(component: Yy, area: Fixed(1.0)))),
        ])"#
    )
}

/// Rigid grains have no closure beside the gaps that they open: a friction angle of 31 degrees for 23
/// passed without a word.
#[test]
fn rigid_grains_that_slide_under_the_associated_law_are_told() {
    let warns = |law: &str| {
        let text = scene_of_sliding(law, 1e-4)
            .replace("normal_stiffness: 1e6, tangential_stiffness: 1e6, ", "");
        let loaded = from_str(&text, Path::new("t.ron"), Path::new(""), &[]);
        let report = measured(&loaded.unwrap_or_else(|e| panic!("{e}")).scene);
        report.warnings.iter().any(|warning| warning.contains("sliding contacts open"))
    };
    assert!(warns("Associated") && !warns("Coulomb()"));
}

/// Sand under constant load crept by up to five times its strain, and stiff grains had friction angles that
/// were 3 degrees too large, without a word. Under the associated law a disk that slides by s under the
/// load P opens mu s in every increment, beside an elastic closure of P/k.
#[test]
fn the_gap_that_sliding_opens_is_told_beside_the_elastic_closure() {
    let measured = |law: &str, s: f64| {
        let text = scene_of_sliding(law, s);
        let loaded = from_str(&text, Path::new("t.ron"), Path::new(""), &[]);
        measured(&loaded.unwrap_or_else(|e| panic!("{e}")).scene)
    };
    let report = measured("Associated", 1e-5);
    let mean = report.opening_over_closure.unwrap();
    assert!(mean > 0.01 && mean.is_finite(), "{mean}");
    let warns =
        |report: &Report| report.warnings.iter().any(|w| w.contains("sliding contacts open"));
    assert!(!warns(&report), "{:?}", report.warnings);
    let fast = measured("Associated", 1e-4);
    // The load grows by 2 N in each of 50 increments, and the spring takes mu times that over k of the way:
    // mu k (s - mu 2 N/k) sum p / sum p^2.
    near(fast.opening_over_closure, 0.5 * 1e6 * (1e-4 - 1e-6) * 3.0 / (101.0 * 2.0), 1e-3);
    assert!(warns(&fast), "{:?}", fast.warnings);
    assert_eq!(measured("Coulomb()", 1e-4).opening_over_closure, Some(0.0));
}

#[test]
fn lines_have_three_digits() {
    let report = Report {
        stiffness_over_pressure: Some(312.4),
        maximum_overlap_over_radius: Some(0.012_34),
        increment_over_elastic_strain: Some(1.234),
        ..Report::default()
    };
    let line = "k/(p h) 312; maximum overlap/radius 0.0123; increment/elastic strain 1.23";
    assert_eq!(report.line(), line);
}

/// The right wall of `uniaxial_small` for ten columns of 1.2 mm.
const RIGHT: [&str; 2] = ["walls.right.start=(12.0e-3, 0.0)", "walls.right.end=(12.0e-3, 54.0e-3)"];

#[test]
fn ten_diameters_across_a_rock_are_no_false_alarm_and_eight_warn() {
    let of = |sets: &[&str]| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/uniaxial_small.ron");
        let sets: Vec<_> = sets.iter().map(|set| (*set).to_owned()).collect();
        before(&crate::scene::load(&path, &sets).unwrap_or_else(|e| panic!("{e}")).scene, None)
    };
    let wide = ["specimen.columns=10", "specimen.origin=(0.0, 0.0)", RIGHT[0], RIGHT[1]];
    let report = of(&wide);
    let few = |report: &Report| report.warnings.iter().any(|w| w.contains("largest disks"));
    // 12 mm of at most 1.2 mm.
    assert!(report.disks_across.unwrap() >= 10.0, "{report:?}");
    assert!(!few(&report), "{:?}", report.warnings);
    // 8 columns of 1.2 mm.
    let narrow = of(&["specimen.columns=8", "specimen.count=320"]);
    near(narrow.disks_across, 8.0, 0.02);
    assert!(few(&narrow), "{:?}", narrow.warnings);
}

/// A specimen that is cut out of a cell is as wide as the part that is left, not as the cell.
#[test]
fn a_specimen_that_is_cut_out_counts_what_is_left() {
    for (name, across) in [("direct_tension", 12.0 / 1.2), ("brazilian", 20.0 / 1.2)] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.ron"));
        let scene = crate::scene::load(&path, &[]).unwrap_or_else(|e| panic!("{e}")).scene;
        near(before(&scene, None).disks_across, across, 0.02);
    }
}

#[test]
fn a_low_packing_counts_the_height_that_its_compaction_leaves() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/uniaxial_small.ron");
    let wide = ["specimen.columns=10", "specimen.origin=(0.0, 0.0)", RIGHT[0], RIGHT[1]];
    let sets = [&wide[..], &["specimen.count=60"]].concat().into_iter().map(str::to_owned);
    let sets: Vec<_> = sets.collect();
    let scene = crate::scene::load(&path, &sets).unwrap_or_else(|e| panic!("{e}")).scene;
    let seeds = crate::run::minerals::specimen(&scene, None);
    let area: f64 = seeds.iter().map(|s| std::f64::consts::PI * s.radius * s.radius).sum();
    let largest = seeds.iter().map(|s| s.radius).fold(0.0, f64::max);
    let height = area / ((1.0 - 0.205) * 12.0e-3);
    near(before(&scene, None).disks_across, height / (2.0 * largest), 1e-9);
}

#[test]
fn lattices_and_beams_are_no_specimens() {
    for name in ["lattice", "three_point_bending", "two_layers"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.ron"));
        let scene = crate::scene::load(&path, &[]).unwrap_or_else(|e| panic!("{e}")).scene;
        assert_eq!(before(&scene, None).disks_across, None, "{name}");
    }
}

/// The estimates before a run knew neither the grown radii nor the height after a compaction: the
/// inertial number was 1.5e-4 instead of 2.4e-4, the increment 0.385 instead of 0.571 elastic
/// strains.
#[test]
fn estimates_know_the_specimen_after_its_compaction() {
    let packed = |by: &str, analysis: &str, motion: &str| {
        let text = format!(
            r#"(version: 1, title: "t", analysis: {analysis},
            materials: {{"m": (density: 2000.0, contact: (normal_stiffness: 1e8))}},
            specimen: Packing(count: 60, columns: 6, spacing: 0.02, origin: (0.0, 0.0),
                sizes: Uniform(radius: (0.006, 0.009)), seed: 5),
            walls: [
                (name: "bottom", start: (0.0, 0.0), end: (0.12, 0.0)),
                (name: "top", start: (0.12, 0.2), end: (0.0, 0.2)),
                (name: "left", start: (0.0, 0.2), end: (0.0, 0.0)),
                (name: "right", start: (0.12, 0.0), end: (0.12, 0.2)),
            ],
            stages: [
                Compact(name: "compact", wall: "top", base: "bottom", {by} step: 4e-3,
                    agitation: 0.1, seed: 1),
                Load(name: "press", increments: 2, analysis: Static, walls: {{
                    "top": Stress(stress: 10e3, between: ("left", "right")),
                    "left": Stress(stress: 10e3, between: ("bottom", "top")),
                    "right": Stress(stress: 10e3, between: ("bottom", "top")) }}),
                Load(name: "load", increments: 3, walls: {{ "top": {motion} }}),
            ],
            measures: [
                (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
                (name: "axial_stress",
                    of: Stress(Walls(walls: ["top"], length: Between("left", "right")))),
                (name: "lateral_stress",
                    of: Stress(Walls(walls: ["left"], length: Between("bottom", "top")))),
            ])"#
        );
        from_str(&text, Path::new("t.ron"), Path::new(""), &[]).unwrap_or_else(|e| panic!("{e}"))
    };
    let radii =
        packed("by: Radii, target: Porosity(0.25),", "Dynamic(dt: 1e-4)", "Velocity(0.0, -0.01)");
    let (first, after) = (before(&radii.scene, None), measured(&radii.scene));
    near(first.inertial_number, after.inertial_number.unwrap(), 0.05);
    let height = packed("target: Porosity(0.25),", "Static", "Displacement(0.0, -2e-6)");
    let (first, after) = (before(&height.scene, None), measured(&height.scene));
    near(first.increment_over_elastic_strain, after.increment_over_elastic_strain.unwrap(), 0.05);
}

#[test]
fn a_material_that_could_be_bonded_is_not_bonded() {
    // The sand has a law for bonds, and no stage cements it.
    let mut sand = scene("1e6", "Static", "Displacement(0.0, -2e-5)");
    let rock = scene_with_bond(&mut sand);
    for report in [before(&sand, None), measured(&sand)] {
        near(report.increment_over_elastic_strain, 0.04, 0.02);
        let few = report.warnings.iter().find(|warning| warning.contains("lie across"));
        assert!(few.is_some_and(|warning| warning.contains("ASTM")), "{:?}", report.warnings);
    }
    for report in [before(&rock, None), measured(&rock)] {
        // The elastic strain at the strength is ten times that at the pressure.
        near(report.increment_over_elastic_strain, 0.004, 0.02);
        let few = report.warnings.iter().find(|warning| warning.contains("lie across"));
        assert!(few.is_some_and(|warning| warning.contains("ISRM")), "{:?}", report.warnings);
    }
}

/// A cement of 6 mm for one of 0.06 mm made 47 000 bonds on 400 disks and a modulus of 1153 GPa, without a
/// word.
#[test]
fn a_cement_that_reaches_past_neighbours_is_told() {
    let mut sand = scene("1e6", "Static", "Displacement(0.0, -2e-5)");
    let mut rock = scene_with_bond(&mut sand);
    let told = |scene: &Scene, what: &str| {
        before(scene, None).warnings.iter().any(|warning| warning.contains(what))
    };
    assert!(!told(&rock, "no neighbours"));
    if let Stage::Cement(cement) = &mut rock.stages[0] {
        cement.length = Some(0.03);
    }
    assert!(told(&rock, "stages.cement.length is 0.03 m, 3.0 mean radii"));
}

/// A coordination bonds the nearest pairs, however far apart these are.
#[test]
fn a_coordination_that_reaches_past_neighbours_is_told_by_its_longest_bond() {
    let told = |coordination: f64| {
        let mut sand = scene("1e6", "Static", "Displacement(0.0, -2e-5)");
        let mut rock = scene_with_bond(&mut sand);
        if let Stage::Cement(cement) = &mut rock.stages[0] {
            (cement.length, cement.coordination) = (None, Some(coordination));
        }
        let mut simulation = Simulation::new(&rock, None);
        simulation.step();
        after(simulation.world()).warnings.into_iter().find(|w| w.contains("longest bond"))
    };
    // Of four columns of five disks 31 pairs touch, and 24 have a gap of 0.83 radii.
    assert_eq!(told(3.1), None);
    assert!(told(4.0).is_some_and(|said| said.contains("bridges a gap of 0.83 mean radii")));
}

/// Gives the material a law for bonds of 100 kPa. The scene that is returned cements it too.
fn scene_with_bond(sand: &mut Scene) -> Scene {
    let bond = Bond {
        normal_stiffness: Some(1e6),
        tangential_stiffness: Some(1e6),
        rolling_stiffness: None,
        friction: 0.5,
        rolling_friction: 0.0,
        cohesion: 100e3,
        tensile_strength: 100e3,
        scatter: None,
    };
    for material in sand.materials.values_mut() {
        material.bond = Some(bond);
    }
    let mut rock = sand.clone();
    let cement = Cement {
        name: "cement".to_owned(),
        length: Some(1e-4),
        coordination: None,
        walls: false,
        particles: true,
        select: None,
        bond: None,
    };
    rock.stages.insert(0, Stage::Cement(cement));
    rock
}
