//! A run that goes on from any increment leaves the same bytes, whatever the scene.

use std::collections::BTreeSet;

use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;
use clastic::output::directory;

use crate::resumed::{COULOMB, load, parse, rolling_elastically, run, same_from_anywhere};

#[test]
fn elastic_rolling_moments_under_either_law_of_friction() {
    for law in ["Coulomb()", "Associated"] {
        let text = rolling_elastically().replace("Coulomb()", law);
        let records = same_from_anywhere(&parse(&text), |increment| increment % 3 == 1);
        assert!(records.len() > 15, "{law}: {}", records.len());
    }
}

/// The laws of friction; `ByAnalysis` is Coulomb's in time steps alone.
const EACH_LAW: [&str; 3] = ["ByAnalysis", "Associated", "Coulomb()"];

#[test]
fn biaxial_test_after_every_increment() {
    let loaded = load(
        "biaxial_small",
        &[
            "stages.confine.increments=3",
            "stages.load.increments=7",
            "stages.load.walls.top[1]=-0.16e-3",
            "output=(frames_every: 3)",
        ],
    );
    let records = same_from_anywhere(&loaded, |_| true);
    assert_eq!(records.len(), 10);
    assert!(records.iter().any(|o| !o.ruptures.is_empty()), "no bond broke");
}

/// The fraction that an accuracy has chosen, its estimate, and the first half of a pair whose second
/// is to come, are those of the state.
#[test]
fn increments_that_an_accuracy_chooses() {
    let sets = [
        "specimen.count=64",
        "specimen.columns=8",
        "cell.size=(0.0808, 0.0808)",
        "stages.compact.step=4.0e-3",
        "stages.confine.increments=2",
        "stages.shear.increments=6",
        "stages.shear.accuracy=0.02",
    ];
    let loaded = load("simple_shear_periodic", &sets);
    let records = same_from_anywhere(&loaded, |_| true);
    let shear: Vec<_> = records.iter().filter(|o| o.stage == "shear").collect();
    let short = shear.iter().filter(|o| o.fraction < 1.0).count();
    assert!(short >= 4 && short % 2 == 0, "{short} of {}", shear.len());
}

/// Radii that have grown are those of the state, and grow on to the same end.
#[test]
fn radius_expansion_under_either_law_of_friction() {
    for law in ["friction_law=Associated", "friction_law=Coulomb()"] {
        let sets = [
            law,
            "specimen.count=60",
            "specimen.columns=6",
            "walls.bottom.end=(0.024, 0.0)",
            "walls.right.start=(0.024, 0.0)",
            "walls.right.end=(0.024, 0.04)",
            "walls.left.start=(0.0, 0.04)",
            "walls.top.start=(0.024, 0.04)",
            "walls.top.end=(0.0, 0.04)",
            "stages.expand.target=Porosity(0.24)",
            "stages.expand.step=2.0e-4",
            "stages.press.increments=2",
        ];
        let loaded = load("radius_expansion", &sets);
        let records = same_from_anywhere(&loaded, |_| true);
        assert!(records.len() >= 6, "{law}: {}", records.len());
    }
}

/// A membrane keeps its pressure, on its way to a target too, and finds its chains again.
#[test]
fn membrane_in_place_of_walls_under_either_law_of_friction() {
    for law in ["Associated", "Coulomb()"] {
        let law = format!("friction_law={law}");
        let sets = [
            law.as_str(),
            "stages.confine.increments=2",
            "stages.wrap.increments=2",
            "stages.wrap.membranes.sides.pressure=150e3",
            "stages.load.increments=4",
            "stages.load.membranes={\"sides\": (pressure: 180e3)}",
            "stages.load.walls.top[1]=-0.3e-3",
            "reference_stage=\"wrap\"",
            "output=(frames_every: 3)",
        ];
        let loaded = load("biaxial_membrane_small", &sets);
        let records = same_from_anywhere(&loaded, |_| true);
        assert_eq!(records.len(), 8, "{law}");
        let pressures: Vec<_> = records.iter().filter_map(|o| o.lateral_stress).collect();
        for (found, expected) in
            pressures.iter().zip([175e3, 150e3, 157.5e3, 165e3, 172.5e3, 180e3])
        {
            assert!((found - expected).abs() < 1e-9 * expected, "{law}: {pressures:?}");
        }
        assert!(records[3..].iter().all(|o| o.volumetric_strain.is_some()), "{law}");
    }
}

