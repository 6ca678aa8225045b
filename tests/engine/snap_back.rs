//! The imposed motion goes back after a rupture (`snap_back: true`): assemblies with exact answers,
//! with increments of any size.

use crate::common::*;
use clastic::components::attempt::IncrementStatus;
use clastic::components::energy::EnergyLedger;
use clastic::components::findings::EventSearch;
use clastic::components::observation::Observation;
use clastic::run::Simulation;

/// Stiffness of every bond in all directions, N/m: so high that lengths change by 1e-7 at most.
const STIFFNESS: f64 = 1.0e11;
/// Radius of the middle disk and of those that pull it, m.
const LARGE: f64 = 24.0e-3;
/// Radius of the disks that hold it, m.
const SMALL: f64 = 3.0e-3;
/// Tensile strength of their bonds, N; others hold eight times as much.
const STRENGTH: f64 = 12.0;
const TOLERANCE: f64 = 1e-7;

/// A large disk at the origin that small ones hold under the angles `holders` (degrees, from the
/// negative x axis), and large disks at `others`, numbered after them. All disks move along x
/// alone. Bonds have the same stiffness in all directions, so that all holders carry the same force
/// along x, and the bond under an angle breaks at `STRENGTH/cos`.
fn pulled(holders: &[f64], others: &[[f64; 2]], bonds: &str, stages: &str) -> Simulation {
    let mut disks = format!("(position: (0.0, 0.0), radius: {LARGE:?}),");
    let mut all_bonds = bonds.to_owned();
    for (k, angle) in holders.iter().enumerate() {
        let (sin, cos) = angle.to_radians().sin_cos();
        let reach = LARGE + SMALL;
        disks +=
            &format!("(position: ({:?}, {:?}), radius: {SMALL:?}),", -reach * cos, reach * sin);
        all_bonds += &format!("(a: 0, b: {}),", k + 1);
    }
    for (k, [x, y]) in others.iter().enumerate() {
        disks += &format!("(position: ({x:?}, {y:?}), radius: {LARGE:?}, probe: \"{k}\"),");
    }
    let text = format!(
        "(
            version: 1,
            title: \"pulled and let back\",
            rupture: (order: Events, tolerance: {TOLERANCE:?}, snap_back: true),
            output: (energy: true),
            materials: {{ \"glue\": (
                contact: (normal_stiffness: {STIFFNESS:?}),
                bond: (normal_stiffness: {STIFFNESS:?}, tangential_stiffness: {STIFFNESS:?}, cohesion: 1.0e9, tensile_strength: {:?}),
            ) }},
            specimen: Particles([{disks}]),
            bonds: [{all_bonds}],
            stages: [{stages}],
        )",
        STRENGTH / (2.0 * SMALL),
    );
    Simulation::new(&parse(&text), None)
}

/// A chain of three bonds pulls at parallel bonds of graded strength S_j. With n - j + 1 of them
/// left, F_j = (n - j + 1) S_j and u_j = (3 F_j + S_j)/k. Of one bond, the weakest of a chain, the
/// energy F u/2 is lost; of several a part returns to what pulls.
#[test]
fn parallel_bonds_in_a_soft_chain_let_the_motion_back_at_any_increment() {
    let angles = [0.0, 30.0, -45.0, 60.0];
    for count in [1, 2, 4] {
        let strengths: Vec<f64> =
            angles[..count].iter().map(|a: &f64| STRENGTH / a.to_radians().cos()).collect();
        let path: Vec<[f64; 2]> = (0..count)
            .map(|j| {
                let force = (count - j) as f64 * strengths[j];
                [(3.0 * force + strengths[j]) / STIFFNESS, force]
            })
            .collect();
        assert!(path.windows(2).all(|pair| pair[1][0] < pair[0][0]), "{path:?}");
        for increments in [1, 7, 40] {
            let pull = 1.3 * path[0][0] / f64::from(increments);
            let chain = [1.0, 2.0, 3.0].map(|k| [2.0 * LARGE * k, 0.0]);
            let (first, last) = (count + 1, count + 3);
            let bonds = format!(
                "(a: 0, b: {first}), (a: {first}, b: {}), (a: {}, b: {last}),",
                first + 1,
                first + 1
            );
            let held: Vec<_> = (1..=count).map(|k| k.to_string()).collect();
            let stage = format!(
                "Load(name: \"pull\", increments: {increments}, particles: [
                    (select: All, y: Held, rotation: Held),
                    (select: Index([{}]), x: Held),
                    (select: Index([{last}]), x: Displacement({pull:?})),
                ])",
                held.join(", ")
            );
            let mut simulation = pulled(&angles[..count], &chain, &bonds, &stage);
            let mut at = 0.0;
            let mut event = 0;
            let mut returned = 0.0;
            for record in run(&mut simulation, &mut returned) {
                at += record.fraction * pull;
                if !record.ruptures.is_empty() {
                    let [u, force] = path[event];
                    assert_relative(at, u, 1e-6);
                    assert_relative(probe(&record, "2").force[0], force, 1e-6);
                    assert_eq!(record.ruptures.len(), 1);
                    assert_eq!(record.ruptures[0].bond.0, 3 + event as u32);
                    assert!(!record.in_avalanche && (record.fraction < 0.0) == (event > 0));
                    event += 1;
                }
            }
            assert_eq!(event, count, "{increments} increments");
            let trapezoid = |a: [f64; 2], b: [f64; 2]| 0.5 * (a[1] + b[1]) * (b[0] - a[0]);
            let back: f64 = path.windows(2).map(|pair| trapezoid(pair[0], pair[1])).sum();
            let total = simulation.world().resource::<EnergyLedger>().total;
            let unit = trapezoid([0.0; 2], path[0]);
            assert_within(returned, back, 1e-6 * unit);
            assert_within(total.external, unit + back, 1e-6 * unit);
            // The bonds take f^2/2k; all else has been motion.
            let taken: f64 = strengths.iter().map(|s| s * s / (2.0 * STIFFNESS)).sum();
            assert_within(total.rupture, taken, 1e-6 * unit);
            assert_within(total.motion, unit + back - taken, 1e-6 * unit);
        }
    }
}

