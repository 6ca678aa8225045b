//! Measures of ten disks, placed by hand, against numbers from sums over their pairs and closed
//! formulas: the stresses of parts, forces, porosity, coordination, fabric, ruptures, energies and
//! the dilation angle. `measures.rs` has strains, fragments and mean stresses.

use std::f64::consts::PI;

use clastic::components::energy::EnergyLedger;
use clastic::run::Simulation;
use clastic::run::measures::reading;
use clastic::scene::format::Scene;
use glam::DVec2;

use crate::common::{assert_relative, assert_within, next, parse};

/// Normal and shear stiffness, N/m; thickness, m; strain of the increment.
const K: [f64; 2] = [1.0e6, 0.4e6];
const H: f64 = 0.5;
const E: f64 = 1.0e-5;

/// Rows of 3, 4 and 2 touching disks of 1 m, and one that touches the end of the second row only.
fn ten() -> Vec<DVec2> {
    let row = |n: usize, x: f64, y: f64| (0..n).map(move |i| DVec2::new(x + 2.0 * i as f64, y));
    let h = 3.0_f64.sqrt();
    let alone = DVec2::new(5.0 + 2.0_f64.sqrt(), h - 2.0_f64.sqrt());
    row(3, 0.0, 0.0).chain(row(4, -1.0, h)).chain(row(2, 0.0, 2.0 * h)).chain([alone]).collect()
}

/// Displacement of the affine field.
fn moved(x: DVec2) -> DVec2 {
    DVec2::new(-E * x.x + 0.5 * E * x.y, -2.0 * E * x.y)
}

/// A pair that touches, and the force on its second disk.
struct Pair {
    ids: (usize, usize),
    n: DVec2,
    p: f64,
    q: f64,
}

impl Pair {
    fn force(&self) -> DVec2 {
        self.p * self.n + self.q * self.n.perp()
    }
}

fn pairs(disks: &[DVec2]) -> Vec<Pair> {
    let all = (0..10).flat_map(|i| (i + 1..10).map(move |j| (i, j)));
    all.filter_map(|(i, j)| {
        let l = disks[j] - disks[i];
        (l.length() < 2.1).then(|| {
            let (n, u) = (l.normalize(), moved(disks[j]) - moved(disks[i]));
            Pair { ids: (i, j), n, p: -K[0] * u.dot(n), q: -K[1] * u.dot(n.perp()) }
        })
    })
    .collect()
}

fn after_one(scene: &Scene) -> Simulation {
    let mut simulation = Simulation::new(scene, None);
    next(&mut simulation).unwrap();
    simulation
}

