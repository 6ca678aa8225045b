//! Specimens that are cut, layered, sieved, scattered or read from files: a resumed run has them as
//! they were, and does not make them again.

use std::fs;

use clastic::output::directory;
use clastic::tables::Tables;

use crate::resumed::{load, parse, run, same_from_anywhere};

const LAWS: [&str; 2] = ["friction_law=Associated", "friction_law=Coulomb()"];

/// The number of broken bonds after the last increment.
fn broken(loaded: &clastic::scene::LoadedScene, stops: impl Fn(u64) -> bool) -> usize {
    let records = same_from_anywhere(loaded, stops);
    records.last().unwrap().broken.iter().sum()
}

#[test]
fn shipped_specimens_under_either_law_of_friction() {
    for law in LAWS {
        let beam = [law, "let.strength=0.05e6", "stages.bend.increments=8"];
        assert!(broken(&load("notched_beam", &beam), |k| k % 3 == 1) > 0, "{law}");
        let pulled = [law, "stages.pull.increments=6", "let.strength=2.0e5"];
        assert!(broken(&load("scatter", &pulled), |k| k % 4 == 1) > 0, "{law}");
        broken(&load("two_layers", &[law, "stages.press.increments=3"]), |k| k == 2);
        let sieved = [
            law,
            "specimen.count=60",
            "walls.top.start[1]=0.0243",
            "walls.top.end[1]=0.0243",
            "walls.left.start[1]=0.0243",
            "walls.right.end[1]=0.0243",
            "stages.compact.target=Porosity(0.27)",
            "stages.press.increments=3",
        ];
        broken(&load("sieve_curve", &sieved), |k| k % 4 == 1);
    }
}

/// A packing by a sieve curve, cut to a disk with a hole and a notch, with lumps of a mineral, a
/// layer and scattered bonds.
const ALL: &str = r#"(
    version: 1, title: "all", rupture: (rolling: Yields),
    materials: {
        "matrix": (contact: (normal_stiffness: 1.0e7, tangential_stiffness: 5.0e6, friction: 0.3),
            bond: (normal_stiffness: 1.0e7, tangential_stiffness: 5.0e6, friction: 0.5, cohesion: 2.0e4,
                tensile_strength: 1.0e4,
                scatter: (seed: 4, strength: Weibull(modulus: 3.0), stiffness: LogNormal(deviation: 0.2)))),
        "mica": (contact: (normal_stiffness: 4.0e6, tangential_stiffness: 2.0e6, friction: 0.1),
            bond: (normal_stiffness: 4.0e6, tangential_stiffness: 2.0e6, friction: 0.2, cohesion: 1.0e4,
                tensile_strength: 5.0e3)),
        "band": (contact: (normal_stiffness: 1.0e7, tangential_stiffness: 5.0e6, friction: 0.3),
            bond: (normal_stiffness: 1.0e7, tangential_stiffness: 5.0e6, friction: 0.5, cohesion: 4.0e4,
                tensile_strength: 2.0e4)),
    },
    specimen: Packing(count: 100, columns: 10, spacing: 0.0205, origin: (0.0, 0.0), material: "matrix",
        sizes: Sieve(passing: [(0.016, 0.0), (0.018, 40.0), (0.02, 100.0)]), seed: 9),
    minerals: [
        (material: "mica", select: Union([Circle(centre: (0.05, 0.07), radius: 0.03),
            Circle(centre: (0.14, 0.13), radius: 0.03)])),
        (material: "band", select: Layer(normal: (0.0, 1.0), from: 0.08, to: 0.12)),
    ],
    keep: Except(Circle(centre: (0.1, 0.1), radius: 0.1),
        Union([Circle(centre: (0.1, 0.1), radius: 0.02), Box(min: (0.09, 0.17), max: (0.11, 0.3))])),
    walls: [
        (name: "bottom", start: (-0.1, 0.0), end: (0.3, 0.0)),
        (name: "top", start: (0.3, 0.205), end: (-0.1, 0.205)),
    ],
    stages: [
        Cement(name: "cement", length: 8.0e-3),
        Load(name: "press", increments: 3, walls: { "top": Displacement(0.0, -1.0e-3) },
            particles: [(select: Box(min: (0.0, 0.0), max: (0.2, 0.02)), x: Held, rotation: Held)]),
    ],
    measures: [
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "fragments", of: Fragments(Number)), (name: "length_m", of: Cracks(part: Length)),
        (name: "a", of: Fabric(component: Anisotropy)), (name: "z", of: Coordination(rattlers: false)),
    ],
)"#;