/// Strains in a region, angles of dilation and cracks are sums over the increments before, which a
/// resumed run has: the places at the start, the strains of the last increments, and the lengths.
#[test]
fn measures_that_look_back() {
    let measures = r#"measures=[
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "lateral_strain", of: Strain(Walls("left", "right"))),
        (name: "yy", of: Strain(Region(component: Yy, min: (0.03, 0.05), max: (0.09, 0.15)))),
        (name: "dilation_rad", of: DilationAngle(over: 0.004)),
        (name: "length_m", of: Cracks(part: Length)),
        (name: "alignment", of: Cracks(part: Alignment, mode: Tension)),
    ]"#;
    let sets = [
        "version=2",
        measures,
        "stages.load.stop=[]",
        "stages.confine.increments=2",
        "stages.load.increments=7",
        "stages.load.walls.top[1]=-0.3e-3",
    ];
    let loaded = load("biaxial_small", &sets);
    let records = same_from_anywhere(&loaded, |k| [3, 4, 6, 8].contains(&k));
    assert_eq!(records.len(), 9);
    let broken = |o: &Observation| o.broken.iter().sum::<usize>();
    assert!(broken(&records[5]) > 0 && broken(&records[8]) > broken(&records[5]), "no cracks");
}

/// A run is interrupted within an avalanche: further bonds break and the row of the avalanche is
/// written after it is resumed.
#[test]
fn from_event_to_event_and_within_avalanches() {
    let loaded = load(
        "biaxial_small",
        &[
            "rupture.order=Events",
            "rupture.group=0.003",
            "rupture.density=30.0",
            "rupture.brittleness=0.0",
            "stages.confine.increments=2",
            "stages.load.increments=3",
            "stages.load.walls.top[1]=-0.45e-3",
        ],
    );
    let stops = |increment: u64| increment % 3 == 1;
    let records = same_from_anywhere(&loaded, stops);
    // After the first of them and before the second.
    let within = records.iter().filter(|o| stops(o.increment) && o.in_avalanche).count();
    assert!(within >= 2, "stopped {within} times within an avalanche, of {}", records.len());
}

/// The forces that are not yet released, and the part of a release that was halved, are state.
#[test]
fn within_gradual_releases() {
    let sets = [
        "rupture=(order: Events, avalanche: Gradual)",
        "stages.load.increments=30",
        "stages.load.walls.top[1]=-5.588e-6",
        "stages.load.stop=[StressDrop(0.2)]",
    ];
    let loaded = load("uniaxial_small", &sets);
    let mut within = Vec::new();
    run(&loaded, &tempfile::tempdir().unwrap().path().join("first"), 0, |o| {
        if o.in_avalanche {
            within.push(o.increment);
        }
    });
    assert!(within.len() >= 4, "{within:?}");
    let chosen = [within[0], within[1], within[within.len() / 2], within[within.len() - 1]];
    same_from_anywhere(&loaded, |k| chosen.contains(&k));
}

/// Increments of negative fractions, after which the next bond breaks.
#[test]
fn while_the_motion_goes_back() {
    let sets = [
        "rupture=(order: Events, snap_back: true)",
        "stages.load.increments=30",
        "stages.load.walls.top[1]=-5.588e-6",
        "stages.load.stop=[StressDrop(0.2)]",
    ];
    let loaded = load("uniaxial_small", &sets);
    let mut back = Vec::new();
    run(&loaded, &tempfile::tempdir().unwrap().path().join("first"), 0, |o| {
        if o.fraction < 0.0 {
            back.push(o.increment);
        }
    });
    assert!(back.len() >= 2, "{back:?}");
    same_from_anywhere(&loaded, |k| k == back[0] || k == back[back.len() - 1]);
}

