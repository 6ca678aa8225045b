//! A run that goes on from any increment leaves the same bytes, whatever the scene.

use clastic::components::attempt::IncrementStatus;
use clastic::components::observation::Observation;
use clastic::output::directory;

use crate::resumed::{
    COULOMB, load, load_small_cell, parse, rolling_elastically, run, same_from_anywhere,
};

#[test]
fn elastic_rolling_moments_under_either_law_of_friction() {
    for law in ["Coulomb()", "Associated"] {
        let text = rolling_elastically().replace("Coulomb()", law);
        let records = same_from_anywhere(&parse(&text), |increment| increment % 3 == 1);
        assert!(records.len() > 15, "{law}: {}", records.len());
    }
}

/// The laws of friction; `ByAnalysis` is Coulomb's in time steps alone.
pub const EACH_LAW: [&str; 3] = ["ByAnalysis", "Associated", "Coulomb()"];

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

/// The search of an `Until` is no part of the state.
#[test]
fn an_increment_that_an_until_cuts() {
    let sets =
        ["stages.shear.increments=48", "stages.shear.stop=[Until(\"shear_stress_pa\", 12.0e3)]"];
    let loaded = load_small_cell(&sets);
    let records = same_from_anywhere(&loaded, |_| true);
    let shear: Vec<_> = records.iter().filter(|o| o.stage == "shear").collect();
    let sum: f64 = shear.iter().map(|o| o.fraction).sum();
    // Without the `Until` the stage ends with a whole increment.
    let is_cut = sum < 48.0 && sum.fract() > 1e-6;
    assert!(shear.len() >= 2 && is_cut, "{sum} in {}", shear.len());
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
            "rupture.density=30.0",
            "rupture.brittleness=0.0",
            "stages.confine.increments=2",
            "stages.load.increments=3",
            "stages.load.walls.top[1]=-0.33e-3",
        ],
    );
    let stops = |increment: u64| increment % 3 == 1;
    let records = same_from_anywhere(&loaded, stops);
    // After the first of them and before the second.
    let within = records.iter().filter(|o| stops(o.increment) && o.in_avalanche).count();
    assert!(within >= 2, "stopped {within} times within an avalanche, of {}", records.len());
}

/// In each equilibrium of these avalanches one bond breaks. The run is interrupted at the start, in
/// the middle and at the end of its avalanches.
#[test]
fn within_avalanches_of_one_bond_at_a_time() {
    let sets = [
        "rupture=(order: Events, density: 30.0, brittleness: 0.0)",
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
fn biaxial_test_whose_motion_is_followed() {
    // A limit that contacts reach in many increments.
    let sets = [
        "acceptance.turn=0.001",
        "stages.confine.increments=2",
        "stages.load.increments=11",
        "stages.load.walls.top[1]=-0.2e-3",
    ];
    let loaded = load("biaxial_small", &sets);
    let records = same_from_anywhere(&loaded, |k| [8, 12].contains(&k));
    assert!(records.iter().any(|o| o.motion_steps > 0), "no motion was followed");
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
fn the_ledger_and_the_passes_go_on() {
    let sets = ["output=(energy: true)", "stages.drop.increments=40"];
    same_from_anywhere(&load("bounce", &sets), |k| k % 6 == 1);
    let sets = [
        "output=(energy: true)",
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
fn coulomb_ruptures_and_walls_that_come_and_go() {
    let records = same_from_anywhere(&parse(COULOMB), |_| true);
    assert!(records.iter().any(|o| !o.ruptures.is_empty()), "no bond broke");
    assert!(records.iter().any(|o| o.coulomb_residual > 0.0), "Coulomb's law made no difference");
    assert!(records.iter().any(|o| o.stage == "hold"), "{:?}", records.last());
}

/// A grain that is set aside stays so: a resumed run would otherwise let it fall again.
#[test]
fn a_grain_that_is_set_aside() {
    let loaded = parse(
        "(version: 1, title: \"a disk beside a floor\", gravity: (0.0, -9.81),
          materials: { \"rock\": (density: 2000.0, contact: (normal_stiffness: 1.0e8, friction: 0.5)) },
          specimen: Particles([
            (position: (0.0, 0.1), radius: 0.1), (position: (0.0, 0.3), radius: 0.1),
            (position: (1.0, 0.5), radius: 0.1)]),
          walls: [(name: \"floor\", shape: Segment, start: (-0.3, 0.0), end: (0.3, 0.0),
            contact: (normal_stiffness: 1.0e8, friction: 0.5))],
          stages: [Load(name: \"weight\", increments: 3), Save(name: \"kept\"),
            Load(name: \"more\", increments: 2, gravity: (0.0, -20.0))])",
    );
    let records = same_from_anywhere(&loaded, |_| true);
    let steps: Vec<_> = records.iter().map(|o| o.motion_steps).collect();
    assert!(steps[0] > 0 && steps[1..].iter().all(|n| *n == 0), "{steps:?}");
}