/// The disks follow the field. The floor comes E, the roof 2 E closer to its row, and the sides
/// leave by 3 E.
fn pressed() -> Simulation {
    let list: Vec<_> =
        ten().iter().map(|x| format!("(position: ({:?}, {:?}), radius: 1.0)", x.x, x.y)).collect();
    let law = format!("normal_stiffness: {:?}, tangential_stiffness: {:?}", K[0], K[1]);
    let top = 2.0 * 3.0_f64.sqrt() + 1.0;
    after_one(&parse(&format!(
        r#"(
        version: 1, title: "ten disks", thickness: {H:?},
        materials: {{ "m": (contact: ({law}, friction: 10.0)) }},
        specimen: Particles([{}]),
        walls: [
            (name: "floor", start: (-3.0, -1.0), end: (9.0, -1.0), contact: ({law})),
            (name: "roof", start: (9.0, {top:?}), end: (-3.0, {top:?}), contact: ({law})),
            (name: "left", start: (-3.0, {top:?}), end: (-3.0, -1.0)),
            (name: "right", start: (9.0, -1.0), end: (9.0, {top:?})),
        ],
        stages: [Load(name: "press", increments: 1,
            walls: {{
                "floor": Displacement(0.0, {E:?}), "roof": Displacement(0.0, {:?}),
                "left": Displacement({:?}, 0.0), "right": Displacement({:?}, 0.0) }},
            particles: [(select: All, rotation: Held, affine: (({:?}, {:?}), (0.0, {:?})))])],
        measures: [
            (name: "axial_strain", of: Strain(Walls("floor", "roof"))),
            (name: "lateral_strain", of: Strain(Walls("left", "right"))),
            (name: "floor_pa", of: Stress(Walls(walls: ["floor"], length: Fixed(8.0)))),
            (name: "both_pa",
                of: Stress(Walls(walls: ["floor", "roof"], length: Between("left", "right")))),
            (name: "floor_n", of: WallForce(wall: "floor")),
            (name: "roof_y_n", of: WallForce(wall: "roof", along: Y)),
            (name: "below_xx", of: Stress(Region(component: Xx, min: (-3.0, -1.5), max: (9.0, 0.2)))),
            (name: "below_yy", of: Stress(Region(component: Yy, min: (-3.0, -1.5), max: (9.0, 0.2)))),
            (name: "below_xy", of: Stress(Region(component: Xy, min: (-3.0, -1.5), max: (9.0, 0.2)))),
            (name: "all_yy", of: Stress(Average(component: Yy, area: Fixed(40.0)))),
            (name: "row_x_n", of: GroupForce(select: Index([0, 1, 2]))),
            (name: "row_y_n", of: GroupForce(select: Index([0, 1, 2]), along: Y)),
            (name: "row_nm", of: GroupForce(select: Index([0, 1, 2]), along: Moment)),
            (name: "n_fixed", of: Porosity(Fixed(40.0))),
            (name: "n_box", of: Porosity(Box(("floor", "roof"), ("left", "right")))),
            (name: "z", of: Coordination()), (name: "z_m", of: Coordination(rattlers: false)),
            (name: "f_xx", of: Fabric(component: Xx)), (name: "f_yy", of: Fabric(component: Yy)),
            (name: "f_xy", of: Fabric(component: Xy)), (name: "a", of: Fabric(component: Anisotropy)),
            (name: "at", of: Fabric(component: Direction)),
            (name: "strong a", of: Fabric(component: Anisotropy, network: Strong)),
            (name: "last", of: Front(along: X, share: 1.0)), (name: "low", of: Front(along: Y, share: 0.25)),
            (name: "psi", of: DilationAngle()), (name: "elastic_j", of: ElasticEnergy),
            (name: "kinetic_j", of: KineticEnergy), (name: "quiet", of: KineticOverElastic),
        ],
    )"#,
        list.join(", "),
        -2.0 * E * (top - 1.0) - 2.0 * E,
        -3.0 * E,
        3.0 * E,
        -E,
        0.5 * E,
        -2.0 * E
    )))
}