/// Whether bonds break many together, and how far the next increment goes, is part of the state.
#[test]
fn where_many_bonds_break_together() {
    let loaded = load(
        "biaxial_small",
        &[
            "rupture.order=Events",
            "stages.confine.increments=2",
            "stages.load.increments=5",
            "stages.load.walls.top[1]=-0.45e-3",
        ],
    );
    let stops = |increment: u64| increment % 9 == 4;
    let records = same_from_anywhere(&loaded, stops);
    // One by one a single bond breaks in a fraction.
    let together = |o: &&Observation| o.fraction > 0.0 && o.ruptures.len() >= 5;
    let both = records.windows(2).filter(|pair| pair.iter().all(|o| together(&o)));
    let within = both.filter(|pair| stops(pair[0].increment)).count();
    let len = records.len();
    assert!(within >= 1, "stopped {within} times where many break together, of {len}");
}

/// A motion that a rupture releases begins with the state that was committed before it.
#[test]
fn before_motions_that_ruptures_release() {
    let sets = [
        "rupture=(order: Events, avalanche: Dynamic)",
        "specimen.count=72",
        "stages.compact.target=Porosity(0.25)",
        "stages.compact.step=2.5e-3",
        "stages.load.increments=6",
        "stages.load.walls.top[1]=-8.0e-6",
    ];
    let loaded = load("uniaxial_small", &sets);
    let mut motions = Vec::new();
    run(&loaded, &tempfile::tempdir().unwrap().path().join("first"), 0, |o| {
        if o.fraction == 0.0 && o.motion_steps > 0 {
            motions.push(o.increment);
        }
    });
    assert!(motions.len() >= 2, "{motions:?}");
    let records = same_from_anywhere(&loaded, |k| motions.contains(&(k + 1)));
    let is_released = |o: &&Observation| motions.contains(&o.increment);
    let broken = records.iter().filter(is_released).map(|o| o.ruptures.len()).sum::<usize>();
    assert!(broken > 0, "no bond broke within a motion");
}

#[test]
fn biaxial_test_whose_motion_is_followed_and_whose_increments_are_halved() {
    // A limit of throw that grains reach in many increments.
    let sets = [
        "acceptance.throw=0.01",
        "stages.confine.increments=2",
        "stages.load.increments=11",
        "stages.load.walls.top[1]=-0.2e-3",
    ];
    let loaded = load("biaxial_small", &sets);
    let records = same_from_anywhere(&loaded, |k| [7, 8, 12, 13].contains(&k));
    assert!(records.iter().any(|o| o.motion_steps > 0), "no motion was followed");
    assert!(records.iter().any(|o| o.fraction < 1.0), "nothing was halved");
}

#[test]
fn compaction_cementing_and_walls_taken_away() {
    // The left wall stays: the identity of the one that goes is not the last.
    let sets = [
        "stages.compact.step=2.5e-3",
        "stages.load.increments=8",
        "stages.load.remove_walls=[\"left\"]",
        "stages.load.walls.top[1]=-14.0e-6",
        "output=(frames_every: 5)",
    ];
    let loaded = load("uniaxial_small", &sets);
    let records = same_from_anywhere(&loaded, |k| k % 4 == 1 || k == 22);
    let stages: Vec<_> = records.iter().map(|o| o.stage.as_str()).collect();
    assert!(stages.contains(&"compact") && stages.contains(&"load"), "{stages:?}");
    assert!(records.iter().any(|o| !o.ruptures.is_empty()), "no bond broke");
}