/// Runs to the end: the observations of all increments. Adds the work of those that go back.
fn run(simulation: &mut Simulation, returned: &mut f64) -> Vec<Observation> {
    let mut records = Vec::new();
    while let Some(record) = step(simulation) {
        assert_eq!(record.status, IncrementStatus::Solved);
        if record.fraction < 0.0 {
            *returned += simulation.world().resource::<EnergyLedger>().increment.external;
        }
        records.push(record);
    }
    records
}

/// The disk is pulled by one disk in a first stage, and by another one in the second. When the
/// first bond has broken the first pull alone, which stays, is too much for the second bond: with
/// both pulls u_1 and u_2 the disk moves by (u_1 + u_2)/4, then by (u_1 + u_2)/3.
#[test]
fn without_a_root_the_avalanche_runs_at_constant_motion() {
    // In units of u_1: u_2 = 0.1 at the first rupture, and the second bond holds 0.3 < 1/3.
    let unit = STRENGTH / 0.275 / STIFFNESS;
    let second = -(0.275_f64 / 0.3).acos().to_degrees();
    let (sin, cos) = 75.0_f64.to_radians().sin_cos();
    let others = [[2.0 * LARGE, 0.0], [2.0 * LARGE * cos, 2.0 * LARGE * sin]];
    let stage = |name: &str, increments: u32, x: [String; 2]| {
        format!(
            "Load(name: \"{name}\", increments: {increments}, particles: [
                (select: All, y: Held, rotation: Held),
                (select: Index([1, 2]), x: Held),
                (select: Index([3]), x: {}),
                (select: Index([4]), x: {}),
            ]),",
            x[0], x[1]
        )
    };
    let held = || "Held".to_owned();
    for increments in [2, 9] {
        let pull = 0.15 * unit / f64::from(increments);
        let stages = stage("first", 3, [format!("Displacement({:?})", unit / 3.0), held()])
            + &stage("second", increments, [held(), format!("Displacement({pull:?})")]);
        let mut simulation =
            pulled(&[0.0, second], &others, "(a: 0, b: 3), (a: 0, b: 4),", &stages);
        let mut no_roots = Vec::new();
        let mut records = Vec::new();
        while let Some(record) = step(&mut simulation) {
            assert_eq!(record.status, IncrementStatus::Solved);
            no_roots.push(simulation.world().resource::<EventSearch>().no_root);
            records.push(record);
        }
        let first = records.iter().position(|r| !r.ruptures.is_empty()).unwrap();
        let reached: f64 = records[3..=first].iter().map(|r| r.fraction * pull).sum();
        assert_relative(reached, 0.1 * unit, 1e-4);
        let broken = |k: usize| -> Vec<u32> {
            records[first + k].ruptures.iter().map(|r| r.bond.0).collect()
        };
        assert_eq!([broken(0), broken(1), broken(2)], [vec![2], vec![3], vec![]]);
        assert!(records.iter().all(|r| r.fraction >= 0.0));
        assert!(no_roots[first + 1] && no_roots.iter().filter(|no| **no).count() == 1);
        assert!(records[first + 1].in_avalanche && records[first + 1].fraction == 0.0);
    }
}

/// The bonds that break at the peak of a rock let its platen back. The peak is that of the same rock
/// without this option.
#[test]
fn a_rock_lets_its_platen_back() {
    let path = format!("{}/scenes/uniaxial_small.ron", env!("CARGO_MANIFEST_DIR"));
    let sets = [
        "rupture=(order: Events, snap_back: true)",
        "stages.load.stop=[StressDrop(0.3)]",
        "stages.load.increments=30",
        "stages.load.walls.top[1]=-5.588e-6",
    ];
    let sets = sets.map(str::to_owned);
    let loaded = clastic::scene::load(std::path::Path::new(&path), &sets).unwrap();
    let mut simulation = Simulation::new(&loaded.scene, None);
    let mut backward = 0;
    let (mut peak, mut last) = (0.0_f64, (0.0, 0.0));
    while let Some(record) = step(&mut simulation) {
        assert_eq!(record.status, IncrementStatus::Solved);
        let (Some(strain), Some(stress)) = (record.axial_strain, record.axial_stress) else {
            continue;
        };
        peak = peak.max(stress);
        if record.fraction < 0.0 {
            assert!(strain < last.0 && stress < last.1, "{strain} {stress} after {last:?}");
            assert!(!record.in_avalanche && record.ruptures.len() == 1);
            backward += 1;
        }
        if !record.in_avalanche {
            last = (strain, stress);
        }
    }
    assert!(backward >= 3, "{backward}");
    assert_relative(peak, 177.04e6, 1e-3);
}

