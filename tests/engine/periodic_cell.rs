//! Periodic cells: moduli of a lattice in closed form, imposed stresses, invariance.

use std::f64::consts::PI;
use std::fmt::Write;

use clastic::components::cell::PeriodicCell;
use clastic::components::contact::Bodies;
use clastic::run::measures::reading;
use clastic::run::{Outcome, Simulation};
use clastic::scene::format::{
    FabricComponent, Measure, Network, Quantity, Scene, Strain, StrainComponent,
};

use crate::common::{next, parse};

const RADIUS: f64 = 5.0e-3;
const NORMAL: f64 = 3.0e7;
const TANGENTIAL: f64 = 1.0e7;

/// Settings and measures of all scenes here.
fn scene(particles: &str, size: [f64; 2], friction: f64, more: &str, stages: &str) -> Scene {
    let [width, height] = size;
    parse(&format!(
        r#"(
    version: 2, title: "cell",
    materials: {{ "sand": (density: 2650.0, contact: (normal_stiffness: {NORMAL:?},
        tangential_stiffness: {TANGENTIAL:?}, friction: {friction:?})) }},
    specimen: {particles},
    cell: (size: ({width:?}, {height:?})),
    {more}
    stages: [{stages}],
    measures: [
        (name: "axial_strain", of: Strain(Cell(Height))),
        (name: "lateral_strain", of: Strain(Cell(Width))),
        (name: "axial_stress", of: Stress(Average(component: Yy, area: Cell))),
        (name: "lateral_stress", of: Stress(Average(component: Xx, area: Cell))),
        (name: "shear_strain", of: Strain(Cell(Shear))),
        (name: "shear_stress", of: Stress(Average(component: Shear, area: Cell))),
        (name: "porosity", of: Porosity(Cell)),
    ],
)"#
    ))
}

/// Touching disks of a triangular lattice, row by row from a place, and the size of their cell.
fn lattice(columns: u32, rows: u32, origin: [f64; 2]) -> (String, [f64; 2]) {
    let (d, row_height) = (2.0 * RADIUS, 3.0_f64.sqrt() * RADIUS);
    let mut list = String::from("Particles([");
    for row in 0..rows {
        for column in 0..columns {
            let x = origin[0] + d * (f64::from(column) + 0.5 * f64::from(row % 2));
            let y = origin[1] + row_height * f64::from(row);
            let _ = write!(list, "(position: ({x:?}, {y:?}), radius: {RADIUS:?}), ");
        }
    }
    (list + "])", [d * f64::from(columns), row_height * f64::from(rows)])
}

/// xx, yy and shear of the stress (Pa) and of the strain after the last increment.
fn state(simulation: &Simulation) -> [[f64; 3]; 2] {
    // Strains exist from the reference stage on.
    let read = |name: &str| reading(simulation.world(), name).unwrap_or(f64::NAN);
    [
        ["lateral_stress", "axial_stress", "shear_stress"].map(read),
        ["lateral_strain", "axial_strain", "shear_strain"].map(read),
    ]
}

/// The state after every increment.
fn run(scene: &Scene) -> Vec<[[f64; 3]; 2]> {
    let mut simulation = Simulation::new(scene, None);
    let mut states = Vec::new();
    while next(&mut simulation).is_some() {
        states.push(state(&simulation));
    }
    assert_eq!(simulation.run(), Outcome::Completed);
    states
}

fn assert_near(found: [f64; 3], expected: [f64; 3], size: f64, tolerance: f64) {
    for (x, y) in found.iter().zip(expected) {
        assert!((x - y).abs() <= tolerance * size, "{found:?} instead of {expected:?}");
    }
}

/// The energy of three contacts per disk, each with the normal part n.e.n and the tangential part
/// t.e.n of the strain e, is that of an isotropic medium: with k the stiffnesses and thickness 1 m
/// `sigma_xx = sqrt(3)/4 ((3 k_n + k_t) e_xx + (k_n - k_t) e_yy)`, likewise yy, and
/// `G = sqrt(3)/4 (k_n + k_t)`.
fn elastic(e: [f64; 3]) -> [f64; 3] {
    let unit = 0.25 * 3.0_f64.sqrt();
    let (along, across) = (unit * (3.0 * NORMAL + TANGENTIAL), unit * (NORMAL - TANGENTIAL));
    let shear = unit * (NORMAL + TANGENTIAL);
    [along * e[0] + across * e[1], across * e[0] + along * e[1], shear * e[2]]
}