#[test]
fn dynamic_collapse_of_a_column() {
    let sets = [
        "specimen.count=60",
        "specimen.columns=5",
        "stages.compact.target=Porosity(0.35)",
        "walls.floor.end=(70.0e-3, 0.0)",
        "walls.back.start=(0.0, 0.2)",
        "walls.gate.start=(70.0e-3, 0.0)",
        "walls.gate.end=(70.0e-3, 0.2)",
        "walls.lid.start=(70.0e-3, 0.16)",
        "walls.lid.end=(0.0, 0.16)",
        "stages.settle.increments=10",
        "stages.release.increments=40",
        "output=(frames_every: 10)",
    ];
    let loaded = load("column_collapse_small", &sets);
    let records = same_from_anywhere(&loaded, |k| k % 3 == 0);
    assert!(records.iter().any(|o| o.kinetic_energy > 0.0));
}

#[test]
fn bounce_direct_shear_and_clarabel() {
    let bounce = load("bounce", &["stages.drop.increments=60"]);
    same_from_anywhere(&bounce, |k| k % 7 == 0);
    // Loads of particles that are on their way; the bond breaks.
    let shear = load("direct_shear_10N", &[]);
    let records = same_from_anywhere(&shear, |k| k % 35 == 1);
    assert!(records.iter().any(|o| !o.ruptures.is_empty()), "the bond did not break");
    let clarabel = load("tension", &["solver=Clarabel()"]);
    same_from_anywhere(&clarabel, |k| k % 7 == 0);
}

#[test]
fn rebounds_go_on() {
    let sets = [
        "materials.stone.contact=(restitution: 0.6)",
        "walls.floor.contact=(restitution: 0.6)",
        "analysis.theta=0.5",
        "stages.drop.increments=130",
        "output=(energy: true)",
    ];
    let records = same_from_anywhere(&load("bounce", &sets), |k| k == 40 || (99..104).contains(&k));
    let energies: Vec<f64> = records.iter().map(|o| o.kinetic_energy).collect();
    assert!(energies.windows(2).any(|pair| pair[1] < 0.5 * pair[0]), "no impact");
}

#[test]
fn the_ledger_and_the_corrector_go_on() {
    let sets = ["output=(energy: true)", "corrector=(passes: 20)", "stages.drop.increments=40"];
    same_from_anywhere(&load("bounce", &sets), |k| k % 6 == 1);
    let sets = [
        "output=(energy: true)",
        "corrector=(passes: 20)",
        "stages.confine.increments=2",
        "stages.load.increments=5",
        "stages.load.walls.top[1]=-0.16e-3",
    ];
    let records = same_from_anywhere(&load("biaxial_small", &sets), |k| k % 2 == 1);
    assert!(records.iter().any(|o| o.solves > 1), "nothing was corrected");
}

/// A bond breaks under the 25th newton and nothing holds the rest; a stage follows.
const COLLAPSE: &str = r#"(
    version: 1,
    title: "two disks torn apart",
    materials: { "stone": (
        contact: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6),
        bond: (normal_stiffness: 8.0e6, tangential_stiffness: 4.0e6, cohesion: 4.0e3, tensile_strength: 2.0e3),
    ) },
    specimen: Particles([
        (position: (0.0, 0.0), radius: 6.0e-3),
        (position: (12.0e-3, 0.0), radius: 6.0e-3, probe: "pulled"),
    ]),
    bonds: [(a: 0, b: 1)],
    stages: [
        Load(name: "pull", increments: 35, particles: [
            (select: Index([0]), x: Held, y: Held, rotation: Held),
            (select: Index([1]), y: Held, rotation: Held, force: (35.0, 0.0)),
        ]),
        Load(name: "hold", increments: 5, particles: [(select: All, x: Held, y: Held, rotation: Held)]),
    ],
)"#;

#[test]
fn the_mechanism_of_a_collapse_is_of_whoever_sees_it() {
    // Before, at and after the collapse; every other time in the directory of the finished run.
    let records = same_from_anywhere(&parse(COLLAPSE), |k| [7, 8, 25, 26, 27].contains(&k));
    let collapsed = |o: &&Observation| o.status == IncrementStatus::Collapsed;
    let increments: Vec<_> = records.iter().filter(collapsed).map(|o| o.increment).collect();
    assert_eq!(increments, [25]);
    let parent = tempfile::tempdir().unwrap();
    run(&parse(COLLAPSE), parent.path(), 0, |_| {});
    assert!(parent.path().join(directory::MECHANISM).exists());
}

