//! Place, extent and released energy of avalanches, by hand; and a rock that remembers its load.

use std::collections::BTreeMap;
use std::path::Path;

use clastic::components::increment::RuptureRules;
use clastic::scene;

use crate::call::{rows, run, run_with};
use crate::common::{assert_relative, assert_within};

/// Stiffness of every bond, N/m. Bonds break in tension at 2 kPa: at 12 N where the smaller disk
/// has a radius of 3 mm.
const STIFFNESS: f64 = 1.0e7;

type Row = BTreeMap<String, String>;

/// The first avalanche of disks that only move along the free directions of `controls`.
fn first(disks: &str, bonds: &str, controls: &str, rule: &str, energy: bool) -> Row {
    let text = format!(
        "(
            version: 1,
            title: \"glued disks\",
            rupture: (order: Events, avalanche: {rule}),
            output: (plots: false, energy: {energy}),
            materials: {{ \"glue\": (
                contact: (normal_stiffness: {STIFFNESS:?}),
                bond: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?}, cohesion: 1.0e9, tensile_strength: 2.0e3),
            ) }},
            specimen: Particles([{disks}]),
            bonds: [{bonds}],
            stages: [Load(name: \"pull\", increments: 7, particles: [
                (select: All, y: Held, rotation: Held), {controls}
            ])],
        )"
    );
    let loaded = scene::from_str(&text, Path::new("disks.ron"), Path::new(""), &[]);
    let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
    let out = run_with(&loaded, |world| world.resource_mut::<RuptureRules>().tolerance = 1.0e-7);
    rows(out.path(), "avalanches.csv").swap_remove(0)
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {:?}", row[column]))
}

/// Every rule of an avalanche, with and without the energy ledger.
fn each() -> impl Iterator<Item = (&'static str, bool)> {
    ["MostOverloaded", "Dynamic"].into_iter().flat_map(|rule| [(rule, false), (rule, true)])
}

/// Three springs in a row between two held ends: the weakest breaks at 12 N.
#[test]
fn a_chain_between_held_ends_releases_all_that_it_has_stored() {
    let disks =
        "(position: (0.0, 0.0), radius: 5.0e-3), (position: (11.0e-3, 0.0), radius: 6.0e-3),
        (position: (22.0e-3, 0.0), radius: 5.0e-3), (position: (30.0e-3, 0.0), radius: 3.0e-3)";
    let bonds = "(a: 0, b: 1), (a: 1, b: 2), (a: 2, b: 3)";
    let controls = "(select: Index([0]), x: Held), (select: Index([3]), x: Displacement(0.7e-6))";
    for (rule, energy) in each() {
        let row = first(disks, bonds, controls, rule, energy);
        assert_relative(number(&row, "released_j"), 3.0 * 144.0 / (2.0 * STIFFNESS), 1e-6);
        // The contact has moved by less than the whole chain has lengthened, 3.6 um.
        assert_within(number(&row, "x_m"), 27.0e-3, 3.6e-6);
        assert_eq!([number(&row, "y_m"), number(&row, "extent_m")], [0.0, 0.0]);
    }
}

/// A force F pushes a disk between two others, to which it is glued. At F/2 = 12 N the bond behind
/// it breaks. The one in front of it then carries F alone, so that the disk goes on by F/2k: the
/// elastic energy rises from F^2/4k to F^2/2k, and the force does the work F^2/2k.
#[test]
fn a_constant_load_gives_more_than_the_specimen_keeps() {
    let disks = "(position: (0.0, 0.0), radius: 3.0e-3), (position: (8.0e-3, 0.0), radius: 5.0e-3),
        (position: (18.0e-3, 0.0), radius: 5.0e-3)";
    let bonds = "(a: 0, b: 1), (a: 1, b: 2)";
    let controls = "(select: Index([0, 2]), x: Held), (select: Index([1]), force: (30.0, 0.0))";
    let unit = 24.0_f64.powi(2) / (4.0 * STIFFNESS);
    for (rule, energy) in each() {
        let row = first(disks, bonds, controls, rule, energy);
        assert_relative(number(&row, "elastic_energy_before_j"), unit, 1e-6);
        assert_relative(number(&row, "elastic_energy_after_j"), 2.0 * unit, 1e-6);
        if energy {
            assert_relative(number(&row, "released_j"), unit, 1e-6);
        } else {
            assert_eq!(row["released_j"], "", "the work is not known");
        }
    }
}