#[test]
fn forces_stresses_and_energies_of_ten_pressed_disks_are_those_by_hand() {
    let (disks, simulation) = (ten(), pressed());
    let pairs = pairs(&disks);
    assert_eq!(pairs.len(), 17);
    let near = |name: &str, expected: f64| {
        let found = reading(simulation.world(), name).unwrap_or(f64::NAN);
        assert!((found - expected).abs() <= 1e-4 * expected.abs(), "{name}: {found} {expected}");
    };
    // The disks follow the field. Three of ten lie in the lowest row.
    near("last", disks.iter().map(|x| (*x + moved(*x)).x).fold(0.0, f64::max));
    assert!(reading(simulation.world(), "low").unwrap().abs() < 1e-9);
    // Three disks at the floor, two at the roof.
    let (floor, roof) = (3.0 * K[0] * E, 2.0 * K[0] * 2.0 * E);
    near("floor_n", floor);
    near("roof_y_n", -roof);
    near("floor_pa", floor / (8.0 * H));
    near("both_pa", 0.5 * (floor + roof) / (12.0 * H));

    // Branches up to y = 0.2: those along the lowest row, 0.2 / sqrt(3) of those to the next one,
    // and those to the floor. The one of the disk at the end begins above.
    let mut below = [0.0; 3];
    for pair in &pairs {
        let (a, l) = (disks[pair.ids.0], 2.0 * pair.n);
        let part = match l.y.abs() < 1e-9 {
            true => f64::from(a.y < 0.2),
            false if a.y == 0.0 => 0.2 / l.y,
            false => 0.0,
        };
        let f = pair.force();
        let sums = [f.x * l.x, f.y * l.y, 0.5 * (f.x * l.y + f.y * l.x)];
        below.iter_mut().zip(sums).for_each(|(sum, s)| *sum += part * s);
    }
    below[1] += floor;
    let volume = 12.0 * 1.7 * H;
    near("below_xx", below[0] / volume);
    near("below_yy", below[1] / volume);
    near("below_xy", below[2] / volume);
    let inner: f64 = pairs.iter().map(|pair| pair.force().y * 2.0 * pair.n.y).sum();
    near("all_yy", (inner + floor + roof) / (40.0 * H));

    // The second row and the floor act on the first.
    let (mut force, mut moment) = (DVec2::new(0.0, floor), 0.0);
    for pair in pairs.iter().filter(|pair| pair.ids.0 < 3 && pair.ids.1 >= 3) {
        let arm = disks[pair.ids.0] + pair.n - DVec2::new(2.0, 0.0);
        force -= pair.force();
        moment -= arm.perp_dot(pair.force());
    }
    near("row_x_n", force.x);
    near("row_y_n", force.y);
    near("row_nm", moment);

    let energy = |pair: &Pair| 0.5 * (pair.p * pair.p / K[0] + pair.q * pair.q / K[1]);
    let at_walls = 0.5 * K[0] * (3.0 * E * E + 2.0 * 4.0 * E * E);
    near("elastic_j", pairs.iter().map(energy).sum::<f64>() + at_walls);
    for name in ["kinetic_j", "quiet"] {
        assert_eq!(reading(simulation.world(), name), Some(0.0), "{name}");
    }
}

#[test]
fn the_structure_of_ten_pressed_disks_is_that_by_hand() {
    let simulation = pressed();
    let value = |name: &str| reading(simulation.world(), name).unwrap_or(f64::NAN);
    let pairs = pairs(&ten());
    // Seventeen pairs and five contacts with walls; the disk at the end has one contact.
    assert_relative(value("z"), 39.0 / 10.0, 1e-14);
    assert_relative(value("z_m"), 38.0 / 9.0, 1e-14);
    assert_relative(value("n_fixed"), 1.0 - 10.0 * PI / 40.0, 1e-12);
    let height = (2.0 * 3.0_f64.sqrt() + 2.0) * (1.0 - 2.0 * E) + E;
    assert_relative(value("n_box"), 1.0 - 10.0 * PI / (height * (12.0 + 6.0 * E)), 1e-9);

    let fabric = |list: &[&Pair]| {
        let mean = |of: fn(DVec2) -> f64| {
            list.iter().map(|pair| of(pair.n)).sum::<f64>() / list.len() as f64
        };
        [mean(|n| n.x * n.x), mean(|n| n.y * n.y), mean(|n| n.x * n.y)]
    };
    let anisotropy = |[xx, yy, xy]: [f64; 3]| 2.0 * (xx - yy).hypot(2.0 * xy);
    let all: Vec<_> = pairs.iter().collect();
    let [xx, yy, xy] = fabric(&all);
    for (name, expected) in
        [("f_xx", xx), ("f_yy", yy), ("f_xy", xy), ("a", anisotropy([xx, yy, xy]))]
    {
        assert_within(value(name), expected, 4.0 * E);
    }
    // The small tensor has a direction that a strain turns more.
    let at = (0.5 * (2.0 * xy).atan2(xx - yy)).rem_euclid(PI);
    assert_within(value("at"), at, 100.0 * E);
    let mean = pairs.iter().map(|pair| pair.p.abs()).sum::<f64>() / 17.0;
    let strong: Vec<_> = pairs.iter().filter(|pair| pair.p.abs() > mean).collect();
    assert!((3..15).contains(&strong.len()), "{}", strong.len());
    assert_within(value("strong a"), anisotropy(fabric(&strong)), 4.0 * E);

    // Logarithmic strains of the box, whose height falls and whose width grows.
    let axial = -(height / (2.0 * 3.0_f64.sqrt() + 2.0)).ln();
    let lateral = -(0.5 * E).ln_1p();
    assert_within(value("psi"), (-(axial + lateral) / (axial - lateral).abs()).asin(), 1e-6);
}