#[test]
fn a_specimen_of_everything_under_either_law_of_friction() {
    for law in ["Associated", "Coulomb()"] {
        let text = ALL.replacen("version: 1,", &format!("version: 1, friction_law: {law},"), 1);
        let loaded = parse(&text);
        assert!(broken(&loaded, |_| true) > 0, "{law}");
    }
}

/// Scattered strengths belong to the pairs: bonds that are made after a saved state was read are those
/// of a run in one piece.
#[test]
fn bonds_that_are_made_after_a_state_scatter_as_in_one_piece() {
    let parent = tempfile::tempdir().unwrap();
    let (cut, hold) = (
        "    minerals: [",
        r#"Load(name: "hold", increments: 1, particles: [(select: All, x: Held, y: Held, rotation: Held)])"#,
    );
    let cement = r#"Cement(name: "cement", length: 8.0e-3)"#;
    let stages = ALL.split_once("    stages: [").unwrap();
    let measures = stages.1.split_once("    measures: [").unwrap().1;
    let of = |specimen: &str, stages: &str| {
        let head = ALL.split_once("    specimen: ").unwrap().0;
        parse(&format!("{head}    specimen: {specimen} stages: [{stages}], measures: [{measures}"))
    };
    let (_, rest) = ALL.split_once("    specimen: ").unwrap();
    let (own, _) = rest.split_once("    stages: [").unwrap();
    assert!(own.contains(cut.trim()));
    let [one, a, b] = ["one", "a", "b"].map(|name| parent.path().join(name));
    run(&of(own, &format!("{hold}, {cement}")), &one, 0, |_| {});
    run(&of(own, &format!("{hold}, Save(name: \"kept\")")), &a, 0, |_| {});
    let kept = a.join("state_kept.npz");
    let state = format!("State(path: {:?}),", kept.display().to_string());
    run(&of(&state, cement), &b, 0, |_| {});
    let bonds = |directory: &std::path::Path| {
        let bytes = fs::read(directory.join(directory::FINAL_STATE)).unwrap();
        let state = Tables::decode(&bytes).unwrap();
        let n = state.rows("bonds.id").unwrap();
        let strength = state.values::<f64>("bonds.tensile_strength_pa", &[n]).unwrap().to_vec();
        let a = state.values::<u32>("bonds.a", &[n]).unwrap().to_vec();
        (a, state.values::<u32>("bonds.b", &[n]).unwrap().to_vec(), strength)
    };
    let (whole, part) = (bonds(&one), bonds(&b));
    assert!(whole == part);
    // They do scatter.
    let mut different: Vec<u64> = whole.2.iter().map(|s| s.to_bits()).collect();
    different.sort_unstable();
    different.dedup();
    assert!(different.len() > 30, "{}", different.len());
}

/// Positions, radii, materials and groups of a file.
#[test]
fn an_imported_specimen_with_groups_under_either_law_of_friction() {
    let parent = tempfile::tempdir().unwrap();
    let file = parent.path().join("grains.csv");
    let mut rows = "x_m,y_m,radius_m,material,group\n".to_owned();
    for k in 0..30 {
        let (x, y) = (0.01 + 0.02 * f64::from(k % 5), 0.01 + 0.02 * f64::from(k / 5));
        let material = if k % 3 == 0 { "soft" } else { "hard" };
        let group = if k >= 25 { "top" } else { "rest" };
        rows += &format!("{x:?},{y:?},0.01,{material},{group}\n");
    }
    fs::write(&file, rows).unwrap();
    for law in ["Associated", "Coulomb()"] {
        let loaded = parse(&format!(
            r#"(version: 1, title: "file", friction_law: {law}, gravity: (0.0, -9.81),
            analysis: Dynamic(dt: 1.0e-3),
            materials: {{
                "hard": (contact: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, friction: 0.5)),
                "soft": (contact: (normal_stiffness: 1.0e5, tangential_stiffness: 1.0e5, friction: 0.2)) }},
            specimen: File(path: {:?}),
            walls: [
                (name: "floor", start: (-0.1, 0.0), end: (0.3, 0.0), contact: (friction: 0.5)),
                (name: "left", start: (0.0, 0.3), end: (0.0, 0.0)),
            ],
            stages: [Load(name: "push", increments: 8, particles: [
                (select: Group("top"), force: (40.0, 0.0))])],
            measures: [
                (name: "top_n", of: GroupForce(select: Group("top"))),
                (name: "z", of: Coordination()), (name: "kinetic_j", of: KineticEnergy),
            ])"#,
            file.display().to_string()
        ));
        let records = same_from_anywhere(&loaded, |_| true);
        assert_eq!(records.len(), 8);
        assert!(records[7].kinetic_energy > 0.0, "{law}");
    }
}