/// Two bonds break while a disk is pulled: one under 30 degrees (12 N, 0.5 k u^2) and one of a row
/// of two behind it, which carries u too. All 1.875 k u^2 are released.
#[test]
fn an_avalanche_of_two_bonds_lies_half_way_between_them() {
    let (c, s) = (0.75_f64.sqrt(), 0.5);
    let disks = format!(
        "(position: (24.0e-3, 0.0), radius: 12.0e-3), (position: (0.0, 0.0), radius: 12.0e-3),
         (position: ({:?}, {:?}), radius: 3.0e-3), (position: (-14.5e-3, 0.0), radius: 2.5e-3),
         (position: (-19.0e-3, 0.0), radius: 2.0e-3)",
        -15.0e-3 * c,
        15.0e-3 * s
    );
    let bonds = "(a: 0, b: 1), (a: 1, b: 2), (a: 1, b: 3), (a: 3, b: 4)";
    let controls =
        "(select: Index([2, 4]), x: Held), (select: Index([0]), x: Displacement(0.6e-6))";
    for (rule, energy) in each() {
        let row = first(&disks, bonds, controls, rule, energy);
        // The contact points are at 12 mm under 30 degrees and at -17 mm; they move by some um.
        assert_eq!(row["broken_tension"], "2", "{rule}");
        assert_within(number(&row, "x_m"), -0.5 * (12.0e-3 * c + 17.0e-3), 5.0e-6);
        assert_within(number(&row, "y_m"), 3.0e-3, 5.0e-6);
        let apart = f64::hypot(17.0e-3 - 12.0e-3 * c, 6.0e-3);
        assert_within(number(&row, "extent_m"), 0.5 * apart, 5.0e-6);
        let unit = 144.0 / 0.75 / STIFFNESS;
        assert_relative(number(&row, "released_j"), 1.875 * unit, 1e-4);
    }
}

/// What an emission releases is what bonds, friction, motions and the scheme take by the ledger, up
/// to a per cent: its elastic energy is that of the true geometry. And the Kaiser effect:
/// rock emits nothing while it is unloaded, and when it is loaded again nothing before the largest
/// stress that it has borne.
#[test]
fn rock_releases_what_the_ledger_takes_and_is_silent_below_the_stress_it_has_borne() {
    let (done, out) = run("acoustic_emission", &["--quiet", "--set", "output.energy=true"]);
    done.code(0);
    let history = rows(out.path(), "history.csv");
    let emissions = rows(out.path(), "avalanches.csv");
    let taken = |row: &Row| {
        [
            "friction",
            "rolling",
            "dilation",
            "collision",
            "rupture",
            "motion",
            "turning",
            "numerical",
        ]
        .iter()
        .map(|part| number(row, &format!("energy_{part}_j")))
        .sum::<f64>()
    };
    let mut compared = 0;
    for emission in &emissions {
        // An emission that ends an increment within another one has no row of its own before it.
        let at = history.iter().position(|row| row["increment"] == emission["increment"]);
        let Some(k) = at else { continue };
        let after = history[k + 1..].iter().find(|row| row["fraction"] == "0.0").unwrap();
        // The energy of the first bond is booked where it reaches its limit.
        let first = |row: &Row| number(row, "energy_rupture_j");
        let expected =
            taken(after) - taken(&history[k]) + first(&history[k]) - first(&history[k - 1]);
        // The difference of stored energies has their round-off.
        let stored = number(emission, "elastic_energy_before_j");
        let apart = (number(emission, "released_j") - expected).abs();
        assert!(apart < 1e-2 * expected + 1e-6 * stored, "{apart} of {expected} J");
        compared += 1;
    }
    assert!(compared > 50, "{compared}");

    let of = |stage: &str| emissions.iter().filter(|row| row["stage"] == stage).collect::<Vec<_>>();
    let mut borne = 0.0;
    for cycle in 1..=4 {
        let loading = of(&format!("load_{cycle}"));
        assert!(loading.len() > 5, "{} emissions in loading {cycle}", loading.len());
        let onset = number(loading[0], "axial_stress_before_pa");
        assert!(onset > 0.98 * borne, "{onset} after {borne} in loading {cycle}");
        assert!(of(&format!("unload_{cycle}")).is_empty());
        borne = 1.0e8 * (0.7 + 0.3 * f64::from(cycle));
    }
}