/// Five pairs, of which two break in tension, one in shear and one in rolling.
#[test]
fn ruptures_cracks_and_fragments_of_ten_disks_are_those_by_hand() {
    let scene = parse(
        r#"(
        version: 1, title: "five pairs", rupture: (rolling: Breaks, order: OneRound),
        materials: { "m": (contact: (normal_stiffness: 1.0e6), bond: (normal_stiffness: 1.0e6,
            tangential_stiffness: 1.0e6, friction: 0.5, rolling_friction: 0.1, cohesion: 1.0e3, tensile_strength: 1.0e3)) },
        specimen: Particles([
            (position: (0.0, 0.0), radius: 1.0), (position: (3.0, 0.0), radius: 2.0),
            (position: (0.0, 9.0), radius: 1.0),
            (position: (1.4142135623730951, 10.414213562373096), radius: 1.0),
            (position: (0.0, 18.0), radius: 0.5), (position: (1.5, 18.0), radius: 1.0),
            (position: (0.0, 27.0), radius: 1.0), (position: (0.0, 29.0), radius: 1.0),
            (position: (0.0, 36.0), radius: 1.0), (position: (2.0, 36.0), radius: 1.0),
        ]),
        bonds: [(a: 0, b: 1), (a: 2, b: 3), (a: 4, b: 5), (a: 6, b: 7), (a: 8, b: 9)],
        stages: [Load(name: "part", increments: 9, particles: [
            (select: Index([0, 2, 4, 6, 8]), x: Held, y: Held, rotation: Held),
            (select: Index([1]), x: Displacement(1.0e-3), y: Held, rotation: Held),
            (select: Index([3]), x: Displacement(1.0e-3), y: Displacement(1.0e-3), rotation: Held),
            (select: Index([5]), x: Held, y: Displacement(1.0e-3), rotation: Held),
            (select: Index([7]), x: Held, y: Displacement(-1.0e-5), rotation: Displacement(1.0e-4)),
            (select: Index([9]), x: Displacement(-1.0e-5), y: Held, rotation: Held),
        ])],
        measures: [
            (name: "all", of: Broken(All)), (name: "tension", of: Broken(Tension)),
            (name: "shear", of: Broken(Shear)), (name: "rolling", of: Broken(Rolling)),
            (name: "share", of: BrokenShare(All)), (name: "share in tension", of: BrokenShare(Tension)),
            (name: "fragments", of: Fragments(Number)), (name: "largest", of: Fragments(Largest)),
            (name: "heaviest", of: Fragments(LargestShare)), (name: "single", of: Fragments(Single)),
            (name: "length", of: Cracks(part: Length)),
            (name: "pulled", of: Cracks(part: Length, mode: Tension)),
            (name: "along", of: Cracks(part: Direction)), (name: "alike", of: Cracks(part: Alignment)),
            (name: "z", of: Coordination()), (name: "z_m", of: Coordination(rattlers: false)),
        ],
    )"#,
    );
    let mut simulation = Simulation::new(&scene, None);
    while next(&mut simulation).is_some() {}
    let value = |name: &str| reading(simulation.world(), name);
    for (name, expected) in [
        ("all", 4.0),
        ("tension", 2.0),
        ("shear", 1.0),
        ("rolling", 1.0),
        ("share", 0.8),
        ("share in tension", 0.4),
        ("fragments", 9.0),
        ("largest", 2.0),
        ("single", 8.0),
        // Diameters of 2, 2, 1 and 2 m.
        ("length", 7.0),
        ("pulled", 4.0),
        // The last two pairs are pressed.
        ("z", 0.4),
    ] {
        assert_within(value(name).unwrap(), expected, 1e-12);
    }
    assert_eq!(value("z_m"), None);
    // The disk of 2 m against two of 1 m; seven of 1, one of 0.5 and one of 2 m among all.
    assert_relative(value("heaviest").unwrap(), 4.0 / (8.0 + 4.0 + 0.25), 1e-12);
    // Axes across 0, 45, 0 and 90 degrees, by length: twice the angle is that of a sum of vectors.
    let (x, y) = (-2.0 - 1.0 + 2.0, -2.0_f64);
    let along = (0.5 * y.atan2(x)).rem_euclid(PI);
    assert_within(value("along").unwrap(), along, 1e-3);
    assert_relative(value("alike").unwrap(), x.hypot(y) / 7.0, 1e-3);
}