/// With all strains imposed the stresses are those of the closed form: in the first increment from
/// touching disks, and in further ones by their change. Contacts hold as rough ones.
#[test]
fn imposed_strains_of_a_lattice() {
    let (disks, size) = lattice(5, 6, [0.0, 0.0]);
    let e = 1.0e-3;
    let stages = format!(
        r#"Load(name: "a", increments: 1, cell: (xx: Strain({e:?}), yy: Strain({e:?}))),
        Load(name: "b", increments: 1, cell: (yy: Strain({e:?}))),
        Load(name: "c", increments: 1, cell: (shear: Strain({e:?}))),"#
    );
    let states = run(&scene(&disks, size, 100.0, "", &stages));
    let first = elastic([e, e, 0.0]);
    assert_near(states[0][0], first, first[0], 1e-10);
    // Later increments find other lengths: branches and area have shrunk, and so have the sides that
    // strains refer to; normals have turned.
    let [stress, _] = states[1];
    let more = elastic([0.0, e, 0.0]);
    let expected = [first[0] + more[0], first[1] + more[1], 0.0];
    assert_near(stress, expected, first[0], 2.0 * e);
    let shear = states[2][0][2] - states[1][0][2];
    assert!((shear / elastic([0.0, 0.0, e])[2] - 1.0).abs() < 3.0 * e, "{shear:e}");
    let strain = states[2][1][2];
    assert!((strain - e).abs() < 1e-15, "{strain:e}");
}

/// Under imposed stresses the strains of the first increment are those of the closed form.
#[test]
fn imposed_stresses_of_a_lattice() {
    let (disks, size) = lattice(4, 6, [0.0, 0.0]);
    let e = [0.8e-3, 1.1e-3, 0.2e-3];
    let s = elastic(e);
    let stages = format!(
        r#"Load(name: "a", increments: 1,
            cell: (xx: Stress({:?}), yy: Stress({:?}), shear: Stress({:?}))),"#,
        s[0], s[1], s[2]
    );
    let states = run(&scene(&disks, size, 100.0, "", &stages));
    assert_near(states[0][0], s, s[0], 1e-10);
    assert_near(states[0][1], e, e[0], 1e-10);
}

/// Another origin, and a cell with four times as many disks, have the same stresses in mixed
/// control.
#[test]
fn a_lattice_anywhere_and_of_any_size() {
    let stages = r#"Load(name: "a", increments: 3,
        cell: (xx: Stress(40.0e3), yy: Strain(1.0e-3), shear: Strain(0.5e-3))),"#;
    let run = |columns, rows, origin| {
        let (disks, size) = lattice(columns, rows, origin);
        run(&scene(&disks, size, 0.5, "", stages))
    };
    let expected = run(4, 6, [0.0, 0.0]);
    for states in [run(4, 6, [0.0123, -7.31]), run(8, 12, [0.0, 0.0])] {
        for (found, expected) in states.iter().zip(&expected) {
            assert_near(found[0], expected[0], expected[0][1], 1e-9);
            assert_near(found[1], expected[1], 1e-3, 1e-9);
        }
    }
}

/// A compacted packing of random disks under a confining stress that is then sheared.
fn packing(seed: u64, more: &str) -> Scene {
    let disks = format!(
        "Packing(count: 100, columns: 10, spacing: 10.1e-3,
            sizes: Uniform(radius: (3.0e-3, 5.0e-3)), seed: {seed})"
    );
    let stages = format!(
        r#"Compact(name: "compact", target: Porosity(0.2), step: 2.0e-3, agitation: 0.1,
            seed: {seed}),
        Load(name: "confine", increments: 3,
            cell: (xx: Stress(50.0e3), yy: Stress(80.0e3), shear: Stress(0.0))),
        Load(name: "shear", increments: 15, cell: (shear: Strain(0.01))),"#
    );
    scene(&disks, [0.101, 0.101], 0.4, more, &stages)
}

/// The compaction reaches its porosity; stresses that are imposed are the average stresses of Love
/// and Weber at every increment, to the residual, with either friction law and either solver.
#[test]
fn imposed_stresses_of_packings() {
    let laws = [("", 1e-9), ("friction_law: Coulomb(),", 1e-8), ("solver: Clarabel(),", 1e-8)];
    for seed in [1, 2] {
        for (more, tolerance) in laws {
            let scene = packing(seed, more);
            let mut simulation = Simulation::new(&scene, None);
            let (mut porosity, mut in_stage) = (f64::NAN, 0);
            while let Some(record) = next(&mut simulation) {
                let world = simulation.world();
                let cell = *world.resource::<PeriodicCell>();
                if record.stage == "compact" {
                    let radii = &world.resource::<Bodies>().radii;
                    porosity = 1.0 - radii.iter().map(|r| PI * r * r).sum::<f64>() / cell.area();
                    continue;
                }
                in_stage += 1;
                // The loads are on their way up to the third increment.
                if in_stage >= 3 {
                    let [stress, _] = state(&simulation);
                    let shear = if in_stage == 3 { 0.0 } else { stress[2] };
                    assert_near(stress, [50.0e3, 80.0e3, shear], 80.0e3, tolerance);
                    assert_near(cell.stress, stress, 80.0e3, 1e-8);
                }
            }
            assert_eq!(simulation.run(), Outcome::Completed, "seed {seed}, {more}");
            assert!((porosity - 0.2).abs() < 1e-9, "{porosity}");
            assert_eq!(in_stage, 18);
            let [stress, _] = state(&simulation);
            assert!(stress[2] > 4.0e3, "{stress:?}");
        }
    }
}