/// Three chains of four disks hold a crosshead, and a soft chain of three disks pulls it. With n
/// chains left, one of which breaks at S, the pull has moved by n S/k_s + S/k_f.
fn bundle(throw: f64) -> Simulation {
    let bond = |stiffness: f64, strength: f64| {
        format!(
            "bond: (normal_stiffness: {stiffness:?}, tangential_stiffness: {stiffness:?}, friction: 0.3,
                cohesion: 1.0e9, tensile_strength: {strength:?})"
        )
    };
    let material = |name: &str, bond: String| {
        format!(
            "\"{name}\": (contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8), {bond}),"
        )
    };
    let mut materials = material("strong", bond(2.0e7, 1.0e9))
        + &material("head", bond(1.0e15, 1.0e9))
        + &material("soft", bond(1.0e7, 1.0e9));
    let mut disks = String::new();
    let mut disk = |x: f64, y: f64, more: &str| {
        disks += &format!("(position: ({x:?}e-3, {y:?}e-3), radius: 1.0e-3, {more}),");
    };
    for (name, x, strength) in [("a", -4.0, 1.0e6), ("b", 0.0, 1.1e6), ("c", 4.0, 1.5e6)] {
        materials += &material(name, bond(2.0e7, strength));
        disk(x, 1.0, &format!("material: \"{name}\""));
        for y in [3.0, 5.0, 7.0] {
            disk(x, y, "material: \"strong\"");
        }
    }
    for x in [-4.0, -2.0, 0.0, 2.0, 4.0] {
        disk(x, 9.0, "material: \"head\", group: \"head\"");
    }
    for y in [11.0, 13.0, 15.0] {
        disk(0.0, y, "material: \"soft\"");
    }
    let wall = |name: &str, start: (f64, f64), end: (f64, f64)| {
        format!(
            "(name: \"{name}\", start: {start:?}, end: {end:?}, probe: \"{name}\",
                contact: (normal_stiffness: 1.0e8), {}),",
            bond(1.0e15, 1.0e9)
        )
    };
    let walls = wall("floor", (-6.0e-3, 0.0), (6.0e-3, 0.0))
        + &wall("grip", (6.0e-3, 16.0e-3), (-6.0e-3, 16.0e-3));
    let text = format!(
        "(
            version: 1,
            title: \"bundle\",
            rupture: (snap_back: true),
            acceptance: (throw: {throw:?}),
            materials: {{ {materials} }},
            specimen: Particles([{disks}]),
            walls: [{walls}],
            stages: [
                Cement(name: \"glue\", length: 1.0e-6, walls: true),
                Load(name: \"pull\", increments: 100, walls: {{ \"grip\": Displacement(0.0, 20.0e-6) }},
                    rigid: {{ \"crosshead\": (select: Group(\"head\"), rotation: Held) }}),
            ],
        )"
    );
    Simulation::new(&parse(&text), None)
}

/// A broken chain springs back, which throws its disks in the trial at the standing motion. That
/// trial has an error of the regularisation and still shows how far the motion goes back.
#[test]
fn a_chain_that_springs_back_lets_the_motion_back() {
    let mut simulation = bundle(0.3);
    let strengths = [2000.0, 2200.0, 3000.0];
    let [soft, chain] = [1.0 / 4.0e6, 0.175e-6];
    let mut at = 0.0;
    let mut event = 0;
    while let Some(record) = step(&mut simulation) {
        assert_eq!(record.status, IncrementStatus::Solved);
        at += record.fraction * 20.0e-6;
        if !record.ruptures.is_empty() {
            let force = f64::from(3 - event) * strengths[event as usize];
            assert_relative(at, force * soft + strengths[event as usize] * chain, 1e-6);
            assert_relative(probe(&record, "grip").force[1].abs(), force, 1e-6);
            assert_eq!((record.ruptures.len(), record.motion_steps), (1, 0));
            event += 1;
        }
    }
    assert_eq!(event, 3);
}

/// Where the way back throws disks as well, it is given up, and the search says so.
#[test]
fn a_way_back_that_throws_disks_has_no_root() {
    let mut simulation = bundle(0.2);
    let mut no_roots = 0;
    while let Some(record) = step(&mut simulation) {
        assert_eq!(record.status, IncrementStatus::Solved);
        assert!(record.fraction >= 0.0);
        no_roots += u32::from(simulation.world().resource::<EventSearch>().no_root);
    }
    assert!(no_roots > 0);
}