/// Ten disks of 3 m spacing with these materials, walls, stages and settings, with the ledger.
fn apart(settings: &str) -> Scene {
    let list: Vec<_> = (0..10)
        .map(|k| format!("(position: ({:?}, 1.0), radius: 1.0)", 3.0 * f64::from(k)))
        .collect();
    parse(&format!(
        r#"(version: 1, title: "ten apart", thickness: {H:?}, gravity: (0.0, -9.81),
        specimen: Particles([{}]), output: (energy: true), {settings},
        measures: [
            (name: "kinetic", of: KineticEnergy), (name: "t", of: Time),
            (name: "elastic", of: ElasticEnergy), (name: "quiet", of: KineticOverElastic),
        ])"#,
        list.join(", ")
    ))
}

/// Mass of ten disks, kg.
const MASS: f64 = 10.0 * 2000.0 * PI * H;

#[test]
fn energies_of_ten_falling_disks_are_those_by_hand() {
    let scene = apart(
        r#"analysis: Dynamic(dt: 1.0e-2, theta: 0.5), materials: { "m": (density: 2000.0) },
        stages: [Load(name: "fall", increments: 20)]"#,
    );
    let mut simulation = Simulation::new(&scene, None);
    let mut rows = 0;
    while next(&mut simulation).is_some() {
        rows += 1;
        let value = |name: &str| reading(simulation.world(), name);
        let t = value("t").unwrap();
        assert_relative(t, 1.0e-2 * f64::from(rows), 1e-12);
        let energy = 0.5 * MASS * (9.81 * t).powi(2);
        let of = &simulation.world().resource::<EnergyLedger>().total;
        for found in [value("kinetic").unwrap(), of.kinetic, of.gravity] {
            assert_relative(found, energy, 1e-9);
        }
        for found in [of.external, of.friction, of.rupture, of.error()] {
            assert!(found.abs() < 1e-9 * energy, "{of:?}");
        }
        assert_eq!((value("elastic"), value("quiet")), (Some(0.0), None));
    }
    assert_eq!(rows, 20);
}

#[test]
fn friction_of_ten_disks_that_slide_is_weight_times_way_by_hand() {
    let scene = apart(
        r#"friction_law: Coulomb(), materials: { "m": (density: 2000.0) },
        walls: [(name: "floor", start: (-9.0, 0.0), end: (99.0, 0.0), contact: (friction: 0.5))],
        stages: [Load(name: "slide", increments: 4,
            particles: [(select: All, x: Displacement(0.1), rotation: Held)])]"#,
    );
    let mut simulation = Simulation::new(&scene, None);
    let mut way = 0.0;
    while next(&mut simulation).is_some() {
        way += 0.1;
        let of = &simulation.world().resource::<EnergyLedger>().total;
        let work = 0.5 * MASS * 9.81 * way;
        assert_relative(of.friction, work, 1e-6);
        assert_relative(of.external, work, 1e-6);
        assert!(of.gravity.abs() < 1e-6 * work && of.error().abs() < 1e-6 * work);
    }
    assert_within(way, 0.4, 1e-12);
}