/// With the volume held the mean stress is a result, and the width and the height stay.
#[test]
fn shear_at_constant_volume() {
    let mut scene = packing(3, "");
    let load = crate::common::stage(&mut scene, "shear");
    let control = load.cell.as_mut().unwrap();
    control.xx = Some(clastic::scene::format::CellTarget::Fixed);
    control.yy = Some(clastic::scene::format::CellTarget::Fixed);
    let mut simulation = Simulation::new(&scene, None);
    let mut sizes = Vec::new();
    while let Some(record) = next(&mut simulation) {
        if record.stage == "shear" {
            let cell = simulation.world().resource::<PeriodicCell>();
            sizes.push([cell.width, cell.height]);
        }
    }
    assert_eq!(sizes.len(), 15);
    assert!(sizes.iter().all(|size| *size == sizes[0]), "{sizes:?}");
    let [stress, strain] = state(&simulation);
    assert!((strain[2] - 0.01).abs() < 1e-12, "{strain:?}");
    assert!((stress[1] - 80.0e3).abs() > 1e3, "{stress:?}");
}

/// Fabric, and the strain that fits best, of a lattice that strains evenly: contacts across the
/// sides of the cell have the normals of those inside it, at any place of the lattice.
#[test]
fn fabric_and_strain_of_particles_across_the_sides() {
    let (e, corner) = (1.0e-3, (-1.0, -1.0));
    let stages = format!(
        r#"Load(name: "a", increments: 1, cell: (xx: Strain({e:?}), yy: Strain({:?}))),
        Load(name: "b", increments: 1, cell: (shear: Strain({e:?}))),"#,
        2.0 * e
    );
    // Gradient of the places: shortened first, then sheared.
    let gradient = [[1.0 - e, e * (1.0 - 2.0 * e)], [0.0, 1.0 - 2.0 * e]];
    let [mut xx, mut yy, mut xy] = [0.0; 3];
    for angle in [0.0, PI / 3.0, 2.0 * PI / 3.0] {
        let (sin, cos) = f64::sin_cos(angle);
        let [x, y] = gradient.map(|row| row[0] * cos + row[1] * sin);
        let square = x * x + y * y;
        xx += x * x / square / 3.0;
        yy += y * y / square / 3.0;
        xy += x * y / square / 3.0;
    }
    let strain =
        |component| Quantity::Strain(Strain::Region { component, min: corner, max: (1.0, 1.0) });
    let fabric = |component| Quantity::Fabric { component, network: Network::All };
    let shear = 0.5 * gradient[0][1];
    let expected = [
        ("f_xx", fabric(FabricComponent::Xx), xx),
        ("f_yy", fabric(FabricComponent::Yy), yy),
        ("f_xy", fabric(FabricComponent::Xy), xy),
        ("e_xx", strain(StrainComponent::Xx), e),
        ("e_yy", strain(StrainComponent::Yy), 2.0 * e),
        ("e_xy", strain(StrainComponent::Xy), -shear),
        ("rotation", strain(StrainComponent::Rotation), -shear),
    ];
    for origin in [[0.0, 0.0], [0.013, -0.021]] {
        let (disks, size) = lattice(5, 6, origin);
        let mut scene = scene(&disks, size, 100.0, r#"reference_stage: "a","#, &stages);
        let further = expected.iter().map(|(name, of, _)| (*name, of.clone()));
        let further = further.map(|(name, of)| Measure { name: name.to_owned(), of });
        scene.measures.list.as_mut().unwrap().extend(further);
        let mut simulation = Simulation::new(&scene, None);
        while next(&mut simulation).is_some() {}
        for (name, _, value) in &expected {
            let found = reading(simulation.world(), name).unwrap();
            assert!((found - value).abs() < 1e-9, "{name}: {found} instead of {value}");
        }
    }
}