#[test]
fn coulomb_cascade_and_walls_that_come_and_go() {
    let records = same_from_anywhere(&parse(COULOMB), |_| true);
    assert!(records.iter().any(|o| !o.ruptures.is_empty()), "no bond broke");
    assert!(records.iter().any(|o| o.coulomb_residual > 0.0), "Coulomb's law made no difference");
    assert!(records.iter().any(|o| o.stage == "hold"), "{:?}", records.last());
}

/// A periodic cell is state: its size, its shear, its stresses and what a stage does with it.
#[test]
fn a_periodic_cell_under_both_laws() {
    for law in ["Associated", "Coulomb()"] {
        let law = format!("friction_law={law}");
        let sets = [
            law.as_str(),
            "specimen.count=64",
            "specimen.columns=8",
            "cell.size=(0.0808, 0.0808)",
            "stages.compact.step=4.0e-3",
            "stages.confine.increments=2",
            "stages.shear.increments=5",
        ];
        let records = same_from_anywhere(&load("simple_shear_periodic", &sets), |k| k % 2 == 1);
        assert!(records.iter().any(|o| o.stage == "shear" && o.fraction == 1.0));
        // With the mean stress held, in time steps.
        let mean = "stages.shear.cell=(mean: Stress(50.0e3), shear: Strain(0.02))";
        let dynamic = "stages.shear.analysis=Dynamic(dt: 1.0e-4)";
        let sets: Vec<&str> = sets.into_iter().chain([mean, dynamic]).collect();
        let records = same_from_anywhere(&load("simple_shear_periodic", &sets), |k| k % 2 == 1);
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
        assert_eq!(stages.len(), 4, "{law}");
        let flow = records.last().unwrap();
        assert!(flow.contacts > 10, "{law}: {} contacts", flow.contacts);
    }
}

/// A heap in a box from which particles are taken away twice, with bonds and without.
pub const EXCAVATION: &str = r#"(
    version: 2,
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

/// A bonded heap on a plate that turns, beside a polyline that spins, and a drum below; groups whose
/// force is measured.
pub const TURNING: &str = r#"(
    version: 2,
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
        (name: "moment_nm", of: GroupForce(select: Range(0, 7), along: Moment)),
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
    version: 2,
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

/// A load on whatever is in a strip, which rises over one stage and holds in the next.
#[test]
fn a_load_on_what_is_in_a_strip() {
    for (law, analysis) in
        EACH_LAW.into_iter().flat_map(|law| ["Static", "Dynamic(dt: 1.0e-3)"].map(|of| (law, of)))
    {
        let records = same_from_anywhere(
            &parse(&format!(
                r#"(version: 2, title: "strip", gravity: (0.0, -9.81), analysis: {analysis},
              friction_law: {law},
              materials: {{ "m": (density: 2000.0, contact: (normal_stiffness: 1.0e6, friction: 0.3)) }},
              specimen: Particles([(position: (0.0, 0.01), radius: 0.01), (position: (0.05, 0.01), radius: 0.01)]),
              walls: [(name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), probe: "floor")],
              stages: [
                Load(name: "rise", increments: 6, particles: [(select: All, x: Displacement(0.01)),
                    (select: Box(min: (0.08, -1.0), max: (0.125, 1.0)), live: true, force: (0.0, -7.0))]),
                Load(name: "hold", increments: 9, particles: [(select: All, x: Displacement(0.01)),
                    (select: Box(min: (0.08, -1.0), max: (0.125, 1.0)), live: true, force: (0.0, -5.0))]),
              ], output: (energy: true))"#
            )),
            |_| true,
        );
        assert_eq!(records.len(), 15, "{law} {analysis}");
    }
}

/// A box into which grains of two minerals are poured on a bonded block that stands there; some of
/// them are taken away, and others come through a full opening.
pub const POURED: &str = r#"(
    version: 2,
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
